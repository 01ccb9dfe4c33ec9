"""`Object`: an object to grasp, as a solid, where it is, and what it weighs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self

import coal
import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array, check_array, check_call, check_number, read_only
from handlcp.errors import InputError
from handlcp.grasp.analysis.explanation import EffectDescription
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.request import GraspSpec
from handlcp.lcp.kernels.dense import kernel

# ----------------------------------------------------------------
# The nearest point on the surface of a ball, a box, a cylinder or an ellipsoid, compiled; each in its own axes.

BALL, BOX, CYLINDER, ELLIPSOID = 0, 1, 2, 3


@kernel
def write_ball_proximities(
    kind: int,
    sizes: Array,
    R: Array,
    p: Array,
    centres: Array,
    radii: Array,
    positions: Array,
    normals: Array,
    gaps: Array,
) -> None:
    """Write where balls with these centres (n, 3) and radii (n,) are nearest to a shape of this kind and sizes (3,),
    whose axes are the columns of R and whose frame is at p: positions (n, 3) on the shape, normals (n, 3) from the ball
    into the shape, gaps (n,).
    """
    c = np.empty(3)
    for i in range(len(centres)):
        for a in range(3):
            c[a] = 0.0
            for b in range(3):
                c[a] += R[b, a] * (centres[i, b] - p[b])
        distance, x, out = closest_on_surface(kind, sizes, c)
        gaps[i] = distance - radii[i]
        write_contact(R, p, x, out, positions[i], normals[i])


@kernel
def write_contact(R: Array, p: Array, x: Array, out: Array, position: Array, normal: Array) -> None:
    """Write position p + R x and normal -R out, each (3,), of a point x on a shape and its outward normal there, whose
    axes are the columns of R and whose frame is at p.
    """
    for b in range(3):
        position[b], normal[b] = p[b], 0.0
        for a in range(3):
            position[b] += R[b, a] * x[a]
            normal[b] -= R[b, a] * out[a]


@kernel
def closest_on_surface(kind: int, sizes: Array, c: Array) -> tuple[float, Array, Array]:
    """Signed distance of a point c (3,), nearest point on the surface, outward normal there. sizes (3,) : radius of a
    ball; half the edges of a box; radius and half the length of a cylinder; semi-axes of an ellipsoid.
    """
    if kind == BALL:
        return _on_ball(sizes[0], c)
    if kind == BOX:
        return _on_box(sizes, c)
    if kind == CYLINDER:
        return _on_cylinder(sizes[0], sizes[1], c)
    return _on_ellipsoid(sizes, c)


@kernel
def _on_ball(radius: float, c: Array) -> tuple[float, Array, Array]:
    """Along the line from the centre; at the centre any way out is as long, and the one along x is taken."""
    away = np.sqrt(c[0] ** 2 + c[1] ** 2 + c[2] ** 2)
    out = np.zeros(3)
    if away > 0.0:
        out[:] = c / away
    else:
        out[0] = 1.0
    return away - radius, radius * out, out


@kernel
def _on_box(half: Array, c: Array) -> tuple[float, Array, Array]:
    """As `closest_on_surface`: clamped to the box, from inside straight out through the nearest face."""
    x, out = np.empty(3), np.zeros(3)
    beyond, face, nearest = 0.0, 0, -np.inf
    for a in range(3):
        x[a] = min(max(c[a], -half[a]), half[a])
        out[a] = c[a] - x[a]
        beyond += out[a] ** 2
        if abs(c[a]) - half[a] > nearest:
            face, nearest = a, abs(c[a]) - half[a]
    if beyond > 0.0:
        distance = np.sqrt(beyond)
        return distance, x, out / distance
    out[face] = 1.0 if c[face] >= 0.0 else -1.0
    x[face] = out[face] * half[face]
    return nearest, x, out


@kernel
def _on_cylinder(radius: float, half: float, c: Array) -> tuple[float, Array, Array]:
    """As `closest_on_surface`: clamped to the side and the ends, from inside straight out through the nearer one."""
    away = np.sqrt(c[0] ** 2 + c[1] ** 2)
    a, b = (c[0] / away, c[1] / away) if away > 0.0 else (1.0, 0.0)
    side = 1.0 if c[2] >= 0.0 else -1.0
    beside, above = away - radius, abs(c[2]) - half
    if beside > 0.0 and above > 0.0:  # nearest to the rim
        distance = np.sqrt(beside**2 + above**2)
        out = np.array([a * beside, b * beside, side * above]) / distance
        return distance, np.array([a * radius, b * radius, side * half]), out
    if beside > above:
        return beside, np.array([a * radius, b * radius, c[2]]), np.array([a, b, 0.0])
    return above, np.array([c[0], c[1], side * half]), np.array([0.0, 0.0, side])


@kernel
def _on_ellipsoid(radii: Array, c: Array) -> tuple[float, Array, Array]:
    """X = a² c / (t + a²) with |x / a| = 1, radii a. Newton's method finds t from the left (convex)."""
    squares = radii * radii
    weights = squares * c * c
    if weights.max() <= 0.0:  # at the centre the shortest semi-axis is the way out
        x = np.zeros(3)
        x[np.argmin(squares)] = radii.min()
    else:
        t = np.max(np.sqrt(weights) - squares)
        for _ in range(100):
            d = t + squares
            step = ((weights / (d * d)).sum() - 1.0) / (2.0 * (weights / (d * d * d)).sum())
            t += step
            if not step > 1e-16 * abs(t):
                break
        x = squares * c / (t + squares)
    n = x / squares
    n /= np.sqrt((n * n).sum())
    return (n * (c - x)).sum(), x, n


