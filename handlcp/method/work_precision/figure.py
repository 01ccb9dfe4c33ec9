"""What accuracy costs, as a picture: error against time, error against faces, and what an effect left out does.

Each scene is a row of panels.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from handlcp.errors import InputError
from handlcp.method.accuracy.result import AccuracyCost
from handlcp.method.work_precision.faces_panel import faces_panel
from handlcp.method.work_precision.left_out_panel import left_out_panel
from handlcp.method.work_precision.time_panel import time_panel
from handlcp.show.file import Figure, checked, new_figure, write
from handlcp.show.style import GREY, INK, SMALL, TEXT

WIDTH, ROW, FOOT, DPI = 9.5, 4.2, 0.42, 160  # inches, dots an inch
HEAD = 12.5  # points

Costs = AccuracyCost | tuple[str, AccuracyCost] | Sequence[tuple[str, AccuracyCost]]


def save(costs: Costs, path: Any) -> Path:
    """Draw and write a file; see `draw`. Raises InputError for an unknown format or a folder that does not exist."""
    file = checked(path)
    return write(draw(costs), file, DPI)


def draw(costs: Costs) -> Figure:
    """The figure. costs : one study, (title, study), or several. Raises InputError; Unsupported without matplotlib."""
    scenes = _scenes(costs)
    inches = ROW * len(scenes) + FOOT
    figure = new_figure(figsize=(WIDTH, inches), dpi=100)
    for k, (title, cost) in enumerate(scenes):
        top = inches - ROW * k
        figure.text(
            0.012, (top - 0.08) / inches, title, fontsize=HEAD, weight="bold", color=INK, va="top", parse_math=False
        )
        figure.text(0.012, (top - 0.36) / inches, f"{cost.summary}.", fontsize=TEXT, color=INK, va="top")
        _row(figure, cost, (top - 3.72) / inches, 2.95 / inches)
    c = scenes[0][1].conditions
    note = (
        "Lines: each method's best settings, with quartiles; faint: all faces and tolerances. "
        "Above the dotted line decades are drawn higher.\n"
        "Errors are against the certified equilibrium on the exact cone. "
        f"handlcp {c.handlcp}, Python {c.python}, {c.machine}, {c.processors} processors, {c.date[:10]}."
    )
    figure.text(0.012, 0.06 / inches, note, fontsize=SMALL, color=GREY, va="bottom", linespacing=1.3)
    return figure


def _row(figure: Any, cost: AccuracyCost, bottom: float, height: float) -> None:
    """The panels of one scene, as far as it has data for them."""
    effects, pyramids = bool(cost.left_out), any(r.section != "exact" for r in cost.rows)
    end = (0.507 if effects else 0.597) if pyramids else (0.735 if effects else 0.98)
    time_panel(figure.add_axes((0.082, bottom, end - 0.082, height)), cost)
    if pyramids:
        right = 0.689 if effects else 0.909
        faces_panel(figure.add_axes((end + 0.071, bottom, right - end, height)), cost)
    if effects:
        left_out_panel(figure.add_axes((0.785, bottom, 0.2, height)), cost)


def _scenes(costs: Any) -> list[tuple[str, AccuracyCost]]:
    """(title, study) for each row. Raises InputError."""
    if isinstance(costs, AccuracyCost):
        return [("", costs)]
    found = [costs] if isinstance(costs, tuple) and costs and isinstance(costs[0], str) else costs
    pairs = isinstance(found, (list, tuple)) and all(isinstance(c, tuple) and len(c) == 2 for c in found)
    if not found or not pairs or not all(isinstance(cost, AccuracyCost) for _, cost in found):
        raise InputError("costs", "an AccuracyCost, (title, AccuracyCost), or a list of these", repr(costs)[:80])
    return [(str(title), cost) for title, cost in found]
