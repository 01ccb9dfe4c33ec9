"""One picture of a solved grasp: hand, object, friction cones, forces, slips, load, verdict.

The view is orthographic. Friction cones have the scale of the forces: a finger slides when its arrow reaches the rim.
Projection and hidden surfaces are computed here, because matplotlib's 3D axes clip what leaves their box, sort whole
collections by depth, and cannot draw over solids.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools
from handlcp.grasp import Grasp, GraspSolution, Verdict
from handlcp.hand import Candidate
from handlcp.show.file import Figure, new_figure
from handlcp.show.picture.camera import Camera, Frame, frame
from handlcp.show.picture.content import ESCAPE, LOAD, SLIP, Content
from handlcp.show.picture.labels import LETTERS, Label, place, room, widest
from handlcp.show.picture.overlay import Overlay, nice
from handlcp.show.picture.painter import creases, paint
from handlcp.show.picture.panel import (
    GHOST,
    Entry,
    Unseen,
    contact_labels,
    entries,
    headline,
    legend,
    state_drawn,
    torque_bars,
)
from handlcp.show.style import shortened

WIDTH, HEIGHT, DPI = 10.0, 6.6, 160  # inches, dots an inch
SCENE = 0.70  # of the width; the rest is the panel
ASIDE = 0.16  # inches between two arrows that would cover each other


def draw(
    grasp: Grasp, solution: GraspSolution, obj: Any = None, title: str = "", verdict: Verdict | None = None
) -> Figure:
    """Draw a solved grasp as one figure: hand, object, forces, legend and verdict.

    obj : what to draw as the object when the grasp does not know it; None: the hull of the contacts.
    verdict : of `check`; None: the solution's. Where the solution is the last step of the loading that `check`
    followed, the environment stays where it was, and what is drawn is said to be the end.

    Raises Unsupported when matplotlib is not installed.
    """
    figure = new_figure(figsize=(WIDTH, HEIGHT))
    said = solution.verdict if verdict is None else verdict
    path = said.loading
    at_end = path is not None and np.array_equal(path.solution.forces, solution.forces)
    shown = Content(grasp, solution, obj, Grasp(path.steps.grasp.spec) if at_end else None, said)
    head = headline(figure, said, title, state_drawn(shown, path, at_end))
    compose(figure, shown, head)
    return figure


def compose(figure: Figure, shown: Content, head: float) -> None:
    """The picture, its legend and the joint torques, below `head`, a share of the figure's height."""
    bottom = legend(figure, 0.722, head - 0.03, _scene(figure, shown, head))
    if shown.solution.held and (check := getattr(shown.solution, "torque_check", None)) is not None:
        torque_bars(figure, (0.725, 0.25), bottom - 0.055, check)


def stage(
    ax: Any,
    shown: Content,
    reach: Array,
    inches: tuple[float, float],
    margin: float,
    dpi: float = DPI,
    camera: Camera | None = None,
    least: float = 0.0,
) -> tuple[Overlay, Frame, Bools]:
    """Solids and object, with the points of `reach` (k, 3) in sight; returns what draws over them, the limits on the
    screen, and which contacts the viewer does not see. camera : None: the grasp's own. Others as in `frame`.
    """
    camera = shown.camera if camera is None else camera
    view = frame(camera, shown.solids, shown.glass, reach, inches, margin, least)
    before = paint(ax, camera, shown.solids, shown.glass, view, dpi)
    return Overlay(ax, camera, view.inch), view, shown.hidden(before(shown.grasp.scene.positions))


def _scene(figure: Any, shown: Content, head: float) -> list[Entry]:
    """The picture proper, below `head` (a share of the height); returns its legend."""
    inches = (WIDTH * SCENE, HEIGHT * (head - 0.02))
    said = contact_labels(shown, room(inches[1]))
    ax = figure.add_axes((0.005, 0.01, SCENE, head - 0.02))
    names = shortened([name for _, name, _ in said], LETTERS)
    margin = min(0.30 + widest(figure, names, [detail for _, _, detail in said]), 0.36 * inches[0])
    over, view, hidden = stage(ax, shown, shown.reach(), inches, margin)
    unseen = _arrows(over, shown, hidden)
    at = shown.camera.project(shown.grasp.scene.positions)
    written = [Label(at[list(who)], name, detail, shown.colours[who[0]]) for who, name, detail in said]
    place(ax, written, view)
    _scales(over, shown, view)
    return entries(shown, unseen, bool(hidden[shown.drawn].any()))


