"""Directions of an envelope, and what gives out first in each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from handlcp.check import Array, Ints, array, dimensions, integer, read_only
from handlcp.errors import InputError
from handlcp.grasp.failure.failure_mode import FailureMode
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.model.contact import contact_frame
from handlcp.grasp.model.request import GraspSpec
from handlcp.study.envelope.grid import Grid, circle, sphere

# ----------------------------------------------------------------
# Which directions are asked for: all around, around a plane, or these.

_PLANES = {"xy": (0, 1), "yz": (1, 2), "xz": (0, 2)}
_MOST, _AROUND = 200_000, 72  # directions; those around a plane where no number is said: one every 5°
_WHAT = """a number of directions all around, a plane such as "xy" or its normal (3,), a plane and a number such as \
("xy", 72), (m, 3) directions, or (m, 6) wrenches"""


@dataclass(frozen=True, slots=True)
class Asked:
    """The directions of an envelope, as they were asked for.

    grid : the directions, and how they are joined; points of zero where wrenches were given.
    wrenches (m, 6) : that were given in place of directions [N, N·m], about the grasp's reference; None without.
    plane (2, 3) : axes of the plane in which directions lie; None: there is none.
    divides : whether more directions between these would answer the question better.
    """

    grid: Grid
    wrenches: Array | None = None
    plane: Array | None = None
    divides: bool = True


def read_directions(asked: Any) -> Asked:
    """Check the directions, the plane or the wrenches of an envelope, in any form that `envelope` takes.

    Raises InputError.
    """
    if isinstance(asked, (int, np.integer)) and not isinstance(asked, (bool, np.bool_)):
        return Asked(sphere(integer("directions", asked, 1, _MOST)))
    if isinstance(asked, str):
        return _around(asked, _AROUND)
    pair = isinstance(asked, (tuple, list)) and len(asked) == 2 and dimensions(asked[1]) == 0
    if pair and (isinstance(asked[0], str) or dimensions(asked[0]) == 1):
        return _around(asked[0], integer("directions", asked[1], 3, _MOST))
    if dimensions(asked) == 1:
        return _around(asked, _AROUND)
    given = array("directions", asked, (-1, 3), (-1, 6), what=_WHAT)
    if not len(given) or (given == 0.0).all(axis=1).any():
        raise InputError("directions", f"{_WHAT}; none of them zero", f"{len(given)} rows")
    if given.shape[1] == 6:
        still = read_only(np.zeros((len(given), 3)))
        return Asked(Grid(still, np.zeros((0, 3), dtype=np.int64)), wrenches=given, divides=False)
    points = given / np.linalg.norm(given, axis=1)[:, None]
    return Asked(Grid(read_only(points), _joined(points)), divides=False)


def _around(plane: Any, count: int) -> Asked:
    """Directions all around in a plane, evenly spread. plane : "xy", "yz", "xz" or a normal (3,). Raises InputError."""
    if isinstance(plane, str):
        if plane not in _PLANES:
            raise InputError("directions", _WHAT, repr(plane))
        axes = np.eye(3)[list(_PLANES[plane])]
    else:
        normal = array("directions", plane, (3,), what=_WHAT)
        if not normal.any():
            raise InputError("directions", "a plane's normal that is not zero", normal.tolist())
        axes = contact_frame(normal / np.linalg.norm(normal)).T[:2]
    return Asked(circle(axes, count), plane=read_only(axes))


def _joined(points: Array) -> Any:
    """(k, 3) triangles where the points lie all around the origin; none where they do not."""
    none = np.zeros((0, 3), dtype=np.int64)
    if len(points) < 4:
        return none
    try:
        hull = ConvexHull(points)
    except QhullError:
        return none
    if len(hull.vertices) < len(points) or (hull.equations[:, 3] > -1e-6).any():
        return none
    cells = hull.simplices.astype(np.int64)
    inward = np.einsum("ki,ki->k", points[cells[:, 0]], np.cross(points[cells[:, 1]], points[cells[:, 2]])) < 0.0
    cells[inward] = cells[inward][:, ::-1]
    return cells


# ----------------------------------------------------------------
# What passive compliance gives away: the limits of loading beside those of friction and torques alone.


@dataclass(frozen=True, slots=True)
class Compliance:
    """Factors as shares of the bound, over the directions in which both are finite, and the bound positive.

    median, least : shares; NaN where there is no such direction. number : of the direction with the least share.
    """

    median: float
    least: float
    number: int

    @classmethod
    def of(cls, factors: Array, bound: Array, shares: Array) -> Self:
        """Compare factors (m,) with those of the bound (m,). shares (m,) : of all directions, what each stands for."""
        known = np.flatnonzero(np.isfinite(bound) & (bound > 0.0) & np.isfinite(factors))
        if not len(known):
            return cls(np.nan, np.nan, 0)
        kept = factors[known] / bound[known]
        least = int(kept.argmin())
        return cls(median(kept, shares[known]), float(kept[least]), int(known[least]))


# ----------------------------------------------------------------
# What gives out first in each direction, in words and as shares of all directions.

Binds = tuple[FailureMode, ...]


@dataclass(frozen=True, slots=True)
class Sector:
    """Directions in which the same gives out first.

    binds : as in `Envelope.binds`; () where nothing gives out. says : in words. share : of all directions.
    least, median : of the factors there, by solid angle; infinite where nothing gives out, NaN where undecided.
    """

    binds: Binds
    says: str
    share: float
    least: float
    median: float


def causes_of(
    binds: Sequence[Binds], factors: Array, shares: Array, spec: GraspSpec
) -> tuple[tuple[Sector, ...], Ints]:
    """The causes, the most frequent first; and (m,) the number of each direction's cause. shares (m,) : what part of
    all directions each stands for. spec : of the grasp.
    """
    keys = [frozenset(some) for some in binds]
    first = dict[frozenset[FailureMode], int]()
    for k, key in enumerate(keys):
        first.setdefault(key, k)
    number = {key: k for k, key in enumerate(first)}
    own = np.array([number[key] for key in keys], dtype=np.int64)
    part = np.bincount(own, shares, len(first))
    order = np.argsort(-part, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    found = []
    for k in order.tolist():
        here = own == k
        some = binds[int(np.flatnonzero(here)[0])]
        middle = median(factors[here], shares[here])
        found.append(Sector(some, describe_failures(some, spec), float(part[k]), float(factors[here].min()), middle))
    return tuple(found), rank[own]


def median(values: Array, shares: Array) -> float:
    """The weighted median of values (m,). shares (m,) : the weights."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(shares[order])
    return float(values[order][np.searchsorted(below, 0.5 * below[-1])])
