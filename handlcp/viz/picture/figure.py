"""`draw_solution`: one picture of a solved grasp: hand, object, friction cones, forces, slips, load, verdict.

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
from handlcp.viz.output_file import Figure, new_figure
from handlcp.viz.picture.camera import Camera, ViewLimits, fit_view
from handlcp.viz.picture.content import ESCAPE_COLOUR, LOAD_COLOUR, SLIP_COLOUR, PictureContent
from handlcp.viz.picture.overlay import (
    MAX_NAME_LETTERS,
    ContactLabel,
    Overlay,
    label_capacity,
    nice_number,
    place_labels,
    widest_label,
)
from handlcp.viz.picture.painter import drawn_edges, paint_bodies
from handlcp.viz.picture.panel import (
    MOVED_OBJECT_COLOUR,
    LegendEntry,
    describe_drawn_state,
    draw_legend,
    draw_torque_bars,
    draw_verdict_headline,
    legend_entries,
    make_label_texts,
)
from handlcp.viz.style import shorten_names

PICTURE_WIDTH, PICTURE_HEIGHT, PICTURE_DPI = 10.0, 6.6, 160  # inches, dots an inch
SCENE_WIDTH = 0.70  # of the width; the rest is the panel
ARROW_GAP = 0.16  # inches between two arrows that would cover each other


def draw_solution(
    grasp: Grasp, solution: GraspSolution, obj: Any = None, title: str = "", verdict: Verdict | None = None
) -> Figure:
    """Draw a solved grasp as one figure: hand, object, forces, legend and verdict.

    obj : what to draw as the object when the grasp does not know it; None: the hull of the contacts.
    verdict : of `check`; None: the solution's. Where the solution is the last step of the loading that `check`
    followed, the environment stays where it was, and what is drawn is said to be the end.

    Raises Unsupported when matplotlib is not installed.
    """
    figure = new_figure(figsize=(PICTURE_WIDTH, PICTURE_HEIGHT))
    said = solution.verdict if verdict is None else verdict
    path = said.loading
    at_end = path is not None and np.array_equal(path.solution.forces, solution.forces)
    shown = PictureContent(grasp, solution, obj, Grasp(path.steps.grasp.spec) if at_end else None, said)
    head = draw_verdict_headline(figure, said, title, describe_drawn_state(shown, path, at_end))
    compose_picture(figure, shown, head)
    return figure


def compose_picture(figure: Figure, shown: PictureContent, head: float) -> None:
    """The picture, its legend and the joint torques, below `head`, a share of the figure's height."""
    bottom = draw_legend(figure, 0.722, head - 0.03, _draw_scene(figure, shown, head))
    if shown.solution.held and (check := getattr(shown.solution, "torque_check", None)) is not None:
        draw_torque_bars(figure, (0.725, 0.25), bottom - 0.055, check)


def draw_bodies(
    ax: Any,
    shown: PictureContent,
    reach: Array,
    inches: tuple[float, float],
    margin: float,
    dpi: float = PICTURE_DPI,
    camera: Camera | None = None,
    least: float = 0.0,
) -> tuple[Overlay, ViewLimits, Bools]:
    """Solids and object, with the points of `reach` (k, 3) in sight; returns what draws over them, the limits on the
    screen, and which contacts the viewer does not see. camera : None: the grasp's own. Others as in `fit_view`.
    """
    camera = shown.camera if camera is None else camera
    view = fit_view(camera, shown.solids, shown.object_body, reach, inches, margin, least)
    before = paint_bodies(ax, camera, shown.solids, shown.object_body, view, dpi)
    return Overlay(ax, camera, view.inch), view, shown.are_hidden(before(shown.grasp.scene.positions))


def _draw_scene(figure: Any, shown: PictureContent, head: float) -> list[LegendEntry]:
    """The picture proper, below `head` (a share of the height); returns its legend."""
    inches = (PICTURE_WIDTH * SCENE_WIDTH, PICTURE_HEIGHT * (head - 0.02))
    said = make_label_texts(shown, label_capacity(inches[1]))
    ax = figure.add_axes((0.005, 0.01, SCENE_WIDTH, head - 0.02))
    names = shorten_names([name for _, name, _ in said], MAX_NAME_LETTERS)
    margin = min(0.30 + widest_label(figure, names, [detail for _, _, detail in said]), 0.36 * inches[0])
    over, view, hidden = draw_bodies(ax, shown, shown.extent_points(), inches, margin)
    unseen, load_seen = _draw_arrows(over, shown, hidden)
    at = shown.camera.project(shown.grasp.scene.positions)
    written = [ContactLabel(at[list(who)], name, detail, shown.contact_colours[who[0]]) for who, name, detail in said]
    place_labels(ax, written, view)
    _draw_scales(over, shown, view)
    return legend_entries(shown, unseen, load_seen, bool(hidden[shown.drawn_contacts].any()))


