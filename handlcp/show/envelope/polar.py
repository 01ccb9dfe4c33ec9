"""Polar diagrams of an envelope: what is held in each direction of a plane, coloured by what gives out first."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from handlcp.check import Array, Ints
from handlcp.show.envelope.legend import Legend, head
from handlcp.show.envelope.surface import Surface, section, surface_of
from handlcp.show.file import Figure, new_figure
from handlcp.show.picture.overlay import nice
from handlcp.show.style import GREY, INK, SMALL, TEXT
from handlcp.study.envelope import Envelope
from handlcp.study.envelope.printed import direction

WIDTH, SIDE = 10.0, 3.3  # inches: of the figure, of a panel
ALONE = 4.6  # of the panel where it is the only one
RINGS, GRID = "#D9DCDF", "#C4C8CC"
ROOM = 1.19  # of the panel's half width, in reaches


def polar_figure(env: Envelope, title: str = "") -> Figure:
    """The figure. Raises InputError for directions that lie neither all around nor in a plane; Unsupported without
    matplotlib.
    """
    s = surface_of(env)
    planes = [env.plane] if env.plane is not None else [np.eye(3)[list(axes)] for axes in ((0, 1), (1, 2), (0, 2))]
    side = ALONE if len(planes) == 1 else SIDE
    legend = Legend(env, s)
    draft = new_figure(figsize=(WIDTH, 8.0), dpi=100)
    above = head(draft, env, title)
    tall = above + side + 0.15 + legend.height
    figure = new_figure(figsize=(WIDTH, tall), dpi=100)
    head(figure, env, title)
    for k, axes in enumerate(planes):
        left = (WIDTH - len(planes) * side) / 2 + k * side
        ax = figure.add_axes((left / WIDTH, 1.0 - (above + side + 0.1) / tall, side / WIDTH, side / tall))
        _panel(ax, env, s, axes)
    legend.draw(figure, above + side + 0.15)
    return figure


def _panel(ax: Any, env: Envelope, s: Surface, axes: Array) -> None:
    """One plane. axes (2, 3) : rightwards and upwards."""
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.patches import Circle

    if s.cells.shape[1] == 2:
        lines, cells, limit = s.own[s.cells], np.arange(len(s.cells)), s.bound[s.cells]
    else:
        normal = np.cross(*axes)
        lines, cells = section(s.own, s.cells, normal)
        limit = section(s.bound, s.cells, normal)[0]
    _rings(ax, env, s, axes)
    inside = Circle((0, 0), s.reach, transform=ax.transData)
    runs = _runs(lines @ axes.T, s.key[cells])
    colours = [s.keys[k].colour for k, _ in runs]
    wedges = [np.vstack([np.zeros(2), line]) for _, line in runs]
    fill = PolyCollection(wedges, facecolors=colours, edgecolors="none", alpha=0.28, zorder=2)
    rim = LineCollection([line for _, line in runs], colors=colours, linewidths=2.4, capstyle="round", zorder=4)
    whole = [line for _, line in _runs(limit @ axes.T, np.zeros(len(limit), dtype=np.int64))]
    bound = LineCollection(whole, colors=INK, linewidths=1.0, linestyles=[(0, (4, 2.5))], zorder=3)
    for drawn in (fill, rim, *([bound] if s.bound_beyond else [])):
        ax.add_collection(drawn)
        drawn.set_clip_path(inside)


def _rings(ax: Any, env: Envelope, s: Surface, axes: Array) -> None:
    """Circles of equal load with their numbers, and the axes with their names."""
    from matplotlib.patches import Circle

    ax.axis("off")
    ax.set_aspect("equal")
    room = ROOM * s.reach
    ax.set_xlim(-room, room)
    ax.set_ylim(-room, room)
    step = nice(0.51 * s.reach) if s.reach > 0 else 1.0
    if s.reach / step > 4.2:
        step *= 2
    rings = np.arange(step, s.reach * (1 + 1e-9), step)
    for r in rings:
        ax.add_patch(Circle((0, 0), r, fill=False, edgecolor=RINGS, linewidth=0.8, zorder=1))
    ax.add_patch(Circle((0, 0), s.reach, fill=False, edgecolor=GRID, linewidth=1.0, zorder=1))
    for angle in np.radians(np.arange(0, 360, 30)):
        way = np.array([np.cos(angle), np.sin(angle)])
        style = {"color": GRID if abs(way).max() > 0.99 else RINGS, "linewidth": 0.7, "zorder": 1}
        ax.plot(*np.outer(way, (0, s.reach)), **style)
    for r in rings:
        at = r * np.array([np.cos(np.radians(75)), np.sin(np.radians(75))])
        text = f"{r:g}" + (f" {env.unit}" if r == rings[-1] and env.unit else "")
        box = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
        ax.text(*at, text, fontsize=SMALL - 1.5, color=GREY, ha="center", va="center", zorder=5, bbox=box)
    for way in (*np.eye(2), *-np.eye(2)):
        name = direction(way @ axes)
        ha = "center" if abs(way[0]) < 0.5 else "left" if way[0] > 0 else "right"
        va = "center" if abs(way[1]) < 0.5 else "bottom" if way[1] > 0 else "top"
        ax.text(*(1.035 * s.reach * way), name, fontsize=TEXT, color=INK, ha=ha, va=va, weight="bold")


def _runs(segments: Array, keys: Ints) -> list[tuple[int, Array]]:
    """Segments (s, 2, 2) put end to end around the origin: (key, line (k, 2)) of neighbours with the same key (s,)."""
    if not len(segments):
        return []
    middle = segments.mean(axis=1)
    order = np.argsort(np.arctan2(middle[:, 1], middle[:, 0]))
    ends, own = segments[order], keys[order]
    turn = ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 0, 1] * ends[:, 1, 0]
    ends[turn < 0.0] = ends[turn < 0.0][:, ::-1]
    starts = [0, *(np.flatnonzero(np.diff(own)) + 1).tolist(), len(own)]
    return [(int(own[a]), np.vstack([ends[a:b, 0], ends[b - 1 : b, 1]])) for a, b in pairwise(starts)]
