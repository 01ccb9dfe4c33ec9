"""Doors into what people look at: tables, units, records, pictures and their geometry, figures of studies."""

from __future__ import annotations

from typing import Any

import numpy as np

import handlcp as hl
from handlcp import words as units
from handlcp.grasp.path.events import summary
from handlcp.show import accuracy as work_precision_figure, tables
from handlcp.show.accuracy import all_tables
from handlcp.show.envelope.page import facing as facing_weakest
from handlcp.show.envelope.surface import NOTHING, OTHERS, SHADES, divided, section, surface_of, wires
from handlcp.show.file import drawn
from handlcp.show.loading.draw import figure as loading_figure
from handlcp.show.loading.report import picture as loading_picture
from handlcp.show.loading.series import grasp_at_end, solution_at_end
from handlcp.show.picture import shapes
from handlcp.show.picture.bodies import environment_bodies, hand_bodies, stub_bodies, tip_shapes
from handlcp.show.picture.camera import Marks, camera_for, facing, fill
from handlcp.show.picture.figure import draw
from handlcp.show.picture.overlay import Turn, nice, rim
from handlcp.show.record import record
from handlcp.show.style import moved, shortened

__all__ = [
    "ENVELOPE_COLOURS",
    "ENVELOPE_GREYS",
    "Turn",
    "all_tables",
    "camera_of",
    "divided",
    "draw",
    "environment_bodies",
    "events_in_short",
    "facing",
    "facing_weakest",
    "fill",
    "grasp_at_end",
    "hand_bodies",
    "html",
    "loading_figure",
    "loading_picture",
    "moved",
    "nice",
    "record",
    "rim",
    "save",
    "section",
    "shapes",
    "shortened",
    "solution_at_end",
    "stub_bodies",
    "surface_of",
    "tables",
    "tip_shapes",
    "units",
    "wires",
    "work_precision_figure",
]

ENVELOPE_COLOURS, ENVELOPE_GREYS = SHADES, (NOTHING, OTHERS)


def events_in_short(events: Any, grasp: hl.Grasp) -> list[str]:
    """What happens, in the order and words of `Loading`: events of several fingers at one place in one line."""
    return [str(s) for s in summary(events, grasp.spec)]


def html(solution: Any) -> str:
    """What a notebook shows of it."""
    return solution._repr_html_()


def save(grasp: hl.Grasp, solution: hl.GraspSolution, path: Any, title: str = "") -> Any:
    """The picture of a grasp as a file, which also an answer of unknown origin may have."""
    return drawn(path, draw, grasp, solution, None, title)


def camera_of(grasp: hl.Grasp) -> Any:
    """From where the picture of a grasp without bodies is taken."""
    none = np.zeros((0, 3))
    return camera_for(grasp, [], None, Marks(np.array([c.position for c in grasp.contacts]), none, none))
