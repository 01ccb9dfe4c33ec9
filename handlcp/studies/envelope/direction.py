"""`DirectionGrid`: directions on a sphere or circle, joined by cells that can be halved where it pays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from handlcp.check import Array, Ints, check_array, check_integer, count_dimensions, read_only
from handlcp.errors import InputError
from handlcp.geometry.mesh import solid_angles
from handlcp.grasp.failure.failure_mode import FailureMode
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.model.contact import contact_frame
from handlcp.grasp.model.request import GraspSpec

_GOLDEN_RATIO = (1.0 + np.sqrt(5.0)) / 2.0


@dataclass(frozen=True, slots=True)
class DirectionGrid:
    """Directions as points of a sphere or a circle, and how they are joined.

    points (m, 3) : unit vectors. cells (k, 3) : numbers of the corners of triangles, counterclockwise from outside;
    (k, 2) of the ends of segments of a circle; (0, 3) where nothing joins the points.
    """

    points: Array
    cells: Ints

    @property
    def edges(self) -> Ints:
        """Edges (e, 2) of all cells, as numbers of points: each once, the smaller number first."""
        c = self.cells
        pairs = c if c.shape[1] == 2 else np.concatenate([c[:, [0, 1]], c[:, [1, 2]], c[:, [2, 0]]])
        low, high = np.sort(pairs, axis=1).T
        keys = np.unique(low * len(self.points) + high)
        return np.stack([keys // len(self.points), keys % len(self.points)], axis=1)

    @property
    def shares(self) -> Array:
        """(m,) what part of all directions each point stands for: of the solid angle of the triangles, or of the angle
        of the segments; equal parts where nothing joins the points. Their sum is 1.
        """
        m = len(self.points)
        if not len(self.cells):
            return np.full(m, 1.0 / max(m, 1))
        corners = self.points[self.cells]
        if self.cells.shape[1] == 2:
            a, b = corners[:, 0], corners[:, 1]
            size = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
        else:
            size = abs(solid_angles(corners))
        each = np.repeat(size / self.cells.shape[1], self.cells.shape[1])
        return np.asarray(np.bincount(self.cells.ravel(), each, m) / size.sum())

    def divide_edges(self, cut: Ints) -> DirectionGrid:
        """The grid with a point in the middle of each of these edges, and with all cells divided that have one of them.

        cut (c, 2) : the edges; the new points are numbered from the last point on in this order.
        """
        middle = self.points[cut].sum(axis=1)
        points = np.concatenate([self.points, middle / np.linalg.norm(middle, axis=1)[:, None]])
        new = {(int(a), int(b)): len(self.points) + k for k, (a, b) in enumerate(cut.tolist())}
        width, key = self.cells.shape[1], np.array([len(self.points), 1])
        sides = [np.sort(self.cells[:, [j, (j + 1) % width]], axis=1) @ key for j in range(width)]
        touched = np.isin(np.array(sides), np.sort(cut, axis=1) @ key).any(axis=0)
        parts = [part for cell in self.cells[touched].tolist() for part in _divide_cell(cell, new, points)]
        cells = np.concatenate([self.cells[~touched], np.array(parts, dtype=np.int64).reshape(-1, width)])
        return DirectionGrid(read_only(points), cells)


def sphere_grid(count: int) -> DirectionGrid:
    """At least so many points all around: the faces of an icosahedron divided evenly. ±x, ±y and ±z are among them, and
    the grid is its own mirror image in the planes xy, yz and xz.
    """
    n = 2
    while 10 * n * n + 2 < count:
        n += 2  # only even divisions have points on the axes
    corners, faces = _icosahedron()
    weights = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)], dtype=float)
    number = {(int(a), int(b)): k for k, (a, b, _) in enumerate(weights)}
    local = []
    for i in range(n):
        for j in range(n - i):
            a, b, c = number[i, j], number[i + 1, j], number[i, j + 1]
            local.append((a, b, c))
            if i + j < n - 1:
                local.append((b, number[i + 1, j + 1], c))
    every = np.einsum("wk,fkx->fwx", weights, corners[faces]).reshape(-1, 3)
    every /= np.linalg.norm(every, axis=1)[:, None]
    _, first, own = np.unique(np.round(every, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    cells = np.array(local)[None] + len(weights) * np.arange(len(faces))[:, None, None]
    points = every[first]
    points[abs(points) < 1e-12] = 0.0
    return DirectionGrid(read_only(points), own.reshape(-1)[cells.reshape(-1, 3)])


def circle_grid(axes: Array, count: int) -> DirectionGrid:
    """So many points around, from the first of two axes (2, 3) to the second."""
    a = 2.0 * np.pi * np.arange(count) / count
    flat = np.stack([np.cos(a), np.sin(a)], axis=1)
    flat[abs(flat) < 1e-12] = 0.0
    here = np.arange(count)
    return DirectionGrid(read_only(flat @ axes), np.stack([here, (here + 1) % count], axis=1))


def _icosahedron() -> tuple[Array, Ints]:
    """(12, 3) corners and (20, 3) faces, counterclockwise from outside."""
    corners = np.array([np.roll((0.0, s, t * _GOLDEN_RATIO), k) for k in range(3) for s in (1, -1) for t in (1, -1)])
    near = np.isclose(np.linalg.norm(corners[:, None] - corners[None], axis=2), 2.0)
    faces = [(a, b, c) for a, b, c in combinations(range(12), 3) if near[a, b] and near[b, c] and near[a, c]]
    outward = [np.linalg.det(corners[list(f)]) > 0.0 for f in faces]
    return corners, np.array([f if out else f[::-1] for f, out in zip(faces, outward, strict=True)])


def _divide_cell(cell: list[int], new: dict[tuple[int, int], int], points: Array) -> list[list[int]]:
    """The cells into which one is divided. new : number of the point in the middle of each edge that is cut."""
    if len(cell) == 2:
        a, b = cell
        m = new[min(a, b), max(a, b)]
        return [[a, m], [m, b]]
    for _ in range(3):  # turned until its cut edges are the first ones
        a, b, c = cell
        ab, bc, ca = (new.get((min(i, j), max(i, j))) for i, j in ((a, b), (b, c), (c, a)))
        if ab is not None and (ca is None or bc is not None):
            break
        cell = [b, c, a]
    assert ab is not None
    if bc is None:
        return [[a, ab, c], [ab, b, c]]
    if ca is not None:
        return [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    # The corner at b is cut off; of the quadrilateral that is left, the shorter diagonal
    if np.linalg.norm(points[a] - points[bc]) < np.linalg.norm(points[ab] - points[c]):
        return [[ab, b, bc], [a, ab, bc], [a, bc, c]]
    return [[ab, b, bc], [a, ab, c], [ab, bc, c]]


# ----------------------------------------------------------------
# Which directions are asked for: all around, around a plane, or these.

_PLANE_AXES = {"xy": (0, 1), "yz": (1, 2), "xz": (0, 2)}
_MAX_DIRECTIONS = 200_000
_DIRECTIONS_IN_PLANE = 72  # where no number is said: one every 5°
_FORMS = """a number of directions all around, a plane such as "xy" or its normal (3,), a plane and a number such as \
("xy", 72), (m, 3) directions, or (m, 6) wrenches"""


@dataclass(frozen=True, slots=True)
class DirectionRequest:
    """The directions of an envelope, as they were asked for.

    grid : the directions, and how they are joined; points of zero where wrenches were given.
    wrenches (m, 6) : that were given in place of directions [N, N·m], about the grasp's reference; None without.
    plane (2, 3) : axes of the plane in which directions lie; None: there is none.
    is_refinable : whether more directions between these would answer the question better.
    """

    grid: DirectionGrid
    wrenches: Array | None = None
    plane: Array | None = None
    is_refinable: bool = True


def read_directions(asked: Any) -> DirectionRequest:
    """Check the directions, the plane or the wrenches of an envelope, in any form that `envelope` takes.

    Raises InputError.
    """
    if isinstance(asked, (int, np.integer)) and not isinstance(asked, (bool, np.bool_)):
        return DirectionRequest(sphere_grid(check_integer("directions", asked, 1, _MAX_DIRECTIONS)))
    if isinstance(asked, str):
        return _directions_in_plane(asked, _DIRECTIONS_IN_PLANE)
    pair = isinstance(asked, (tuple, list)) and len(asked) == 2 and count_dimensions(asked[1]) == 0
    if pair and (isinstance(asked[0], str) or count_dimensions(asked[0]) == 1):
        return _directions_in_plane(asked[0], check_integer("directions", asked[1], 3, _MAX_DIRECTIONS))
    if count_dimensions(asked) == 1:
        return _directions_in_plane(asked, _DIRECTIONS_IN_PLANE)
    given = check_array("directions", asked, (-1, 3), (-1, 6), what=_FORMS)
    if not len(given) or (given == 0.0).all(axis=1).any():
        raise InputError("directions", f"{_FORMS}; none of them zero", f"{len(given)} rows")
    if given.shape[1] == 6:
        still = read_only(np.zeros((len(given), 3)))
        grid = DirectionGrid(still, np.zeros((0, 3), dtype=np.int64))
        return DirectionRequest(grid, wrenches=given, is_refinable=False)
    points = given / np.linalg.norm(given, axis=1)[:, None]
    return DirectionRequest(DirectionGrid(read_only(points), _join_all_around(points)), is_refinable=False)


def _directions_in_plane(plane: Any, count: int) -> DirectionRequest:
    """Directions all around in a plane, evenly spread. plane : "xy", "yz", "xz" or a normal (3,). Raises InputError."""
    if isinstance(plane, str):
        if plane not in _PLANE_AXES:
            raise InputError("directions", _FORMS, repr(plane))
        axes = np.eye(3)[list(_PLANE_AXES[plane])]
    else:
        normal = check_array("directions", plane, (3,), what=_FORMS)
        if not normal.any():
            raise InputError("directions", "a plane's normal that is not zero", normal.tolist())
        axes = contact_frame(normal / np.linalg.norm(normal)).T[:2]
    return DirectionRequest(circle_grid(axes, count), plane=read_only(axes))


def _join_all_around(points: Array) -> Any:
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


# ----------------------------------------------------------------
# What gives out first in each direction, in words and as shares of all directions.

BindingCauses = tuple[FailureMode, ...]


@dataclass(frozen=True, slots=True)
class Sector:
    """Directions in which the same gives out first.

    binds : as in `Envelope.binds`; () where nothing gives out. says : in words. share : of all directions.
    least, median : of the factors there, by solid angle; infinite where nothing gives out, NaN where undecided.
    """

    binds: BindingCauses
    says: str
    share: float
    least: float
    median: float


def group_causes(
    binds: Sequence[BindingCauses], factors: Array, shares: Array, spec: GraspSpec
) -> tuple[tuple[Sector, ...], Ints]:
    """The causes, the most frequent first; and (m,) the number of each direction's cause. shares (m,) : what part of
    all directions each stands for. spec : of the grasp.
    """
    keys = [frozenset(some) for some in binds]
    number = {key: k for k, key in enumerate(dict.fromkeys(keys))}
    own = np.array([number[key] for key in keys], dtype=np.int64)
    part = np.bincount(own, shares, len(number))
    order = np.argsort(-part, kind="stable")
    found = []
    for k in order.tolist():
        here = np.flatnonzero(own == k)
        some, middle = binds[int(here[0])], weighted_median(factors[here], shares[here])
        found.append(Sector(some, describe_failures(some, spec), float(part[k]), float(factors[here].min()), middle))
    return tuple(found), np.argsort(order)[own]


def weighted_median(values: Array, shares: Array) -> float:
    """The weighted median of values (m,). shares (m,) : the weights."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(shares[order])
    return float(values[order][np.searchsorted(below, 0.5 * below[-1])])
