"""The object in the hand: a coal shape with a placement and a mass, or a density that the shape turns into one."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError
from handlcp.grasp.entry import Entry
from handlcp.hand.meshes import load_mesh

__all__ = ["WEIGHS", "Box", "Cylinder", "Ellipsoid", "Mesh", "Object", "Sphere"]

WEIGHS = Entry(
    title="object weight",
    equation="w += (m g, (p_m - c) × m g)",
    when="The object's mass, or its density, and where its centre of mass is.",
    in_python="mass=0.3",
    in_file="object.mass_kg = 0.3",
    brings="none: part of the load",
    source="statics: the resultant of gravity acts at the centre of mass",
    module=__name__,
)


class Object:
    """Base of the shapes: a coal geometry, where it is, what it weighs. Immutable, picklable.

    placement : pin.SE3 of the shape's frame in the hand's world frame, or a position (3,) [m]; None: the origin.
    mass : [kg], ≥ 0; weighs at the centre of mass. None: 0, or what the density says.
    density : [kg/m³], ≥ 0, in place of a mass: mass = density · volume.
    volume : [m³] that the shape encloses.

    Raises InputError, for a mass and a density both among others.
    """

    __slots__ = ("_args", "_centre", "_placement", "_transform", "geometry", "mass", "triangles", "volume")

    geometry: Any
    mass: float
    volume: float
    triangles: Array | None

    def __init__(
        self,
        geometry: Any,
        placement: Any,
        mass: Any,
        density: Any,
        volume: float,
        centre: Any,
        args: tuple[Any, ...],
        triangles: Array | None = None,
    ) -> None:
        self.geometry, self.triangles = geometry, triangles
        self._placement = read_placement(placement)
        self._transform = coal.Transform3s(self._placement.rotation, self._placement.translation)
        self.volume = volume
        self.mass = _mass(mass, density, volume)
        self._centre = read_only(np.array(centre, dtype=float))
        self._args = args

    @property
    def placement(self) -> Any:
        """pin.SE3 of the shape's frame in the world (a copy)."""
        return self._placement.copy()

    @property
    def transform(self) -> Any:
        """The same for coal."""
        return self._transform

    @property
    def center_of_mass(self) -> Array:
        """(3,) [m], world axes."""
        return read_only(np.asarray(self._placement.act(self._centre)))

    def moved_to(self, placement: Any) -> Object:
        """The same object at another placement (pin.SE3 or position)."""
        make: Any = type(self)
        return cast(Object, make(*self._args, placement, self.mass))

    def closest(self, point: Array) -> tuple[float, Array, Array] | None:
        """Signed distance of a world point, the nearest surface point and the outward normal there, where this class
        knows better than coal; None: ask coal.
        """
        return None

    def __setattr__(self, name: str, value: object) -> None:
        """Everything is set once."""
        if hasattr(self, name):
            raise AttributeError(f"a {type(self).__name__} is immutable: {name} cannot be set (moved_to makes another)")
        object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as the call that made it."""
        return (type(self), (*self._args, self._placement, self.mass))

    def __repr__(self) -> str:
        """The call, roughly."""
        args = ", ".join(repr(a.tolist() if isinstance(a, np.ndarray) else a) for a in self._args)
        return f"{type(self).__name__}({args}, placement={self._placement.translation.tolist()}, mass={self.mass:g})"


class Box(Object):
    """A box with edges `size` (3,) [m] along its axes, centred on its frame (a number: a cube)."""

    __slots__ = ("size",)

    def __init__(self, size: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.size = _lengths("size", size)
        volume = float(np.prod(self.size))
        super().__init__(coal.Box(*self.size), placement, mass, density, volume, (0, 0, 0), (self.size,))


class Sphere(Object):
    """A ball of `radius` [m]."""

    __slots__ = ("radius",)

    def __init__(self, radius: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.radius = number("radius", radius, above=0.0)
        volume = 4 / 3 * np.pi * self.radius**3
        super().__init__(coal.Sphere(self.radius), placement, mass, density, volume, (0, 0, 0), (self.radius,))


class Cylinder(Object):
    """A cylinder of `radius` and `length` [m] along its z axis, centred on its frame.

    coal 3.0.3 takes the wrong way out for a ball whose centre is inside, near an end (-24 mm for -11 mm): for
    spherical fingertips the nearest point is computed here.
    """

    __slots__ = ("length", "radius")

    def __init__(
        self, radius: Any, length: Any, placement: Any = None, mass: Any = None, *, density: Any = None
    ) -> None:
        self.radius, self.length = number("radius", radius, above=0.0), number("length", length, above=0.0)
        geometry = coal.Cylinder(self.radius, self.length)
        volume = np.pi * self.radius**2 * self.length
        super().__init__(geometry, placement, mass, density, volume, (0, 0, 0), (self.radius, self.length))

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Outside: the point clamped to mantle and ends. Inside: straight out through the nearer of the two."""
        R, p = self._placement.rotation, self._placement.translation
        x, y, z = R.T @ (point - p)
        away = float(np.hypot(x, y))
        cx, cy = (x / away, y / away) if away > 0 else (1.0, 0.0)
        end = 0.5 * self.length if z >= 0 else -0.5 * self.length
        beside, above = away - self.radius, abs(z) - 0.5 * self.length
        if beside > 0 and above > 0:  # off the rim
            distance = float(np.hypot(beside, above))
            out = np.array([cx * beside, cy * beside, z - end]) / distance
            on = np.array([cx * self.radius, cy * self.radius, end])
        elif beside > above:
            distance, out, on = beside, np.array([cx, cy, 0.0]), np.array([cx * self.radius, cy * self.radius, z])
        else:
            distance, out, on = float(above), np.array([0.0, 0.0, np.sign(end)]), np.array([x, y, end])
        return distance, R @ on + p, R @ out


