"""`Object`: an object to grasp, as a solid, where it is, and what it weighs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self

import coal
import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array, check_array, check_call, check_number, read_only
from handlcp.contact.closest_point import closest_on_surface, write_ball_proximities
from handlcp.errors import InputError
from handlcp.grasp.analysis.explanation import EffectDescription
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.request import GraspSpec

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