def _draw_arrows(over: Overlay, shown: PictureContent, hidden: Bools) -> tuple[list[int], bool]:
    """Cones, arrows, arcs and contact points; returns the contacts whose slips are too small to draw, and whether the
    load is not.
    """
    scene = shown.grasp.scene
    for triangles in shown.tip_triangles:
        over.draw_shape(triangles)
    if shown.moved_object is not None:
        over.draw_edges(drawn_edges(over.camera, shown.moved_object), MOVED_OBJECT_COLOUR)
    for i, p in enumerate(scene.positions):
        if shown.cone_height(i) > 0.0:
            over.draw_cone(p, shown.cone_rim(i), shown.contact_colours[i])
    if shown.torque_arc is not None:
        over.draw_arc(shown.torque_arc, LOAD_COLOUR, 1.15)
    load_seen = shown.load_size == 0.0 or over.draw_arrow(shown.acts_at, shown.load_arrow, LOAD_COLOUR, 1.15)
    for i in shown.drawn_contacts:
        p, force = scene.positions[i], shown.force_arrows[i]
        if (turn := shown.moment_arcs.get(i)) is not None:
            over.draw_arc(turn, shown.contact_colours[i])
        over.draw_arrow(p, force, shown.contact_colours[i])
        over.draw_contact_point(p, shown.contact_colours[i], bool(hidden[i]))
    drawn = {i for i, slip in shown.slip_arrows.items() if over.draw_arrow(scene.positions[i], slip, SLIP_COLOUR, 0.85)}
    if shown.escape_arrow.any():
        over.draw_arrow(_choose_escape_start(over, shown), shown.escape_arrow, ESCAPE_COLOUR, 1.5, dashed=True)
    if shown.escape_arc is not None:
        over.draw_arc(shown.escape_arc, ESCAPE_COLOUR, 1.3, dashed=True)
    return [i for i in shown.sliding_contacts if i not in drawn], load_seen


def _choose_escape_start(over: Overlay, shown: PictureContent) -> Array:
    """Where the arrow of the escape starts: beside the load's, where one would cover the other."""
    a, b = over.camera.project(shown.load_arrow), over.camera.project(shown.escape_arrow)
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    if size == 0.0 or abs(a @ b) < 0.9 * size:
        return shown.acts_at
    across = np.array([b[1], -b[0]]) / np.linalg.norm(b)
    return np.asarray(shown.acts_at + ARROW_GAP * over.inch * across @ over.camera.axes[:2])


def _draw_scales(over: Overlay, shown: PictureContent, view: ViewLimits) -> None:
    """Axes, and scales of lengths and forces, in the lower left corner."""
    corner = np.array([view.box[0], view.box[2]])
    over.draw_triad(corner + np.array([0.56, 0.42]) * view.inch)
    bar = nice_number(1.1 * view.inch)
    over.draw_scale_bar(corner + np.array([1.25, 0.22]) * view.inch, bar, words.format_length(bar))
    if shown.force_arrows.any() or shown.load_size > 0:
        amount = nice_number(0.65 * view.inch / shown.per_newton)
        start = corner + np.array([1.65 * view.inch + bar, 0.22 * view.inch])
        over.draw_force_scale(start, amount * shown.per_newton, words.format_force(amount))


# ----------------------------------------------------------------
# Small pictures of several grasps, alike: hand, object and forces, without numbers.

SHEET_CELL, CELL_DPI, _CELL_MARGIN = 4.0, 110, 0.1  # inches of a picture; dots an inch; inches around the scene


def draw_comparable_pictures(grasps: list[Candidate | None]) -> list[bytes]:
    """A png for each grasp, from the same side and to the same scales of lengths and forces; b"" for None.

    The side is that from which most of the first is seen. Raises Unsupported without matplotlib.
    """
    every = [None if c is None else PictureContent(c.grasp, c.solution, None, verdict=c.verdict) for c in grasps]
    known = [shown for shown in every if shown is not None]
    if not known:
        return [b""] * len(grasps)
    camera, newton, cell = known[0].camera, min(shown.per_newton for shown in known), (SHEET_CELL, SHEET_CELL)
    views = [fit_view(camera, s.solids, s.object_body, s.extent_points(), cell, _CELL_MARGIN) for s in known]
    inch = max(view.inch for view in views)
    found = list[bytes]()
    for shown in every:
        figure, made = new_figure(figsize=cell), io.BytesIO()
        if shown is not None:
            ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
            ax.axis("off")
            share, reach = newton / shown.per_newton, shown.extent_points()
            over, _, hidden = draw_bodies(ax, shown, reach, cell, _CELL_MARGIN, CELL_DPI, camera, inch)
            if shown.load_size > 0:
                over.draw_arrow(shown.acts_at, share * shown.load_arrow, LOAD_COLOUR, 1.6)
            for i in shown.drawn_contacts:
                p, colour = shown.grasp.scene.positions[i], shown.contact_colours[i]
                over.draw_arrow(p, share * shown.force_arrows[i], colour, 1.6)
                over.draw_contact_point(p, colour, bool(hidden[i]))
            figure.savefig(made, dpi=CELL_DPI, facecolor="white", format="png")
        found.append(made.getvalue())
    return found