# ----------------------------------------------------------------

# What a rotation rounded to a few digits may miss, and what float64 makes it miss
_ROTATION_TOLERANCE, _EXACT_ROTATION_TOLERANCE = 1e-4, 1e-14
_LAST_ROW = np.array([0.0, 0.0, 0.0, 1.0])

OBJECT_WEIGHT = EffectDescription(
    title="object weight",
    equation="w += (m g, (p_m - c) × m g)",
    when="The object's mass, or its density, and where its centre of mass is.",
    in_python="mass=0.3",
    in_file="object.mass_kg = 0.3",
    brings="none: part of the load",
    source="statics: the resultant of gravity acts at the centre of mass",
    module=__name__,
)


@dataclass(frozen=True, slots=True, eq=False)
class ObjectSolid:
    """A shape in its own frame.

    geometry : coal's shape. volume : [m³], NaN where it is unknown. centre : (3,) centre of mass [m].
    triangles : (m, 3, 3) [m] the surface of a shape that is not convex; None for a convex one.
    """

    geometry: Any
    volume: float
    centre: Array = field(default_factory=lambda: read_only(np.zeros(3)))
    triangles: Array | None = None


class Object:
    """Base of the shapes. Immutable, picklable.

    placement : of the shape's frame in the hand's world frame: pin.SE3, a (4, 4) homogeneous matrix, or a position (3,)
        [m]; None: the origin. (Of a quaternion: pin.XYZQUATToSE3.)
    mass : [kg], ≥ 0; its weight acts at the centre of mass. None: 0, or density · volume.
    density : [kg/m³], ≥ 0, in place of a mass.

    Attributes: mass, volume [m³], geometry (coal's shape), transform (the placement for coal), frame (its rotation
    (3, 3) and position (3,) [m]), triangles (m, 3, 3) [m] of a shape that is not convex (otherwise None).
    Raises InputError; also where both a mass and a density are given.
    """

    __slots__ = (
        "_args",
        "_centre",
        "_placement",
        "frame",
        "geometry",
        "known",
        "mass",
        "transform",
        "triangles",
        "volume",
    )

    _placement: Any
    frame: tuple[Array, Array]
    transform: Any
    mass: float

    def __init__(
        self,
        solid: ObjectSolid,
        placement: Any,
        mass: Any,
        density: Any,
        args: tuple[Any, ...],
        known: tuple[int, Array] | None = None,
    ) -> None:
        """From a solid; `args` are the subclass's own arguments, for copies, pickles and `repr`. known : the kind and
        sizes by which `surface.closest_on_surface` knows the shape; None: it does not.
        """
        self.known = known
        self.geometry, self.volume, self.triangles = solid.geometry, solid.volume, solid.triangles
        self._set_placement(read_placement(placement), _read_mass(mass, density, solid.volume))
        self._centre, self._args = solid.centre, args

    @property
    def placement(self) -> Any:
        """pin.SE3 of the shape's frame in the world (a copy)."""
        return self._placement.copy()

    @property
    def center_of_mass(self) -> Array:
        """The centre of mass (3,) in world axes [m]."""
        return read_only(np.asarray(self._placement.act(self._centre)))

    @check_call()
    def moved_to(self, placement: Any) -> Self:
        """The same object at another placement, given as on making it."""
        return self._copy_with(read_placement(placement), self.mass)

    def _copy_with(self, placement: Any, mass: float) -> Self:
        """A copy elsewhere, or with another mass; what it is made of is shared."""
        made = object.__new__(type(self))
        for name in {name for kind in type(self).__mro__ for name in getattr(kind, "__slots__", ())}:
            object.__setattr__(made, name, getattr(self, name))
        made._set_placement(placement, mass)
        return made

    def _set_placement(self, placement: Any, mass: float) -> None:
        frame = read_only(placement.rotation.copy()), read_only(placement.translation.copy())
        values = {"_placement": placement, "frame": frame, "transform": coal.Transform3s(*frame), "mass": mass}
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @check_call()
    def weighing(self, mass: Any) -> Self:
        """The same object with another mass [kg]."""
        return self._copy_with(self._placement, check_number("mass", mass, minimum=0.0))

    @property
    def parts(self) -> tuple[Any, ...]:
        """Convex shapes that fill it, in its axes."""
        return (self.geometry,)

    def closest(self, point: Array) -> tuple[float, Array, Array] | None:
        """Signed distance [m] of a point (3,), nearest surface point and outward normal, world axes; None: unknown."""
        if self.known is None:
            return None
        (kind, sizes), (R, p) = self.known, self.frame
        distance, on, out = closest_on_surface(kind, sizes, (point - p) @ R)
        return distance, R @ on + p, R @ out

    def closest_all(self, points: Array) -> tuple[Array, Array, Array] | None:
        """As `closest` of points (m, 3): (m,), (m, 3) and (m, 3)."""
        if self.known is None:
            return None
        away, on, inward = np.empty(len(points)), np.empty_like(points), np.empty_like(points)
        write_ball_proximities(*self.known, *self.frame, points, np.zeros(len(points)), on, inward, away)
        return away, on, -inward

    def __setattr__(self, name: str, value: object) -> None:
        if hasattr(self, name):
            raise AttributeError(f"a {type(self).__name__} is immutable: {name} cannot be set (moved_to makes another)")
        object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (*self._args, self._placement, self.mass))

    def __repr__(self) -> str:
        args = ", ".join(repr(a.tolist() if isinstance(a, np.ndarray) else a) for a in self._args)
        return f"{type(self).__name__}({args}, placement={self._placement.translation.tolist()}, mass={self.mass:g})"


