"""The picture of an envelope: the hand, and the surface of what it holds, from the same side and the opposite one."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.show.envelope.polar import Legend, head, polar_figure
from handlcp.show.envelope.surface import Surface, borders, surface_of, wires
from handlcp.show.file import Figure, new_figure
from handlcp.show.picture.bodies import Body
from handlcp.show.picture.camera import Camera, Frame
from handlcp.show.picture.content import Content
from handlcp.show.picture.figure import DPI, WIDTH, stage
from handlcp.show.picture.overlay import Overlay, nice
from handlcp.show.picture.painter import paint
from handlcp.show.style import GREY, INK, SMALL, rgb
from handlcp.study.envelope import Envelope
from handlcp.study.envelope.printed import amount, direction

TALL, HAND = 3.75, 2.7  # inches: height of the panels, width of the hand's
ROOM = 1.13  # of a surface's half width, in its reach
MARK = "#C8102E"  # the weakest direction


def figure(env: Envelope, title: str = "") -> Figure:
    """The figure; polar diagrams of directions in a plane. Raises InputError for directions that lie neither all around
    nor in a plane; Unsupported without matplotlib.
    """
    if env.plane is not None:
        return polar_figure(env, title)
    s = surface_of(env)
    legend = Legend(env, s, "line")
    above = head(new_figure(figsize=(WIDTH, 8.0), dpi=100), env, title) + 0.32
    tall = above + TALL + 0.12 + legend.height
    drawn = new_figure(figsize=(WIDTH, tall), dpi=100)
    head(drawn, env, title)
    shown = Content(env.grasp, env.grasp.solve(throw=False), None)
    camera = shown.camera
    behind = Camera(camera.axes * np.array([[-1.0], [1.0], [-1.0]]))
    side, bottom = (WIDTH - HAND) / 2, 1.0 - (above + TALL) / tall
    panels = [
        (0.0, HAND, "The hand, without forces"),
        (HAND, side, "What it holds, seen from the same side"),
        (HAND + side, side, "From the opposite side"),
    ]
    for k, (left, wide, name) in enumerate(panels):
        ax = drawn.add_axes((left / WIDTH, bottom, wide / WIDTH, TALL / tall))
        at = (left + 0.18) / WIDTH
        drawn.text(at, 1.0 - (above - 0.08) / tall, name, fontsize=SMALL, weight="bold", color=INK, va="center")
        if k == 0:
            _hand(ax, shown, (wide, TALL))
        else:
            _surface(ax, camera if k == 1 else behind, env, s, (wide, TALL))
    legend.draw(drawn, above + TALL + 0.12)
    return drawn


def _hand(ax: Any, shown: Content, inches: tuple[float, float]) -> None:
    """Draw the hand and the object, without forces, from the grasp's own side.

    inches : width and height of the panel.
    """
    points = shown.grasp.scene.positions
    if shown.glass is None:  # one contact alone has no size
        points = (points[:, None] + 0.5 * shown.size * np.concatenate([np.eye(3), -np.eye(3)])).reshape(-1, 3)
    over, view, _ = stage(ax, shown, points, inches, 0.12)
    over.triad(np.array([view.box[0], view.box[2]]) + np.array([0.5, 0.4]) * view.inch)


def _surface(ax: Any, camera: Camera, env: Envelope, s: Surface, inches: tuple[float, float]) -> None:
    """The surface, the bound's lines around it, axes, the weakest direction."""
    from matplotlib.collections import LineCollection

    inch = 2.0 * ROOM * s.reach / min(inches[0], inches[1] - 0.35)
    w, h = inches[0] * inch, inches[1] * inch
    low = -h / 2 - 0.12 * inch
    box = (-w / 2, w / 2, low, low + h)
    view = Frame(box, box, inch, False)
    bodies = [Body(s.points[s.cells[s.key == k]], rgb(key.colour)) for k, key in enumerate(s.keys)]
    before = paint(ax, camera, [b for b in bodies if len(b.triangles)], None, view, DPI)
    over = Overlay(ax, camera, inch)
    if len(lines := borders(s)):
        near = before(lines.mean(axis=1))[:, 0] < 0.01 * s.reach
        ax.add_collection(LineCollection(list(camera.project(lines[near])), colors="white", linewidths=0.8, zorder=2.9))
    if s.bound_beyond and len(lines := wires(s)):
        hidden = before(lines.mean(axis=1))[:, 0] > 0.01 * s.reach
        cut = np.linalg.norm(lines, axis=2).min(axis=1) > 0.999 * s.reach
        style: dict[str, Any] = {"colors": INK, "zorder": 3, "linewidths": 0.6}
        for some, alpha in ((~hidden & ~cut, 0.75), (~hidden & cut, 0.3)):
            ax.add_collection(LineCollection(list(camera.project(lines[some])), alpha=alpha, **style))
    _axes(ax, camera, s, before)
    _weakest(ax, camera, env, s, before)
    bar = nice(0.9 * inch)
    text = f"{bar:g} {env.unit}".strip()
    over.scale_bar(np.array([box[0] + 0.25 * inch, box[2] + 0.16 * inch]), bar, text)


def _axes(ax: Any, camera: Camera, s: Surface, before: Any) -> None:
    """Where the axes leave the surface, as far as its reach."""
    from matplotlib import patheffects

    halo = patheffects.withStroke(linewidth=2.2, foreground="white")
    for way in (*np.eye(3), *-np.eye(3)):
        points = np.linspace(0.0, 1.06 * s.reach, 120)[:, None] * way
        seen = before(points)[:, 0] < 0.004 * s.reach
        flat = camera.project(points)
        flat[~seen] = np.nan
        ax.plot(*flat.T, color=GREY, linewidth=1.0, zorder=3.5)
        if seen[-1] and np.linalg.norm(camera.project(way)) > 0.2:
            end = camera.project(1.13 * s.reach * way)
            style = {"fontsize": SMALL, "weight": "bold", "color": GREY, "ha": "center", "va": "center", "zorder": 8}
            ax.text(*end, direction(way), **style).set_path_effects([halo])


def _weakest(ax: Any, camera: Camera, env: Envelope, s: Surface, before: Any) -> None:
    """Its point, with the load beside it, where it is on the near side."""
    from matplotlib import patheffects

    w = env.weakest
    point = s.points[w.number]
    if before(point[None] * 1.02)[0, 0] > 0.03 * s.reach or not 0.0 < w.factor < np.inf:
        return
    at = camera.project(point)
    ax.plot(*at, "o", markersize=6.5, markerfacecolor=MARK, markeredgecolor="white", markeredgewidth=1.0, zorder=9)
    away = 1.0 if at[0] >= 0 else -1.0
    end = np.array([away * 0.62 * s.reach, at[1] + 0.45 * s.reach * (1.0 if at[1] >= 0 else -1.0)])
    ax.plot([at[0], end[0]], [at[1], end[1]], color=MARK, linewidth=0.9, zorder=8.5)
    style: dict[str, Any] = {"fontsize": SMALL, "color": MARK, "weight": "bold", "va": "center", "zorder": 9}
    says = f"weakest\n{amount(env, w.factor).partition(' (')[0]}"
    text = ax.text(*end, says, ha="left" if away > 0 else "right", **style)
    text.set_path_effects([patheffects.withStroke(linewidth=2.5, foreground="white")])
