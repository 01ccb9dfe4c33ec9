"""Names written beside the curves they belong to, where they cover neither points nor each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from handlcp.check import Array

__all__ = ["CurveLabel", "ladder", "write"]

_Box = tuple[float, float, float, float]  # left, bottom, right, top, in pixels

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
    taken: list[_Box] = []
    lines: list[tuple[float, float]] = []
    out = []
    for c, (x, y) in sorted(zip(points, own, strict=True), key=lambda pair: -float(pair[1][0])):
        text, wide, tall = _text(ax, c, size)
        left = x + 3.0 * scale
        rungs = [y + _LIFT * scale + k * (tall + 1.0) for k in range(_RUNGS)]
        costs = []
        for k, rung in enumerate(rungs):
            box = (left - 3.0, rung, left + wide + 3.0, rung + tall)
            crossed = sum(_overlap(box, t) for t in taken)
            crossed += sum(box[0] < at < box[2] and box[1] < top for at, top in lines)
            costs.append(1e4 * crossed + 10.0 * _inside(ink, box) + 20.0 * k)
        rung = int(np.argmin(costs))
        bottom = rungs[rung]
        taken.append((left, bottom, left + wide, bottom + tall))
        lines.append((float(x), bottom))
        text.set_position(back.transform((left, bottom)))
        ends = back.transform([(x, y), (x, bottom + 0.8 * tall)])
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
    taken: list[_Box] = [tuple(a.get_window_extent().padded(1.0).extents) for a in written]
    lines: list[Array] = []
    for c, points in sorted(zip(curves, own, strict=True), key=lambda pair: len(pair[1])):
        text, wide, tall = _text(ax, c, size)
        best, least, where = (0.0, 0.0, wide, tall), np.inf, points[0]
        for k, point in enumerate(points):
            for far, distance in enumerate(_DISTANCES):
                for place, box in enumerate(_places(point, wide, tall, distance * gap)):
                    outside = box[0] < frame.x0 or box[2] > frame.x1 or box[1] < frame.y0 or box[3] > frame.y1
                    around = (box[0] - 2, box[1] - 1, box[2] + 2, box[3] + 1)
                    cost = 1e6 * outside + 1e4 * sum(_overlap(box, b) for b in taken) + 60.0 * _inside(ink, around)
                    # Better near an end of the curve, near the point, and on its right
                    cost += 2.0 * min(k, len(points) - 1 - k) + 8.0 * far + 0.4 * place
                    if far and cost < least:
                        cost += _line_cost(_between(point, box), box, ink, taken, lines)
                    if cost < least:
                        best, least, where = box, cost, point
        taken.append(best)
        text.set_position(back.transform(best[:2]))
        near = np.clip(where, best[:2], best[2:])
        if np.hypot(*(near - where)) > 2.0 * gap:
            lines.append(_between(where, best))
            ax.plot(*back.transform(np.array([where, near])).T, "-", color=c.colour, linewidth=0.7, zorder=7)


def _text(ax: Any, c: CurveLabel, size: float) -> tuple[Any, float, float]:
    """The text, its width and its height in pixels."""
    text = ax.text(0, 0, c.text, fontsize=size, color=c.colour, va="bottom", ha="left", zorder=8)
    drawn = text.get_window_extent()
    return text, float(drawn.width), float(drawn.height)


def _places(point: Array, width: float, height: float, gap: float) -> list[_Box]:
    """Boxes all around a point, `gap` away; the right one first."""
    out = []
    for k in _TURNS:
        across, up = np.cos(np.pi * k / 8), np.sin(np.pi * k / 8)
        # Beside the point the box is centred on its height, above and below on its width
        left = float(point[0]) + gap * across - width * (1.0 - min(max(1.6 * across, -1.0), 1.0)) / 2
        bottom = float(point[1]) + gap * up - height * (1.0 - min(max(1.6 * up, -1.0), 1.0)) / 2
        out.append((left, bottom, left + width, bottom + height))
    return out


def _line_cost(line: Array, box: _Box, ink: Array, taken: list[_Box], lines: list[Array]) -> float:
    """What a line to a name in `box` crosses: names, other names' lines, points."""
    covered = sum(_inside(line, b) for b in taken) + _inside(line[1:-1], box)
    away = abs(ink[:, None] - line[4:]).max(axis=2)
    near_points = int((away < 4.0).any(axis=0).sum())
    return 200.0 * covered + 40.0 * (sum(_inside(led, box) for led in lines) + near_points)


def _overlap(a: _Box, b: _Box) -> bool:
    return min(a[2], b[2]) > max(a[0], b[0]) and min(a[3], b[3]) > max(a[1], b[1])


def _between(point: Array, box: _Box) -> Array:
    """(20, 2) points from a point to the nearest one of a box."""
    return np.linspace(point, np.clip(point, box[:2], box[2:]), 20)


def _inside(points: Array, box: _Box) -> int:
    """How many of the points a box covers."""
    return int(((points > box[:2]) & (points < box[2:])).all(axis=1).sum())


def _sampled(points: Array) -> Array:
    """The points, and more on the lines between them."""
    parts = [points]
    for a, b in pairwise(points):
        parts.append(np.linspace(a, b, 2 + int(np.hypot(*(b - a)) / _DENSE)))
    return np.vstack(parts)
