"""Which directions are asked for: all around, around a plane, or these."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from handlcp.check import Array, array, dimensions, integer, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.contact import frame
from handlcp.study.envelope.grid import Grid, circle, sphere

_PLANES = {"xy": (0, 1), "yz": (1, 2), "xz": (0, 2)}
_MOST, _AROUND = 200_000, 72  # directions; those around a plane where no number is said: one every 5°
_WHAT = """a number of directions all around, a plane such as "xy" or its normal (3,), a plane and a number such as \
("xy", 72), (m, 3) directions, or (m, 6) wrenches"""


@dataclass(frozen=True, slots=True)
class Asked:
    """grid : the directions, and how they are joined. wrenches (m, 6) : where wrenches were given; their forces or
    torques are no directions, and the grid's points are zero. plane (2, 3) : axes of the plane; None: there is none.
    divides : whether more directions between these would answer the question better.
    """

    grid: Grid
    wrenches: Array | None = None
    plane: Array | None = None
    divides: bool = True


def read_directions(asked: Any) -> Asked:
    """See `envelope`. Raises InputError."""
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
    """Around a plane, in its axes."""
    if isinstance(plane, str):
        if plane not in _PLANES:
            raise InputError("directions", _WHAT, repr(plane))
        axes = np.eye(3)[list(_PLANES[plane])]
    else:
        normal = array("directions", plane, (3,), what=_WHAT)
        if not normal.any():
            raise InputError("directions", "a plane's normal that is not zero", normal.tolist())
        axes = frame(normal / np.linalg.norm(normal)).T[:2]
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
