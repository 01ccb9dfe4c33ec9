"""The shapes of objects: box, ball, cylinder, ellipsoid, mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import coal
import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError
from handlcp.hand.objects.meshes import in_memory, load_mesh, surfaces_of
from handlcp.hand.objects.object import BALL, BOX, CYLINDER, ELLIPSOID, Object, Solid
from handlcp.hand.objects.solid import box_of
from handlcp.hand.objects.surface import Closed, Hull
from handlcp.hand.robot.convex import convex_parts
from handlcp.keywords import helped_init


@helped_init()
class Box(Object):
    """A box with edges `size` (3,) [m] along its axes, centred on its frame (a number: a cube)."""

    __slots__ = ("size",)

    def __init__(self, size: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.size = _lengths("size", size)
        solid = Solid(coal.Box(*self.size), float(np.prod(self.size)))
        super().__init__(solid, placement, mass, density, (self.size,), (BOX, 0.5 * self.size))


@helped_init()
class Sphere(Object):
    """A ball of `radius` [m]."""

    __slots__ = ("radius",)

    def __init__(self, radius: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.radius = number("radius", radius, above=0.0)
        solid = Solid(coal.Sphere(self.radius), 4 / 3 * np.pi * self.radius**3)
        super().__init__(solid, placement, mass, density, (self.radius,), (BALL, np.full(3, self.radius)))


@helped_init()
class Cylinder(Object):
    """A cylinder of `radius` and `length` [m] along its z axis, centred on its frame.

    For a ball with its centre inside the cylinder, near an end, coal 3.0.3 measures -24 mm instead of -11 mm.
    """

    __slots__ = ("length", "radius")

    def __init__(
        self, radius: Any, length: Any, placement: Any = None, mass: Any = None, *, density: Any = None
    ) -> None:
        self.radius, self.length = number("radius", radius, above=0.0), number("length", length, above=0.0)
        solid = Solid(coal.Cylinder(self.radius, self.length), np.pi * self.radius**2 * self.length)
        sizes = np.array([self.radius, 0.5 * self.length, 0.0])
        super().__init__(solid, placement, mass, density, (self.radius, self.length), (CYLINDER, sizes))


@helped_init()
class Ellipsoid(Object):
    """An ellipsoid with semi-axes `radii` (3,) [m] along its axes.

    coal's distance to an ellipsoid is iterative: points are good to about 1e-6 m, normals to 1e-4. That to spherical
    fingertips is computed here, to rounding.
    """

    __slots__ = ("radii",)

    def __init__(self, radii: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.radii = _lengths("radii", radii)
        solid = Solid(coal.Ellipsoid(*self.radii), 4 / 3 * np.pi * float(np.prod(self.radii)))
        super().__init__(solid, placement, mass, density, (self.radii,), (ELLIPSOID, np.array(self.radii)))


@helped_init()
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
        scales = array("scale", 1.0 if scale is None else scale, (), (3,))
        if not (scales > 0).all():
            raise InputError("scale", "numbers above 0", repr(scale))
        inside = surfaces_of(path) if in_memory(path) else None
        solid = load_mesh(path if inside is None else inside, None if scale is None else np.ones(3) * scales)
        self.path = None if inside is not None else Path(path)
        self.scale, self.convex = scales, solid.triangles is None
        self._surface = Hull(solid.geometry) if solid.triangles is None else Closed(solid.triangles)
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
        return self._surface.beyond(points) if isinstance(self._surface, Hull) else None

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Of a convex mesh by its planes and visible faces, of any other by its triangles and the winding number."""
        away, on, out = self.closest_all(point[None])
        return float(away[0]), on[0], out[0]

    def closest_all(self, points: Array) -> tuple[Array, Array, Array]:
        """As `closest` of points (m, 3)."""
        R, p = self.frame
        away, on, out = self._surface.closest((points - p) @ R)
        return away, on @ R.T + p, out @ R.T


_WIDE, _TIMES = 5.0, 20.0  # [m], and times the hand's size: what is wider was not given in metres


_HEAVY, _TIMES_ITS_OWN = 50.0, 50.0  # kg, and hands' own mass: what is heavier is given in grams


def ask_for_metres(argument: str, obj: Object, tips: Array) -> None:
    """Raises InputError for an object far wider than a hand with fingertips at (n, 3) [m]; a mesh was asked before."""
    size = float(np.sqrt((tips * tips).sum(axis=1)).max())
    low, high = box_of(obj.geometry)
    wide = float((high - low).max())
    if wide > max(_WIDE, _TIMES * size) and not isinstance(obj, Mesh):
        came = f"{obj!r}, {wide:.3g} m wide in a hand of {size:.2g} m: are these millimetres?"
        raise InputError(argument, "an object in metres", came)


def ask_for_kilograms(argument: str, obj: Object, hand: float) -> None:
    """Raises InputError for an object that weighs far more than any hand lifts. hand : its own mass [kg]."""
    if obj.mass > max(_HEAVY, _TIMES_ITS_OWN * hand):
        own = f" for a hand of {hand:.3g} kg" if hand > 0.0 else ""
        raise InputError(argument, "a mass in kilograms", f"{obj.mass:g} kg{own} (grams? {obj.mass / 1e3:g})")


def far_from(argument: str, positions: Array, tips: Array) -> None:
    """Raises InputError for contacts (n, 3) so far from their fingertips (n, 3) that they are not in metres."""
    size, away = float(np.sqrt((tips * tips).sum(axis=1)).max()), positions - tips
    far = float(np.sqrt((away * away).sum(axis=1)).max())
    if far > max(_WIDE, _TIMES * size):
        came = f"one {far:.3g} m from its fingertip, on a hand of {size:.2g} m: are these millimetres?"
        raise InputError(argument, "positions in metres", came)


def _lengths(argument: str, value: Any) -> Array:
    a = array(argument, value, (3,), ())
    if not (a > 0).all():
        raise InputError(argument, "lengths above 0", repr(a.tolist()))
    return read_only(np.ones(3) * a)
