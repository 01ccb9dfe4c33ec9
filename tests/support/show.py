"""Doors into what people look at: tables, units, records, pictures and their geometry, figures of studies."""

from __future__ import annotations

from typing import Any

import numpy as np

import handlcp as hl
from handlcp import words as units
from handlcp.show import convergence as convergence_figure
from handlcp.show import picture as _picture
from handlcp.show import tables
from handlcp.show import work_precision as work_precision_figure
from handlcp.show.accuracy_table import all_tables
from handlcp.show.picture import shapes
from handlcp.show.picture.bodies import environment_bodies, stub_bodies
from handlcp.show.picture.camera import camera_for, facing
from handlcp.show.picture.overlay import nice, rim
from handlcp.show.picture.raster import fill
from handlcp.show.record import record

__all__ = [
    "all_tables",
    "camera_of",
    "convergence_figure",
    "draw",
    "environment_bodies",
    "facing",
    "fill",
    "nice",
    "record",
    "rim",
    "save",
    "shapes",
    "stub_bodies",
    "tables",
    "units",
    "work_precision_figure",
]

draw, save = _picture.draw, _picture.save


def camera_of(grasp: hl.Grasp) -> Any:
    """From where the picture of a grasp without bodies is taken."""
    return camera_for(grasp, [], None, np.array([c.position for c in grasp.contacts]))
