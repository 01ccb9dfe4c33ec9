"""One picture of a solved grasp: hand, object, friction cones, forces, slips, load, verdict.

The view is orthographic. Friction cones have the scale of the forces: a finger slides when its arrow reaches the rim.
Projection and hidden surfaces are computed here, because matplotlib's 3D axes clip what leaves their box, sort whole
collections by depth, and cannot draw over solids.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from handlcp import words
from handlcp.grasp import Grasp, GraspSolution, Verdict
from handlcp.show.file import Figure, checked, new_figure, write
from handlcp.show.picture import labels
from handlcp.show.picture.camera import Frame, camera_for, frame
from handlcp.show.picture.content import ESCAPE, LOAD, SLIP, Content
from handlcp.show.picture.overlay import Overlay, nice, rim
from handlcp.show.picture.painter import paint
from handlcp.show.picture.panel import headline, legend, torque_bars

__all__ = ["DPI", "HEIGHT", "WIDTH", "compose", "draw", "save"]

WIDTH, HEIGHT, DPI = 10.0, 6.6, 160  # inches, dots an inch
SCENE = 0.70  # of the width; the rest is the panel


def save(
    grasp: Grasp, solution: GraspSolution, path: Any, obj: Any = None, title: str = "", verdict: Verdict | None = None
) -> Path:
    """Draw and write a file; see `draw`. Raises InputError for an unknown format or a folder that does not exist."""
    file = checked(path)
    return write(draw(grasp, solution, obj, title, verdict), file, DPI)


def draw(
    grasp: Grasp, solution: GraspSolution, obj: Any = None, title: str = "", verdict: Verdict | None = None
) -> Figure:
    """The figure. obj : what to draw as the object when the grasp does not know it; None: the hull of the contacts.
    verdict : of `check`; None: the solution's.

    Raises Unsupported when matplotlib is not installed.
    """
    figure = new_figure(figsize=(WIDTH, HEIGHT))
    head = headline(figure, solution.verdict if verdict is None else verdict, title)
    compose(figure, Content(grasp, solution, obj), head)
    return figure


def compose(figure: Figure, shown: Content, head: float) -> None:
    """The picture, its legend and the joint torques, below `head`, a share of the figure's height."""
    _scene(figure, shown, head)
    bottom = legend(figure, 0.722, head - 0.03, shown.entries())
    if shown.solution.held and (check := getattr(shown.solution, "torque_check", None)) is not None:
        torque_bars(figure, (0.725, 0.25), bottom - 0.055, check)


def _scene(figure: Any, shown: Content, head: float) -> None:
    """The picture proper, below `head` (a share of the height)."""
    scene, names = shown.grasp.scene, shown.solution.names
    details = [shown.detail(i) for i in range(scene.n)]
    camera = camera_for(shown.grasp, shown.solids, shown.glass, shown.marks())
    ax = figure.add_axes((0.005, 0.01, SCENE, head - 0.02))
    inches = (WIDTH * SCENE, HEIGHT * (head - 0.02))
    margin = min(0.30 + labels.widest(figure, names, details), 0.35 * inches[0])
    view = frame(camera, shown.solids, shown.glass, shown.reach(), inches, margin)
    ax.axis("off")
    paint(ax, camera, shown.solids, shown.glass, view, DPI)
    _arrows(Overlay(ax, camera, view.inch), shown)
    points = zip(camera.project(scene.positions), names, details, shown.colours, strict=True)
    labels.place(ax, [labels.Label(*each) for each in points], view)
    _scales(Overlay(ax, camera, view.inch), shown, view)
    ax.set_xlim(view.box[:2])
    ax.set_ylim(view.box[2:])


def _arrows(over: Overlay, shown: Content) -> None:
    scene = shown.grasp.scene
    for i, p in enumerate(scene.positions):
        if (height := shown.cone_height(i)) > 0.0:
            edge = rim(p, scene.frames[i], height, float(scene.mu[i]), scene.plane is not None)
            over.cone(p, edge, shown.colours[i])
    if shown.load > 0:
        over.arrow(shown.acts_at, shown.pull, LOAD, 1.15)
    for p, force, colour in zip(scene.positions, shown.forces, shown.colours, strict=True):
        over.arrow(p, force, colour)
        over.dot(p, colour)
    for i, slip in shown.slips.items():
        over.arrow(scene.positions[i], slip, SLIP, 0.85)
    if shown.escape.any():
        over.arrow(shown.acts_at, shown.escape, ESCAPE, 1.5, dashed=True)


def _scales(over: Overlay, shown: Content, view: Frame) -> None:
    """Axes, and scales of lengths and forces, in the lower left corner."""
    corner = np.array([view.box[0], view.box[2]])
    over.triad(corner + np.array([0.56, 0.42]) * view.inch)
    bar = nice(1.1 * view.inch)
    over.scale_bar(corner + np.array([1.25, 0.22]) * view.inch, bar, words.length(bar))
    if shown.solution.held or shown.load > 0:
        amount = nice(0.65 * view.inch / shown.per_newton)
        start = corner + np.array([1.65 * view.inch + bar, 0.22 * view.inch])
        over.force_scale(start, amount * shown.per_newton, words.force(amount))