def _arrows(over: Overlay, shown: Content, hidden: Bools) -> Unseen:
    """Cones, arrows, arcs and contact points; returns what of it is too small to draw."""
    scene = shown.grasp.scene
    for triangles in shown.tips:
        over.shape(triangles)
    if shown.ghost is not None:
        over.edges(creases(over.camera, shown.ghost), GHOST)
    for i, p in enumerate(scene.positions):
        if shown.cone_height(i) > 0.0:
            over.cone(p, shown.rim(i), shown.colours[i])
    if shown.turn is not None:
        over.turn(shown.turn, LOAD, 1.15)
    load_seen = shown.load == 0.0 or over.arrow(shown.acts_at, shown.pull, LOAD, 1.15)
    for i in shown.drawn:
        p, force = scene.positions[i], shown.forces[i]
        if (turn := shown.turns.get(i)) is not None:
            over.turn(turn, shown.colours[i])
        over.arrow(p, force, shown.colours[i])
        over.dot(p, shown.colours[i], bool(hidden[i]))
    drawn = {i for i, slip in shown.slips.items() if over.arrow(scene.positions[i], slip, SLIP, 0.85)}
    if shown.escape.any():
        over.arrow(_beside(over, shown), shown.escape, ESCAPE, 1.5, dashed=True)
    if shown.escape_turn is not None:
        over.turn(shown.escape_turn, ESCAPE, 1.3, dashed=True)
    return Unseen([i for i in shown.sliding if i not in drawn], not load_seen)


def _beside(over: Overlay, shown: Content) -> Array:
    """Where the arrow of the escape starts: beside the load's, where one would cover the other."""
    a, b = over.camera.project(shown.pull), over.camera.project(shown.escape)
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    if size == 0.0 or abs(a @ b) < 0.9 * size:
        return shown.acts_at
    across = np.array([b[1], -b[0]]) / np.linalg.norm(b)
    return np.asarray(shown.acts_at + ASIDE * over.inch * across @ over.camera.axes[:2])


def _scales(over: Overlay, shown: Content, view: Frame) -> None:
    """Axes, and scales of lengths and forces, in the lower left corner."""
    corner = np.array([view.box[0], view.box[2]])
    over.triad(corner + np.array([0.56, 0.42]) * view.inch)
    bar = nice(1.1 * view.inch)
    over.scale_bar(corner + np.array([1.25, 0.22]) * view.inch, bar, words.length(bar))
    if shown.forces.any() or shown.load > 0:
        amount = nice(0.65 * view.inch / shown.per_newton)
        start = corner + np.array([1.65 * view.inch + bar, 0.22 * view.inch])
        over.force_scale(start, amount * shown.per_newton, words.force(amount))


# ----------------------------------------------------------------
# Small pictures of several grasps, alike: hand, object and forces, without numbers.

CELL, FINE, _MARGIN = 4.0, 110, 0.1  # inches of a picture; dots an inch; inches around the scene


def alike(grasps: list[Candidate | None]) -> list[bytes]:
    """A png for each grasp, from the same side and to the same scales of lengths and forces; b"" for None.

    The side is that from which most of the first is seen. Raises Unsupported without matplotlib.
    """
    every = [None if one is None else _content(one) for one in grasps]
    known = [shown for shown in every if shown is not None]
    if not known:
        return [b""] * len(grasps)
    camera, newton = known[0].camera, min(shown.per_newton for shown in known)
    frames = [frame(camera, s.solids, s.glass, s.reach(), (CELL, CELL), _MARGIN) for s in known]
    found = list[bytes]()
    for shown in every:
        figure, made = new_figure(figsize=(CELL, CELL)), io.BytesIO()
        if shown is not None:
            ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
            ax.axis("off")
            _small(ax, shown, FINE, camera, max(f.inch for f in frames), newton / shown.per_newton)
            figure.savefig(made, dpi=FINE, facecolor="white", format="png")
        found.append(made.getvalue())
    return found


def _content(candidate: Candidate) -> Content:
    return Content(candidate.grasp, candidate.solution, None, verdict=candidate.verdict)


def _small(ax: Any, shown: Content, dpi: float, camera: Camera, least: float, share: float) -> None:
    """Draw a small picture without numbers: hand, object and forces.

    camera, least : as of `stage`. share : factor on the lengths of arrows.
    """
    over, _, hidden = stage(ax, shown, shown.reach(), (CELL, CELL), _MARGIN, dpi, camera, least)
    if shown.load > 0:
        over.arrow(shown.acts_at, share * shown.pull, LOAD, 1.6)
    for i in shown.drawn:
        p, force = shown.grasp.scene.positions[i], share * shown.forces[i]
        over.arrow(p, force, shown.colours[i], 1.6)
        over.dot(p, shown.colours[i], bool(hidden[i]))