def read_placement(value: Any) -> Any:
    """pin.SE3 from an SE3, a (4, 4) homogeneous matrix, a position (3,) or None: the origin. Raises InputError.

    A rotation that is one to 1e-4, such as one printed with five digits, becomes the nearest exact one.
    """
    if value is None:
        return pin.SE3.Identity()
    expected = "a pin.SE3, a homogeneous matrix or a position: finite numbers"
    is_pose = isinstance(value, pin.SE3)
    a = value.homogeneous.copy() if is_pose else check_array("placement", value, (3,), (4, 4), what=expected)
    if a.shape == (3,):
        return pin.SE3(np.eye(3), a)
    if not np.isfinite(a).all():
        raise InputError("placement", expected, repr(a.tolist()))
    if abs(a[3] - _LAST_ROW).max() > 1e-6:
        raise InputError("placement", "a homogeneous matrix whose last row is 0, 0, 0, 1", a[3].tolist())
    R = a[:3, :3]
    miss = float(abs(R.T @ R - np.eye(3)).max())
    if miss > _ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
        off = f"one that is {miss:.3g} off (a scale, or a matrix of another kind?)"
        came = "a mirror" if miss <= _ROTATION_TOLERANCE else off
        raise InputError("placement", "a rotation, orthonormal to 1e-4, and a position", came)
    if miss > _EXACT_ROTATION_TOLERANCE:
        U, _, V = np.linalg.svd(R)
        R = U @ V
    return pin.SE3(R.copy(), a[:3, 3].copy())


