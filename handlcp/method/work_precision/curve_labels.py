"""Names written beside the curves they belong to, where they cover neither points nor each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from handlcp.check import Array

_GAP = 5.0  # between a point and its name [points]
_TURNS = (0, 8, -4, 4, 2, -2, 6, -6, 1, -1, 7, -7, 3, -3, 5, -5)  # where names are tried, in 1/16 of a turn
_DISTANCES = (1.0, 2.5, 5.0, 8.0, 12.0, 17.0)  # where they are tried, in gaps from the point
_LIFT = 9.0  # of the lowest name of a ladder above its point [points]
_RUNGS = 14  # of a ladder, at most
_DENSE = 5.0  # pixels between the samples of a curve that names should not cover


@dataclass(frozen=True, slots=True)
class CurveLabel:
    """A name, its colour, and the curve's points (k, 2) in data coordinates, in their order."""

    text: str
    colour: str
    points: Array


def ladder(ax: Any, points: Sequence[CurveLabel], size: float, curves: Sequence[CurveLabel]) -> list[Any]:
    """Write names above single points of equal height, each at the end of an upright line; returns texts and lines.

    The leftmost name is the highest, so that no name crosses another's line, nor covers one of `curves` if possible.
    """
    scale, back = ax.figure.dpi / 72.0, ax.transData.inverted()
    own = [ax.transData.transform(c.points)[0] for c in points]
    ink = np.vstack([np.zeros((0, 2)), *(_sampled(ax.transData.transform(c.points)) for c in curves)])
    taken: list[Any] = []
    lines: list[tuple[float, float]] = []
    out = []
    for c, (x, y) in sorted(zip(points, own, strict=True), key=lambda pair: -float(pair[1][0])):
        text, drawn = _text(ax, c, size)
        bottom = y + _LIFT * scale + np.arange(_RUNGS) * (drawn.height + 1.0)
        rungs = [_at(drawn, x + 3.0 * scale, b) for b in bottom]
        costs = []
        for k, box in enumerate(rungs):
            wide = box.padded(3.0, 0.0)
            crossed = wide.count_overlaps(taken) + sum(wide.x0 < at < wide.x1 and wide.y0 < top for at, top in lines)
            costs.append(1e4 * crossed + 10.0 * wide.count_contains(ink) + 20.0 * k)
        rung = int(np.argmin(costs))
        taken.append(rungs[rung])
        lines.append((float(x), bottom[rung]))
        text.set_position(back.transform(rungs[rung].min))
        ends = back.transform([(x, y), (x, bottom[rung] + 0.8 * drawn.height)])
        below = 4 - 0.01 * rung  # the shorter of two lines at the same place is drawn over the longer one
        out += [text, *ax.plot(*ends.T, "-", color=c.colour, linewidth=0.7, zorder=below)]
    return out


def write(ax: Any, curves: Sequence[CurveLabel], size: float, others: Array, written: Sequence[Any]) -> None:
    """Write the name of every curve beside it, the shortest curve first. Limits and scales of `ax` must be final.

    others : (k, 2) further points to keep clear of. written : texts and lines that are there already. Each name
    stands beside a point of its curve, at the place whose box covers least; a line leads to it where that is far.
    """
    gap, back, frame = _GAP * ax.figure.dpi / 72.0, ax.transData.inverted(), ax.get_window_extent()
    own = [ax.transData.transform(c.points) for c in curves]
    ink = np.vstack([*map(_sampled, own), ax.transData.transform(others.reshape(-1, 2))])
    taken = [a.get_window_extent().padded(1.0) for a in written]
    lines: list[Array] = []
    for c, points in sorted(zip(curves, own, strict=True), key=lambda pair: len(pair[1])):
        text, drawn = _text(ax, c, size)
        best, least, where = drawn, np.inf, points[0]
        for k, point in enumerate(points):
            for far, distance in enumerate(_DISTANCES):
                for place, box in enumerate(_places(point, drawn, distance * gap)):
                    outside = frame.count_contains([box.min, box.max]) < 2
                    cost = 1e6 * outside + 1e4 * box.count_overlaps(taken) + 60.0 * box.padded(2, 1).count_contains(ink)
                    # Better near an end of the curve, near the point, and on its right
                    cost += 2.0 * min(k, len(points) - 1 - k) + 8.0 * far + 0.4 * place
                    if far and cost < least:
                        cost += _line_cost(_between(point, box), box, ink, taken, lines)
                    if cost < least:
                        best, least, where = box, cost, point
        taken.append(best)
        text.set_position(back.transform(best.min))
        line = _between(where, best)
        if np.hypot(*(line[-1] - where)) > 2.0 * gap:
            lines.append(line)
            ax.plot(*back.transform(line[[0, -1]]).T, "-", color=c.colour, linewidth=0.7, zorder=7)


def _text(ax: Any, c: CurveLabel, size: float) -> tuple[Any, Any]:
    """The text, somewhere, and its box in pixels; where it covers a curve it stands on white."""
    from matplotlib import patheffects

    text = ax.text(0, 0, c.text, fontsize=size, color=c.colour, va="bottom", ha="left", zorder=8)
    text.set_path_effects([patheffects.withStroke(linewidth=2.5, foreground="white")])
    return text, text.get_window_extent()


def _at(box: Any, left: float, bottom: float) -> Any:
    """The box with its corner elsewhere."""
    return box.translated(left - box.x0, bottom - box.y0)


def _places(point: Array, box: Any, gap: float) -> list[Any]:
    """Boxes of this size all around a point, `gap` away; the right one first."""
    turns = np.pi / 8 * np.array(_TURNS)
    way = np.column_stack([np.cos(turns), np.sin(turns)])
    # Beside the point the box is centred on its height, above and below on its width
    corners = point + gap * way - box.size * (1.0 - np.clip(1.6 * way, -1.0, 1.0)) / 2
    return [_at(box, left, bottom) for left, bottom in corners]


def _line_cost(line: Array, box: Any, ink: Array, taken: list[Any], lines: list[Array]) -> float:
    """What a line to a name in `box` crosses: names, other names' lines, points."""
    covered = sum(b.count_contains(line) for b in taken) + box.count_contains(line[1:-1])
    near_points = (abs(ink[:, None] - line[4:]).max(axis=2) < 4.0).any(axis=0).sum()
    return float(200.0 * covered + 40.0 * (sum(box.count_contains(led) for led in lines) + near_points))


def _between(point: Array, box: Any) -> Array:
    """(20, 2) points from a point to the nearest one of a box."""
    return np.linspace(point, np.clip(point, box.min, box.max), 20)


def _sampled(points: Array) -> Array:
    """The points, and more on the lines between them."""
    parts = [np.linspace(a, b, 2 + int(np.hypot(*(b - a)) / _DENSE)) for a, b in pairwise(points)]
    return np.vstack([points, *parts])
