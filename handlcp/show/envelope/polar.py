"""Polar diagrams of an envelope, coloured by what gives out first; and the words that all pictures of one have."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Ints
from handlcp.show.envelope.surface import NOTHING, Surface, section, surface_of
from handlcp.show.file import Figure, new_figure
from handlcp.show.picture.overlay import nice
from handlcp.show.style import GREY, INK, LEFT, SMALL, TEXT, further, heading, width
from handlcp.study.envelope import Envelope
from handlcp.study.envelope.printed import direction, geometry, given_away, headline

# ----------------------------------------------------------------
# What the pictures of an envelope say in words: the headline, and the colours with their causes.

ROW, COLUMN = 0.215, 0.5  # inches of a line; a column's share of the width
TITLE = "What gives out first: share of the directions, and how much is held there"


def head(figure: Any, env: Envelope, title: str) -> float:
    """Title, weakest direction, what compliance gives away; returns where that ends, in inches below the top."""
    y = heading(figure, title)
    for k, text in enumerate(sentences(env)):
        y = further(figure, y, text, GREY if k else INK, 0.964)
    return y


def sentences(env: Envelope) -> list[str]:
    """The weakest direction, what compliance gives away, what stays where it is."""
    return [f"{text[:1].upper()}{text[1:]}." for text in (headline(env), given_away(env), geometry(env)) if text]


def lines_of(env: Envelope, s: Surface, bound: str) -> list[tuple[str, str, str]]:
    """(kind, colour, text) of each line; kind: "patch", or how the bound is drawn."""
    found = []
    for key in s.keys:
        least = "" if key.colour == NOTHING else f", {key.least:.3g} {env.unit}".rstrip() + " and more"
        least = ", drawn as far as the bound" if np.isnan(key.least) else least
        found.append(("patch", key.colour, f"{key.says}: {words.percent(key.share)}{least}"))
    if s.bound_beyond:
        found.append((bound, INK, "without compliance: friction and torque limits alone"))
    return found


class Legend:
    """The colours of an envelope with their causes, written in two columns.

    bound : how the limit without compliance is drawn, "line" or "dashed".
    height : inches that the legend takes, with its heading.
    """

    def __init__(self, env: Envelope, s: Surface, bound: str = "dashed") -> None:
        self.lines = lines_of(env, s, bound)
        cut = f"{s.reach:.3g} {env.unit}".rstrip()
        self.note = f"Cut at {cut}: what reaches farther is drawn there." if s.cut else ""
        self.rows = (len(self.lines) + 1) // 2
        self.height = 0.34 + ROW * (self.rows + bool(self.note)) + 0.08

    def draw(self, figure: Any, top: float) -> None:
        """Below `top`, in inches."""
        from matplotlib.lines import Line2D
        from matplotlib.patches import Rectangle

        wide, tall = (float(size) for size in figure.get_size_inches())
        style: dict[str, Any] = {"fontsize": SMALL, "va": "center"}
        figure.text(LEFT, 1.0 - (top + 0.1) / tall, TITLE, weight="bold", color=INK, **style)
        for k, (kind, colour, text) in enumerate(self.lines):
            x, y = LEFT + COLUMN * (k // self.rows), 1.0 - (top + 0.34 + ROW * (k % self.rows)) / tall
            if kind == "patch":
                look: dict[str, Any] = {"facecolor": colour, "edgecolor": "#55555566", "linewidth": 0.5}
                mark: Any = Rectangle((x, y - 0.06 / tall), 0.24 / wide, 0.12 / tall, **look)
            else:
                dash: Any = "-" if kind == "line" else (0, (4, 2))
                mark = Line2D([x, x + 0.24 / wide], [y, y], color=colour, linewidth=1.0, linestyle=dash)
            mark.set_transform(figure.transFigure)
            figure.add_artist(mark)
            shown = _fitting(figure, text, COLUMN - 0.24 / wide - 0.03)
            figure.text(x + 0.32 / wide, y, shown, color=INK, **style)
        if self.note:
            figure.text(LEFT, 1.0 - (top + 0.34 + ROW * self.rows) / tall, self.note, color=GREY, **style)


def _fitting(figure: Any, text: str, across: float) -> str:
    """With "…" in its cause where it is wider than this share of the figure."""
    says, colon, rest = text.partition(": ")
    while width(figure, says + colon + rest, fontsize=SMALL) > across * figure.bbox.width and len(says) > 12:
        says = says.removesuffix(" …")[:-3].rstrip() + " …"
    return says + colon + rest


# ----------------------------------------------------------------

WIDTH, SIDE = 10.0, 3.3  # inches: of the figure, of a panel
ALONE = 4.6  # of the panel where it is the only one
RINGS, GRID = "#D9DCDF", "#C4C8CC"
ROOM = 1.19  # of the panel's half width, in reaches


def polar_figure(env: Envelope, title: str = "") -> Figure:
    """Draw polar diagrams of an envelope: in the planes xy, yz and xz, or in the plane of its directions.

    Raises InputError for directions that lie neither all around nor in a plane; Unsupported without matplotlib.
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
    """Draw the polar diagram of one plane.

    axes (2, 3) : unit vectors to the right and upwards in the panel, world axes.
    """
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