def _read_mass(mass: Any, density: Any, volume: float) -> float:
    if density is None:
        return 0.0 if mass is None else check_number("mass", mass, minimum=0.0)
    if mass is not None:
        raise InputError("density", "None where a mass is given", repr(density))
    value = check_number("density", density, minimum=0.0)
    if not volume > 0:
        raise InputError("density", "None for a mesh that is not closed (pass its mass)", repr(density))
    return value * volume


# ----------------------------------------------------------------
# The wrench on an object: what is given, and its weight at its centre of mass.


def choose_reference(reference: Any, obj: Object | None, positions: Array, normal: Array | None) -> Array:
    """(3,) the point [m] that wrench and motion refer to; the object's centre of mass where none is given."""
    if reference is None:
        return read_only(np.zeros(3)) if obj is None else obj.center_of_mass
    return validate.reference(reference, normal, positions)


def total_load(
    wrench: Any, point: Array, obj: Object | None, gravity: Array, positions: Array, normal: Array | None
) -> Array:
    """(6,) the whole load about a point (3,): the given wrench and the weight. Raises InputError."""
    load = validate.wrench(wrench, normal, validate.height_above(positions, point, normal))
    if obj is None or obj.mass == 0.0:
        return load
    weight = obj.mass * gravity
    if normal is not None and abs(float(weight @ normal)) > 1e-9 * float(abs(weight).max()):
        raise InputError("gravity", "gravity in the plane of a planar scene", gravity.tolist())
    if weight.any() and (off := validate.height_above(positions, obj.center_of_mass, normal)):
        expected = "an object whose centre of mass lies in the plane of a planar scene"
        raise InputError("target", expected, f"one {abs(off):.3g} m off it")
    return read_only(load + object_weight_wrench(obj, gravity, point))


def describe_missing_weight(spec: GraspSpec, weight: Array) -> str:
    """In words, where the load was given as one wrench in place of the object's weight (6,), and pulls less than that
    along gravity; "" where it was not.
    """
    size = float(np.linalg.norm(weight[:3]))
    if getattr(spec.asked, "load", None) is None or size == 0.0:
        return ""
    along = float(spec.wrench[:3] @ weight[:3]) / size
    if along >= (1.0 - 1e-9) * size:
        return ""
    return (
        f"the object's weight of {words.format_force(size)} is left out: replace(wrench=...) gave the whole load, "
        f"which pulls along gravity with {words.format_force(along)}; replace(load=...) comes beside the weight"
    )


def object_weight_wrench(obj: Object | None, gravity: Array, point: Array) -> Array:
    """(6,) of the object, about a point (3,)."""
    if obj is None or obj.mass == 0.0:
        return np.zeros(6)
    weight = obj.mass * gravity
    return np.append(weight, cross_rows(obj.center_of_mass - point, weight))
