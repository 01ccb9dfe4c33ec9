"""The shapes of objects: box, ball, cylinder, ellipsoid, mesh."""

from __future__ import annotations

from math import copysign, sqrt
from pathlib import Path
from typing import Any

import coal
import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError
from handlcp.hand.objects.meshes import load_mesh
from handlcp.hand.objects.object import Object, Solid
from handlcp.hand.objects.triangles import Surface, closest_of

__all__ = ["Box", "Cylinder", "Ellipsoid", "Mesh", "Sphere"]


class Box(Object):
    """A box with edges `size` (3,) [m] along its axes, centred on its frame (a number: a cube)."""

    __slots__ = ("_half", "size")

    def __init__(self, size: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.size = _lengths("size", size)
        self._half = (0.5 * self.size).tolist()
        solid = Solid(coal.Box(*self.size), float(np.prod(self.size)))
        super().__init__(solid, placement, mass, density, (self.size,))

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Outside: clamped to the faces. Inside: straight out through the nearest face."""
        R, p = self.frame
        x, half = ((point - p) @ R).tolist(), self._half
        over = [abs(x[0]) - half[0], abs(x[1]) - half[1], abs(x[2]) - half[2]]
        distance, way = max(over), [0.0, 0.0, 0.0]
        if distance > 0.0:
            distance = sqrt(sum(o * o for o in over if o > 0.0))
            way = [copysign(o / distance, a) if o > 0.0 else 0.0 for o, a in zip(over, x, strict=True)]
        else:
            k = over.index(distance)
            way[k] = copysign(1.0, x[k])
        out = R @ way
        return distance, point - distance * out, out


class Sphere(Object):
    """A ball of `radius` [m]."""

    __slots__ = ("radius",)

    def __init__(self, radius: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.radius = number("radius", radius, above=0.0)
        solid = Solid(coal.Sphere(self.radius), 4 / 3 * np.pi * self.radius**3)
        super().__init__(solid, placement, mass, density, (self.radius,))

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Along the line from the centre; at the centre any way out is as long, and the one along x is taken."""
        _, p = self.frame
        away = point - p
        length = sqrt(float(away @ away))
        out = away / length if length > 0.0 else np.array([1.0, 0.0, 0.0])
        return length - self.radius, p + self.radius * out, out


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
        super().__init__(solid, placement, mass, density, (self.radius, self.length))

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Outside: clamped to the lateral surface and the ends. Inside: straight out through the nearer of the two."""
        R, p = self.frame
        x, y, z = R.T @ (point - p)
        away = float(np.hypot(x, y))
        cx, cy = (x / away, y / away) if away > 0 else (1.0, 0.0)
        end = 0.5 * self.length if z >= 0 else -0.5 * self.length
        beside, above = away - self.radius, abs(z) - 0.5 * self.length
        if beside > 0 and above > 0:  # nearest to the rim
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

    coal's distance to an ellipsoid is iterative: points are good to about 1e-6 m, normals to 1e-4. That to spherical
    fingertips is computed here, to rounding.
    """

    __slots__ = ("radii",)

    def __init__(self, radii: Any, placement: Any = None, mass: Any = None, *, density: Any = None) -> None:
        self.radii = _lengths("radii", radii)
        solid = Solid(coal.Ellipsoid(*self.radii), 4 / 3 * np.pi * float(np.prod(self.radii)))
        super().__init__(solid, placement, mass, density, (self.radii,))

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Of a point c: x = a² c / (t + a²), |x / a| = 1, radii a. Newton's method finds t from the left (convex)."""
        R, p = self.frame
        squares = self.radii * self.radii
        c = R.T @ (point - p)
        weights = squares * c * c
        if not weights.any():  # at the centre the shortest semi-axis is the way out
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

    A convex mesh becomes its convex hull, which is exact for every fingertip. A mesh that is not convex keeps its
    triangles: its surface has to be closed, and only spherical fingertips can touch it. Volume and centre of mass are
    those of the enclosed space, or of the hull where a convex mesh has holes. A mesh that is neither convex nor closed
    has the volume NaN and takes no density.
    """

    __slots__ = ("_surface", "convex", "path", "scale")

    def __init__(
        self, path: Any, scale: Any = 1.0, placement: Any = None, mass: Any = None, *, density: Any = None
    ) -> None:
        scales = array("scale", scale, (), (3,))
        if not (scales > 0).all():
            raise InputError("scale", "numbers above 0", repr(scale))
        solid = load_mesh(path, np.ones(3) * scales)
        self.path, self.scale, self.convex = Path(path), scales, solid.triangles is None
        self._surface = Surface(solid.geometry) if solid.triangles is None else solid.triangles
        super().__init__(solid, placement, mass, density, (self.path, self.scale))

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Of a convex mesh by its planes and visible faces, of any other by its triangles and the winding number."""
        R, p = self.frame
        x, surface = R.T @ (point - p), self._surface
        distance, on, out = surface.closest(x) if isinstance(surface, Surface) else closest_of(x, surface)
        return distance, R @ on + p, R @ out


def _lengths(argument: str, value: Any) -> Array:
    a = array(argument, value, (3,), ())
    if not (a > 0).all():
        raise InputError(argument, "lengths above 0", repr(a.tolist()))
    return read_only(np.ones(3) * a)
