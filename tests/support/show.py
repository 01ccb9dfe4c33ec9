"""Doors into what people look at: tables, units, records, pictures and their geometry, figures of studies."""

from __future__ import annotations

from typing import Any

import numpy as np

import handlcp as hl
from handlcp import words as units
from handlcp.grasp.path.events import summary
from handlcp.viz import accuracy as work_precision_figure, terminal_table as tables
from handlcp.viz.accuracy import all_tables
from handlcp.viz.envelope.page import choose_view_axes as facing_weakest
from handlcp.viz.envelope.surface import (
    CAUSE_SHADES,
    NO_CAUSE_COLOUR,
    OTHER_CAUSES_COLOUR,
    bound_lines,
    cut_by_plane,
    divide_mixed_cells,
    make_surface,
)
from handlcp.viz.loading.curves import grasp_at_end, solution_at_end
from handlcp.viz.loading.figure import draw_end_picture as loading_picture, draw_loading as loading_figure
from handlcp.viz.output_file import draw_or_save
from handlcp.viz.picture import body as shapes
from handlcp.viz.picture.body import environment_bodies, hand_bodies, stub_bodies, undrawn_tip_shapes
from handlcp.viz.picture.camera import ScreenMarks, camera_against, choose_camera, fill_triangles
from handlcp.viz.picture.figure import draw_solution
from handlcp.viz.picture.overlay import RotationArc, friction_cone_rim, nice_number
from handlcp.viz.solution_output import solution_record
from handlcp.viz.style import describe_motion, shorten_names

__all__ = [
    "ENVELOPE_COLOURS",
    "ENVELOPE_GREYS",
    "RotationArc",
    "all_tables",
    "bound_lines",
    "camera_against",
    "camera_of",
    "cut_by_plane",
    "describe_motion",
    "divide_mixed_cells",
    "draw_solution",
    "environment_bodies",
    "events_in_short",
    "facing_weakest",
    "fill_triangles",
    "friction_cone_rim",
    "grasp_at_end",
    "hand_bodies",
    "html",
    "loading_figure",
    "loading_picture",
    "make_surface",
    "nice_number",
    "save",
    "shapes",
    "shorten_names",
    "solution_at_end",
    "solution_record",
    "stub_bodies",
    "tables",
    "undrawn_tip_shapes",
    "units",
    "work_precision_figure",
]

ENVELOPE_COLOURS, ENVELOPE_GREYS = CAUSE_SHADES, (NO_CAUSE_COLOUR, OTHER_CAUSES_COLOUR)


def events_in_short(events: Any, grasp: hl.Grasp) -> list[str]:
    """What happens, in the order and words of `Loading`: events of several fingers at one place in one line."""
    return [str(s) for s in summary(events, grasp.spec)]


def html(solution: Any) -> str:
    """What a notebook shows of it."""
    return solution._repr_html_()


def save(grasp: hl.Grasp, solution: hl.GraspSolution, path: Any, title: str = "") -> Any:
    """The picture of a grasp as a file, which also an answer of unknown origin may have."""
    return draw_or_save(path, draw_solution, grasp, solution, None, title)


def camera_of(grasp: hl.Grasp) -> Any:
    """From where the picture of a grasp without bodies is taken."""
    none = np.zeros((0, 3))
    return choose_camera(grasp, [], None, ScreenMarks(np.array([c.position for c in grasp.contacts]), none, none))