class Ellipsoid(Object):
    """An ellipsoid with semi-axes `radii` (3,) [m] along its axes.

    coal's distance to an ellipsoid is iterative (contact points good to about 1e-6 m, normals to 1e-4); for spherical
    fingertips the nearest point is computed here to rounding instead.
    """

    __slots__ = ("radii",)

    def __init__(self, radii: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.radii = _lengths("radii", radii)
        volume = 4 / 3 * np.pi * float(np.prod(self.radii))
        super().__init__(coal.Ellipsoid(*self.radii), placement, mass, density, volume, (0, 0, 0), (self.radii,))

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Nearest point x = a² c / (t + a²) with |x / a| = 1: the root t by Newton on a convex function, from its
        left side.
        """
        R, p = self._placement.rotation, self._placement.translation
        squares = self.radii * self.radii
        c = R.T @ (point - p)
        weights = squares * c * c
        if not weights.any():  # the very centre: the shortest semi-axis leads out
            k = int(np.argmin(squares))
            x = np.eye(3)[k] * self.radii[k]
        else:
            t = float(np.max(np.sqrt(weights) - squares))
            for _ in range(100):
                d = t + squares
                excess = float((weights / (d * d)).sum()) - 1.0
                step = excess / (2.0 * float((weights / (d * d * d)).sum()))
                t += step
                if not step > 1e-16 * abs(t):
                    break
            x = squares * c / (t + squares)
        n = x / squares
        n /= float(np.sqrt(n @ n))
        return float(n @ (c - x)), R @ x + p, R @ n


class Mesh(Object):
    """A triangle mesh from a file (STL, OBJ, DAE, PLY …), in metres after `scale` (a number or (3,)).

    A convex mesh is held as its hull, exact for every fingertip. One that is not convex is held as its triangles:
    contact with spherical fingertips only, and the surface has to be closed. Volume and centre of mass are those of
    what the surface encloses; of the hull, where a convex mesh has holes. NaN is the volume of an open one that is not
    convex: it takes no density.
    """

    __slots__ = ("convex", "path", "scale")

    def __init__(
        self, path: Any, scale: Any = 1.0, placement: Any = None, mass: Any = None, *, density: Any = None
    ) -> None:
        scales = array("scale", scale, (), (3,))
        if not (scales > 0).all():
            raise InputError("scale", "numbers above 0", repr(scale))
        mesh = load_mesh("path", path, np.ones(3) * scales)
        self.path, self.scale, self.convex = Path(path), scales, mesh.convex
        triangles = None if mesh.convex else mesh.triangles
        args = (self.path, self.scale)
        super().__init__(mesh.geometry, placement, mass, density, mesh.volume, mesh.centre, args, triangles)


def read_placement(value: Any) -> Any:
    """pin.SE3 from an SE3, a position (3,) or None. Raises InputError."""
    if value is None:
        return pin.SE3.Identity()
    if isinstance(value, pin.SE3):
        if not (
            np.isfinite(value.homogeneous).all()
            and abs(value.rotation.T @ value.rotation - np.eye(3)).max() < 1e-6
            and np.linalg.det(value.rotation) > 0
        ):
            raise InputError("placement", "an SE3 with a rotation and finite numbers", repr(value.homogeneous.tolist()))
        return value.copy()
    return pin.SE3(np.eye(3), array("placement", value, (3,), what="a pin.SE3 or a position: finite numbers"))


def _mass(mass: Any, density: Any, volume: float) -> float:
    if density is None:
        return 0.0 if mass is None else number("mass", mass, minimum=0.0)
    if mass is not None:
        raise InputError("density", "None where a mass is given", repr(density))
    value = number("density", density, minimum=0.0)
    if not volume > 0:
        raise InputError("density", "None for a mesh that is not closed (pass its mass)", repr(density))
    return value * volume


def _lengths(argument: str, value: Any) -> Array:
    a = array(argument, value, (3,), ())
    if not (a > 0).all():
        raise InputError(argument, "lengths above 0", repr(a.tolist()))
    return read_only(np.ones(3) * a)
