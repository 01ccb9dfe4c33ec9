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
_LIFT = 9.0  # of the lowest name of a ladder above its point [points]
_DISTANCES = (1.0, 2.5, 5.0, 8.0, 12.0, 17.0)  # where there is no room, so many gaps away
_DENSE = 5.0  # a curve that names should not cover is looked at every so many pixels
_RUNGS = 14  # of a ladder, at most


@dataclass(frozen=True, slots=True)
class CurveLabel:
    """A name, its colour, and the curve's points (k, 2) in data coordinates, in their order."""

    text: str
    colour: str
    points: Array


def ladder(ax: Any, points: Sequence[CurveLabel], size: float, curves: Sequence[CurveLabel] = ()) -> list[Any]:
    """Names above single points that lie on one line: each at the end of an upright line, the leftmost the highest, so
    that no name crosses another's line, nor covers one of `curves` where that can be helped. Returns texts and lines.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    renderer = FigureCanvasAgg(ax.figure).get_renderer()
    scale, back = ax.figure.dpi / 72.0, ax.transData.inverted()
    own = [ax.transData.transform(c.points)[0] for c in points]
    ink = np.vstack([np.zeros((0, 2)), *(_sampled(ax.transData.transform(c.points)) for c in curves)])
    taken: list[_Box] = []
    lines: list[tuple[float, float]] = []
    out = []
    for c, (x, y) in sorted(zip(points, own, strict=True), key=lambda pair: -float(pair[1][0])):
        text = ax.text(0, 0, c.text, fontsize=size, color=c.colour, va="bottom", ha="left", zorder=8)
        drawn = text.get_window_extent(renderer)
        left, step = x + 3.0 * scale, drawn.height + 1.0
        rungs = [y + _LIFT * scale + k * step for k in range(_RUNGS)]
        boxes = [(left - 3.0, rung, left + drawn.width + 3.0, rung + drawn.height) for rung in rungs]
        costs = [
            1e4 * sum(_overlap(b, t) for t in taken)
            + 1e4 * sum(b[0] < at < b[2] and b[1] < top for at, top in lines)
            + 10.0 * _inside(ink, b)
            + 20.0 * k
            for k, b in enumerate(boxes)
        ]
        rung = int(np.argmin(costs))
        bottom = rungs[rung]
        taken.append((left, bottom, left + drawn.width, bottom + drawn.height))
        lines.append((float(x), bottom))
        text.set_position(back.transform((left, bottom)))
        out += ax.plot(
            *back.transform([(x, y), (x, bottom + 0.8 * drawn.height)]).T, "-", color=c.colour, linewidth=0.7,
            zorder=4 - 0.01 * rung,  # of two on the same upright both are seen
        )  # fmt: skip
        out.append(text)
    return out


def write(
    ax: Any, curves: Sequence[CurveLabel], size: float, others: Array | None = None, written: Sequence[Any] = ()
) -> list[Any]:
    """Write every name, the shortest curve first; returns the texts. Limits and scales of `ax` must be final.

    others : (k, 2) further points to keep clear of. written : texts and lines that are there already. Each name
    stands beside one of its own points, at the place whose box covers least; a line leads to it where that is far.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    renderer = FigureCanvasAgg(ax.figure).get_renderer()
    gap = _GAP * ax.figure.dpi / 72.0
    frame = ax.get_window_extent(renderer)
    own = [ax.transData.transform(c.points) for c in curves]
    ink = [_sampled(points) for points in own]
    if others is not None and len(others):
        ink.append(ax.transData.transform(others))
    everything = np.vstack(ink) if ink else np.zeros((0, 2))
    taken: list[_Box] = [tuple(a.get_window_extent(renderer).padded(1.0).extents) for a in written]
    lines: list[Array] = []
    out = []
    for c, points in sorted(zip(curves, own, strict=True), key=lambda pair: len(pair[1])):
        text = ax.text(0, 0, c.text, fontsize=size, color=c.colour, va="bottom", ha="left", zorder=8)
        drawn = text.get_window_extent(renderer)
        best, least, where = (frame.x0, frame.y0, frame.x0 + drawn.width, frame.y0 + drawn.height), np.inf, points[0]
        for k, point in enumerate(points):
            end = min(k, len(points) - 1 - k)  # ends of a curve are looked at first
            for far, distance in enumerate(_DISTANCES):
                for place, box in enumerate(
                    _places(float(point[0]), float(point[1]), drawn.width, drawn.height, distance * gap)
                ):
                    x0, y0, x1, y1 = box
                    outside = x0 < frame.x0 or x1 > frame.x1 or y0 < frame.y0 or y1 > frame.y1
                    crossed = sum(_overlap(box, b) for b in taken)
                    cost = 1e6 * outside + 1e4 * crossed + 60.0 * _inside(everything, (x0 - 2, y0 - 1, x1 + 2, y1 + 1))
                    cost += 2.0 * end + 8.0 * far + 0.4 * place
                    if far and cost < least:
                        line = _between(point, box)
                        covered = sum(_inside(line, b) for b in taken) + _inside(line[1:-1], box)
                        cost += 200.0 * covered + 40.0 * sum(_inside(led, box) for led in lines)
                        away = abs(everything[:, None] - line[4:]).max(axis=2) if len(everything) else np.ones((1, 1))
                        cost += 40.0 * int((away < 4.0).any(axis=0).sum())
                    if cost < least:
                        best, least, where = box, cost, point
        taken.append(best)
        back = ax.transData.inverted()
        text.set_position(back.transform(best[:2]))
        near = np.clip(where, best[:2], best[2:])
        if np.hypot(*(near - where)) > 2.0 * gap:
            lines.append(_between(where, best))
            ax.plot(*back.transform(np.array([where, near])).T, "-", color=c.colour, linewidth=0.7, zorder=7)
        out.append(text)
    return out


def _places(x: float, y: float, width: float, height: float, gap: float) -> list[_Box]:
    """Boxes all around a point, `gap` away; the right one first."""
    out = []
    for k in _TURNS:
        across, up = np.cos(np.pi * k / 8), np.sin(np.pi * k / 8)
        # Beside the point the box is centred on its height, above and below on its width
        left = x + gap * across - width * (1.0 - min(max(1.6 * across, -1.0), 1.0)) / 2
        bottom = y + gap * up - height * (1.0 - min(max(1.6 * up, -1.0), 1.0)) / 2
        out.append((left, bottom, left + width, bottom + height))
    return out


def _overlap(a: _Box, b: _Box) -> bool:
    return min(a[2], b[2]) > max(a[0], b[0]) and min(a[3], b[3]) > max(a[1], b[1])


def _between(point: Array, box: _Box) -> Array:
    """(20, 2) from a point to the nearest of a box."""
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
