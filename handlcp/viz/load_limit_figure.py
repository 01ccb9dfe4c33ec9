"""`draw_limit`: load limits: a table of several, and the figure of one: forces, friction, motion, joint torques."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from handlcp import words
from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.grasp import Grasp
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.path.events import Event, summary
from handlcp.grasp.path.trajectory import used_on_path
from handlcp.viz import terminal_table as tables
from handlcp.viz.loading.curves import PanelAxis, make_panels
from handlcp.viz.loading.figure import EventMark, EventMarks, compose_panels
from handlcp.viz.output_file import Figure
from handlcp.viz.style import (
    BAD_COLOUR,
    GOOD_COLOUR,
    INK,
    SMALL_SIZE,
    TEXT_SIZE,
    draw_sentences,
    draw_title,
    draw_word_and_sentence,
)

_SAME_LOAD_TOLERANCE = 1e-6  # loads that differ by less are the same
_AXIS_NAMES = ("x", "y", "z")


def format_load_size(wrench: Array, factor: float) -> str:
    """Of the load at a factor, such as "2.54 N"; "no limit" where it is infinite."""
    if not np.isfinite(factor):
        return "no limit"
    force, torque = float(np.linalg.norm(wrench[:3])), float(np.linalg.norm(wrench[3:]))
    parts = [
        words.format_force(factor * force) if force else "",
        words.format_torque(factor * torque) if torque else "",
    ]
    return ", ".join(filter(None, parts))


def format_load_direction(wrench: Array) -> str:
    """Of a load, such as "+x", "force 0.6 0.5 0.62", "torque +z"."""
    parts = []
    for name, part in (("force", wrench[:3]), ("torque", wrench[3:])):
        if part.any():
            parts.append(f"{name} {_format_vector(part)}")
    return " and ".join(parts)


def _format_vector(vector: Array) -> str:
    """Along an axis its name, else the numbers."""
    found = np.flatnonzero(vector)
    if len(found) == 1:
        return f"{'-' if vector[found[0]] < 0 else '+'}{_AXIS_NAMES[found[0]]}"
    return " ".join(f"{x:.3g}" for x in vector.tolist())


def limit_table(limits: Sequence[LoadLimit], title: str) -> Table:
    """A row for each load: where a finger slips first, how much is held, what gives out, how far the object has moved
    there, where it is lost, and how much friction and torque limits alone allow.
    """
    note = "at most: what friction and torque limits alone would allow, whatever the springs"
    heads = "load", "first slip", "held up to", "what gives out", "at most"
    table = tables.make_table(title, heads, "|>><>", note=note)
    for limit in limits:
        held = limit.factor > 0.0
        first = format_load_size(limit.wrench, limit.first_slip) if held and limit.first_slip is not None else "–"
        ends = [describe_failures(limit.binds, brief=True)]
        if (there := format_motion_at_limit(limit)) != "–":
            ends.append(f"moved {there}")
        if limit.lost is not None and limit.lost > limit.factor * (1.0 + _SAME_LOAD_TOLERANCE):
            ends.append(f"lost at {format_load_size(limit.wrench, limit.lost)}")
        most, bound = format_load_size(limit.wrench, limit.factor), format_load_size(limit.wrench, limit.bound)
        row = format_load_direction(limit.wrench), first, most, "; ".join(ends)
        table.add_row(*map(Text, row), bound, style=None if held else "bold red")
    return table


def format_motion_at_limit(limit: LoadLimit) -> str:
    """How far the object has moved and turned at the limit, such as "4 mm, 4°"; "–" where that is not known."""
    there = [m for m in limit.marks.values() if m.factor == limit.factor > 0.0]
    return f"{words.format_length(there[0].moved)}, {words.format_angle(there[0].turned)}" if there else "–"


_AXIS_LENGTH_FACTOR = 1.06  # of the limit: where the axis of a figure ends


def draw_limit(limit: LoadLimit, title: str = "") -> Figure:
    """The figure of what `grasp.load_limit` returns.

    Along x, the load from nothing to its limit. One below the other: normal forces; friction as a share of its limit,
    100 % where a finger slides; motion of the object since the load began, world axes; joint torques as a share of
    their limits. Lines with a number are events, listed at the bottom. What lies behind the limit is shaded.
    Raises Unsupported for a grasp that is lost before the load comes, and when matplotlib is not installed.
    """
    if not len(limit.path.factors):
        raise Unsupported(f"there is no load to draw: {limit.why}; `grasp.follow().plot()` draws how it is lost")
    spec, path = limit.at_limit.spec, limit.path
    assert spec is not None  # it was solved
    force, torque = float(np.linalg.norm(limit.wrench[:3])), float(np.linalg.norm(limit.wrench[3:]))
    size, unit, what = (force, "N", "load") if force > 0.0 else (torque, "N·m", "torque")  # of a factor of 1
    end = _AXIS_LENGTH_FACTOR * float(size * path.factors[-1]) or 1.0

    def draw_ticks(ax: Any, named: bool) -> None:
        """Round sizes of the load, from nothing to somewhat beyond the limit."""
        from matplotlib.ticker import MaxNLocator

        ax.set_xlim(0.0, end)
        ax.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]))
        ax.tick_params(labelbottom=named, labelsize=SMALL_SIZE)
        if named:
            name = f"{what} beside the weight [{unit}]"
            ax.set_xlabel(name, fontsize=TEXT_SIZE, color=INK, weight="bold", labelpad=3)

    held_up_to = size * limit.factor if np.isfinite(limit.factor) else None
    axis = PanelAxis(size * path.factors, held_up_to, "limit", end, draw_ticks)
    last = float(limit.path.factors[-1]) or 1.0
    until = max(last, limit.factor if np.isfinite(limit.factor) else last)
    events = [
        Event(e.kind, e.who, "load", e.factor / last, 0, e.moved, e.turned) for e in limit.events if e.factor <= until
    ]
    told = [(size * last * s.share, s) for s in summary(events, spec)]
    marks = EventMarks(axis, [EventMark(load, f"{load:.4g} {unit}", s.sentence, s.kind) for load, s in told])
    scene = Grasp(spec).scene
    # The path does not know the moments of soft fingers
    used = None if scene.soft else used_on_path(scene, path.forces, np.zeros(path.forces.shape[:2]))
    shown = make_panels(spec, path.forces, used, path.displacement - path.displacement[0], path.torques)
    return compose_panels(axis, shown, marks, lambda drawn: _draw_limit_heading(drawn, limit, title))


def _draw_limit_heading(drawn: Figure, limit: LoadLimit, title: str) -> float:
    """Title, the limit and what gives out; which load, and what friction and torque limits alone would allow."""
    held = np.isfinite(limit.factor)
    below = f"The load that grows: {format_load_direction(limit.wrench)}."
    if (there := format_motion_at_limit(limit)) != "–":
        below += f" At the limit the object has moved {there}."
    if limit.lost is not None and limit.lost > limit.factor * (1.0 + 1e-6):
        below += f" It is lost at {format_load_size(limit.wrench, limit.lost)}."
    if held and np.isfinite(limit.bound) and limit.bound > limit.factor * (1.0 + 1e-6):
        below += f" Friction and torque limits alone would allow {format_load_size(limit.wrench, limit.bound)}."
    beyond = limit.some_equilibrium
    if beyond > max(limit.factor, limit.lost or 0.0) * (1.0 + 1e-6) and not np.isclose(beyond, limit.bound, rtol=1e-3):
        most = format_load_size(limit.wrench, beyond)
        below += f" Up to {most} there are forces in balance, which a load that grows does not reach."
    word, colour = ("LIMIT", BAD_COLOUR) if held else ("NO LIMIT", GOOD_COLOUR)
    return draw_sentences(
        drawn, draw_word_and_sentence(drawn, draw_title(drawn, title), word, colour, f"{limit.why}."), below
    )
