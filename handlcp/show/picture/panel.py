"""Beside the picture: title and verdict, the legend, how near the joints are to their limits."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from handlcp import words
from handlcp.grasp import Verdict
from handlcp.show.style import BLUE, BOLD, GREY, INK, RED, shortened, title_lines, width, wrapped

# kind ("patch", "hatch", "outline", "cone", "dot", "ring", "line", "dashed", "dashed-thin", "turn", "none"), colour,
# and text
Entry = tuple[str, str, str]

ROW = 0.058  # height of a joint, as a share of the figure
LETTERS = 31  # that fit a bar's width: joint and share, bold, at full size
LEAST = 20  # letters of a joint's name that are always shown
_UNIT = re.compile(r"(\d) (?=\S)")  # between a number and its unit
VERDICT = {"HELD": "#00734D", "UNDECIDED": "#8A6100"}  # the rest is red


def headline(figure: Any, v: Verdict, title: str, drawn: str) -> float:
    """Title, the verdict's word and first reason, and which state is drawn, at the top; returns where the picture may
    begin, as a share of the height.
    """
    y = 0.972
    for line in title_lines(figure, title):
        figure.text(0.018, y, line, color=INK, **BOLD)
        y -= 0.046
    y -= 0.006 if title else 0.0
    style = {"fontsize": 10.5, "va": "top"}
    said = f"{v.word}: {v.reasons[0].sentence}." if v.reasons else f"{v.word}:"
    lines = wrapped(figure, said, 140, 0.94, **style)
    lines = lines if len(lines) <= 4 else [*lines[:3], f"{lines[3]} …"]
    figure.text(0.018, y, f"{v.word}:", weight="bold", color=VERDICT.get(v.word, "#B03A00"), **style)
    indent = width(figure, f"{v.word}:", weight="bold", **style) / figure.bbox.width
    figure.text(0.023 + indent, y, lines[0].removeprefix(f"{v.word}: "), color=INK, **style)
    for line in lines[1:]:
        y -= 0.032
        figure.text(0.018, y, line, color=INK, **style)
    y -= 0.034
    figure.text(0.018, y, drawn, color=GREY, fontsize=9.5, va="top")
    return y - 0.045


def legend(figure: Any, left: float, top: float, entries: list[Entry]) -> float:
    """Symbols and their meaning, from (left, top) down; returns where they end. All in shares of the figure."""
    across = 0.985 - left - 0.034  # beside the symbols
    style = {"frameon": False, "fontsize": 9.5, "labelcolor": INK}
    handles = []
    for kind, colour, meaning in entries:
        whole = _UNIT.sub("\\1\N{NO-BREAK SPACE}", meaning)
        lines = [part for line in whole.split("\n") for part in wrapped(figure, line, 44, across, fontsize=9.5)]
        handles.append(_symbol(kind, colour, "\n".join(lines)))
    spacing = {"handlelength": 1.7, "labelspacing": 0.62, "borderaxespad": 0.0, "borderpad": 0.0}
    shown = figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(left, top), **style, **spacing)
    return float(shown.get_window_extent().y0 / figure.bbox.height)


def _symbol(kind: str, colour: str, meaning: str) -> Any:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    if kind in ("patch", "cone"):
        alpha = 0.55 if kind == "patch" else 0.25
        return Patch(facecolor=colour, alpha=alpha, edgecolor=colour, label=meaning)
    if kind == "hatch":
        return Patch(facecolor="#D5D7DA", edgecolor=colour, hatch="//////", linewidth=0.0, label=meaning)
    if kind == "outline":
        return Patch(facecolor="white", edgecolor=colour, linewidth=0.9, linestyle=(0, (3, 1.5)), label=meaning)
    point: dict[str, Any] = {"linestyle": "", "color": colour, "label": meaning}
    if kind == "dot":
        return Line2D([], [], marker="o", markersize=7, **point)
    if kind == "ring":
        return Line2D([], [], marker="o", markersize=6, markerfacecolor="white", markeredgewidth=1.6, **point)
    if kind == "turn":
        return Line2D([], [], marker=r"$\circlearrowleft$", markersize=11, markeredgewidth=0.4, **point)
    dash: Any = {"line": "-", "dashed": (0, (1.6, 0.8)), "dashed-thin": (0, (4, 2))}.get(kind, "")
    return Line2D([], [], color=colour, linewidth=1.0 if kind == "dashed-thin" else 3.2, linestyle=dash, label=meaning)


def torque_bars(figure: Any, across: tuple[float, float], top: float, check: Any) -> None:
    """A bar for each of the joints nearest to their limits, below `top`. across : left and width."""
    known = [r for r in check if r.known and np.isfinite(r.limit)]
    most = max(2, int((top - 0.055) / ROW))
    rows = sorted(known, key=lambda r: (-round(r.utilisation, 6), r.joint != check.binding))[:most]
    ax = figure.add_axes((across[0], top - ROW * max(len(rows), 1), across[1], ROW * max(len(rows), 1)))
    ax.axis("off")
    title = "Joint torque, share of limit"
    figure.text(across[0], top + 0.012, title, fontsize=10, weight="bold", color=INK, va="bottom")
    if not rows:
        ax.text(0, 1, "no joint has a known limit", fontsize=9.5, color=INK, va="top")
        return
    widest = max(1.0, max(r.utilisation for r in rows))
    said = [f"{words.percent(r.utilisation)} of {words.torque(r.limit)}" for r in rows]
    names = shortened([r.joint for r in rows], max(LEAST, LETTERS - max(map(len, said))))
    longest = max(len(name) + len(words) for name, words in zip(names, said, strict=True))
    size = 9.0 * min(1.0, LETTERS / longest)
    for k, r in enumerate(rows):
        over, binding = r.over, r.joint == check.binding
        colour = RED if over else BLUE if binding else "#8FB8D4"
        ax.barh(k + 0.72, 1.0, height=0.26, color="#ECEEF0", zorder=1)
        ax.barh(k + 0.72, r.utilisation, height=0.26, color=colour, zorder=2)
        style = {"va": "bottom", "fontsize": size, "color": INK, "weight": "bold" if over or binding else "normal"}
        ax.text(0, k + 0.54, names[k], ha="left", **style)
        ax.text(widest, k + 0.54, said[k], ha="right", **style)
    if (left_out := len(known) - len(rows)) > 0:
        least = words.percent(rows[-1].utilisation)
        more = f"and {left_out} joint{'s' if left_out > 1 else ''} with {least} or less"
        ax.text(0, len(rows) + 0.28, more, fontsize=9, color="#555555", va="center")
    ax.set_xlim(0, widest)
    ax.set_ylim(len(rows), 0)
