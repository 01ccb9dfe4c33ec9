"""`Table`: a plane that the object rests on or leans against. Its contacts are found by geometry."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from handlcp.check import (
    Array,
    check_array,
    check_init_call,
    check_method_calls,
    check_number,
    check_sequence,
    check_unit_vector,
    count_dimensions,
    read_only,
)
from handlcp.contact.friction import Coulomb, FrictionLaw, Frictionless, as_law
from handlcp.errors import InputError, NotReached
from handlcp.geometry.object import Object
from handlcp.geometry.shape import Box, Cylinder, Ellipsoid, Mesh, Sphere
from handlcp.grasp.model.contact import Contact, contact_frame
from handlcp.grasp.model.request import Environment, join_environments

# ----------------------------------------------------------------
# Where an object meets a plane: the points that can touch it, and no more of them than are needed.
#
# A rigid object stays above a plane as long as its extreme points do: corners of a box, points on the rims of a
# cylinder, one point of a ball or an ellipsoid, vertices of a mesh. A point above the convex hull of points that are no
# higher cannot touch before they do, and is left out. Of a flat patch the corners of its convex hull remain.

RIM_POINTS = 8  # points on each rim of a cylinder
_HEIGHT_TOLERANCE = 1e-9  # times the object's size: smaller differences of height and distances from a line are zero


def _extreme_points(obj: Object, normal: Array) -> Array:
    """(k, 3) extreme points towards the plane, world axes."""
    R, p = obj.placement.rotation, obj.placement.translation
    down = -(R.T @ normal)
    match obj:
        case Box():
            signs = np.array([[x, y, z] for z in (-0.5, 0.5) for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
            local = signs * obj.size
        case Sphere():
            local = obj.radius * down[None]
        case Ellipsoid():
            stretched = obj.radii * down
            local = (obj.radii * stretched / np.sqrt(stretched @ stretched))[None]
        case Cylinder():
            local = _rim_points(obj, down)
        case Mesh():
            corners = obj.geometry.points() if obj.triangles is None else obj.triangles
            local = np.unique(np.array(corners, dtype=float).reshape(-1, 3), axis=0)
        case _:
            expected = "a Box, Sphere, Cylinder, Ellipsoid or Mesh to find contacts of"
            raise InputError("object", expected, repr(obj)[:80])
    return np.asarray(local @ R.T + p)


def _rim_points(obj: Cylinder, down: Array) -> Array:
    """(2 RIM, 3) points on both rims, the first of each the one furthest along `down`; cylinder axes."""
    leaning = float(np.hypot(down[0], down[1]))
    start = np.arctan2(down[1], down[0]) if leaning > _HEIGHT_TOLERANCE else 0.0
    a = start + 2 * np.pi * np.arange(RIM_POINTS) / RIM_POINTS
    ring = np.column_stack([obj.radius * np.cos(a), obj.radius * np.sin(a), np.full(RIM_POINTS, 0.5 * obj.length)])
    return np.concatenate([ring * (1, 1, -1), ring])


def _support_corners(points: Array, heights: Array, normal: Array) -> list[int]:
    """Numbers of the points that are corners of the hull of all at their height or below, the lowest first."""
    flat = (points - points[0]) @ contact_frame(normal)[:, :2]
    size = float(np.ptp(points, axis=0).max())
    order = np.argsort(heights, kind="stable")
    levels = np.split(order, np.flatnonzero(np.diff(heights[order]) > _HEIGHT_TOLERANCE * size) + 1)
    hull: list[int] = []
    kept: list[int] = []
    for level in levels:
        hull = hull_corners(flat, [*hull, *level.tolist()], _HEIGHT_TOLERANCE * size)
        kept += [i for i in hull if i not in kept]
    return kept


def hull_corners(flat: Array, members: Iterable[int], least: float) -> list[int]:
    """Corners of the convex hull of the points of flat (k, 2) numbered `members`, by Andrew's monotone chain. A point
    within `least` of a line between two others, or of another point, is no corner.
    """
    ordered = sorted(members, key=lambda i: (flat[i, 0], flat[i, 1]))

    def half(run: list[int]) -> list[int]:
        out: list[int] = []
        for i in run:
            while len(out) > 1 and _turn_distance(flat[out[-2]], flat[out[-1]], flat[i]) <= least:
                out.pop()
            if not out or np.hypot(*(flat[i] - flat[out[-1]])) > least:
                out.append(i)
        return out

    lower, upper = half(ordered), half(ordered[::-1])
    corners = [*lower[:-1], *upper[:-1]] or lower
    return list(dict.fromkeys(corners))


def _turn_distance(a: Array, b: Array, c: Array) -> float:
    """Distance of b to the right of the line from a to c [m]; > 0 where the chain turns left at b."""
    along = c - a
    length = float(np.hypot(*along))
    cross = float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    return cross / length if length > 0.0 else 0.0


# ----------------------------------------------------------------


@check_init_call()
@check_method_calls
class Table:
    """A half-space that the object touches, such as a table under it or a wall beside it. Immutable.

    point : (3,) on its surface [m], world axes. normal : (3,) unit vector out of it, to the object's side.
    friction : a coefficient, `Coulomb(mu)` or `Frictionless()`, of all its contacts; None: 0.5.
    flexibility : [m/N] of each contact, a number or a (3,) diagonal (two tangents, the normal); 0: rigid. On a rigid
        table the forces at four corners are seldom determined, on a flexible one they are.
    max_gap : [m] points of the object that are farther from the plane are no contacts.
    name : prefix of its contacts in reports: "table 1", "table 2", …

    `state.grasp(obj, environment=table)` finds the contacts itself; `table.under(obj)` is for grasps without a hand.
    A planar scene refuses contacts off its plane: pass an `Environment` with those that you mean.
    Raises InputError.
    """

    __slots__ = ("flexibility", "friction", "max_gap", "name", "normal", "point")

    point: Array
    normal: Array
    friction: FrictionLaw
    flexibility: Array
    max_gap: float
    name: str

    def __init__(
        self,
        point: Any,
        normal: Any = (0.0, 0.0, 1.0),
        friction: FrictionLaw | float | None = None,
        flexibility: Any = 0.0,
        max_gap: Any = 1e-3,
        name: str = "table",
    ) -> None:
        law = Coulomb(0.5) if friction is None else as_law(friction)
        if not isinstance(law, (Coulomb, Frictionless)):
            raise InputError("friction", "a coefficient, Coulomb(mu) or Frictionless()", repr(friction))
        if not isinstance(name, str):
            raise InputError("name", "a string", repr(name))
        if count_dimensions(flexibility) == 0:
            soft = read_only(np.full(3, check_number("flexibility", flexibility, minimum=0.0)))
        elif ((soft := check_array("flexibility", flexibility, (3,))) < 0).any():
            raise InputError("flexibility", "entries ≥ 0", soft.tolist())
        object.__setattr__(self, "point", check_array("point", point, (3,)))
        object.__setattr__(self, "normal", check_unit_vector("normal", normal, (3,)))
        object.__setattr__(self, "friction", law)
        object.__setattr__(self, "flexibility", soft)
        object.__setattr__(self, "max_gap", check_number("max_gap", max_gap, minimum=0.0))
        object.__setattr__(self, "name", name)

    def under(self, obj: Object) -> Environment:
        """Its contacts with an object, within `max_gap`: corners of a box, points on a cylinder's rims (eight on the
        rim that it stands on), one point of a ball or an ellipsoid, vertices of a mesh's hull. Of a flat patch the
        corners of its convex hull count. Gaps are measured; an overlap is a negative gap.

        Raises NotReached with the object's distance where nothing is near; InputError for an object behind the plane.
        """
        if not isinstance(obj, Object):
            raise InputError("obj", "an object (Box, Sphere, …)", repr(obj)[:80])
        if (behind := float((self.point - obj.center_of_mass) @ self.normal)) > 0.0:
            expected = f"an object whose centre is on the side of the {self.name} that its normal points to"
            came = f"one {behind * 1e3:.3g} mm behind it: is the normal turned round?"
            raise InputError("environment", expected, came)
        points = _extreme_points(obj, self.normal)
        heights = (points - self.point) @ self.normal
        near = heights <= self.max_gap
        if not near.any():
            expected = f"an object within max_gap = {self.max_gap * 1e3:g} mm of the {self.name}"
            raise NotReached("environment", expected, {self.name: float(heights.min())})
        points, gaps = points[near], heights[near]
        if len(points) > 1:
            kept = _support_corners(points, gaps, self.normal)
            points, gaps = points[kept], gaps[kept]
        contacts = [Contact(p, self.normal, self.friction, None, f"{self.name} {k + 1}") for k, p in enumerate(points)]
        return Environment(contacts, self.flexibility, gaps)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Table is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        return (Table, (self.point, self.normal, self.friction, self.flexibility, self.max_gap, self.name))

    def __repr__(self) -> str:
        return f"Table({self.point.tolist()}, normal={self.normal.tolist()}, friction={self.friction!r})"


def read_environment(value: Any, obj: Object | None) -> Environment:
    """The environment meant by an `Environment`, a `Table`, or a sequence of them. Raises InputError, NotReached."""
    alone, expected = isinstance(value, (Environment, Table)), "a Table, an Environment, or a sequence of them"
    parts = []
    for k, part in enumerate([value] if alone else check_sequence("environment", value, expected)):
        if isinstance(part, Table):
            if obj is None:
                expected = "an Environment where contacts are given: a Table finds its contacts with an object"
                raise InputError("environment", expected, repr(part)[:80])
            part = part.under(obj)
        elif not isinstance(part, Environment):
            raise InputError(f"environment[{k}]", "a Table or an Environment", repr(part)[:80])
        parts.append(part)
    return join_environments(parts)
