"""Directions as points of a sphere or a circle, joined by triangles or segments that can be halved where it pays."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.geometry.mesh import solid_angles

_GOLDEN = (1.0 + np.sqrt(5.0)) / 2.0


@dataclass(frozen=True, slots=True)
class Grid:
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
        size = _angles(corners) if self.cells.shape[1] == 2 else abs(solid_angles(corners))
        each = np.repeat(size / self.cells.shape[1], self.cells.shape[1])
        return np.asarray(np.bincount(self.cells.ravel(), each, m) / size.sum())

    def halved(self, cut: Ints) -> Grid:
        """The grid with a point in the middle of each of these edges, and with all cells divided that have one of them.

        cut (c, 2) : the edges; the new points are numbered from the last point on in this order.
        """
        middle = self.points[cut].sum(axis=1)
        points = np.concatenate([self.points, middle / np.linalg.norm(middle, axis=1)[:, None]])
        new = {(int(a), int(b)): len(self.points) + k for k, (a, b) in enumerate(cut.tolist())}
        width = self.cells.shape[1]
        touched = self._with_an_edge(cut)
        parts = [part for cell in self.cells[touched].tolist() for part in _parts(cell, new, points)]
        cells = np.concatenate([self.cells[~touched], np.array(parts, dtype=np.int64).reshape(-1, width)])
        return Grid(read_only(points), cells)

    def _with_an_edge(self, cut: Ints) -> Bools:
        """(k,) which cells have one of these edges."""
        c, m = self.cells, len(self.points)
        keys = np.sort(cut, axis=1) @ np.array([m, 1])
        sides = [(0, 1)] if c.shape[1] == 2 else [(0, 1), (1, 2), (2, 0)]
        own = [np.sort(c[:, list(side)], axis=1) @ np.array([m, 1]) for side in sides]
        return np.asarray(np.isin(np.array(own), keys).any(axis=0))


def sphere(count: int) -> Grid:
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
    return Grid(read_only(points), own.reshape(-1)[cells.reshape(-1, 3)])


def circle(axes: Array, count: int) -> Grid:
    """So many points around, from the first of two axes (2, 3) to the second."""
    a = 2.0 * np.pi * np.arange(count) / count
    flat = np.stack([np.cos(a), np.sin(a)], axis=1)
    flat[abs(flat) < 1e-12] = 0.0
    here = np.arange(count)
    return Grid(read_only(flat @ axes), np.stack([here, (here + 1) % count], axis=1))


def _icosahedron() -> tuple[Array, Ints]:
    """(12, 3) corners and (20, 3) faces, counterclockwise from outside."""
    corners = np.array([np.roll((0.0, s, t * _GOLDEN), k) for k in range(3) for s in (1, -1) for t in (1, -1)])
    near = np.isclose(np.linalg.norm(corners[:, None] - corners[None], axis=2), 2.0)
    faces = [(a, b, c) for a, b, c in combinations(range(12), 3) if near[a, b] and near[b, c] and near[a, c]]
    outward = [np.linalg.det(corners[list(f)]) > 0.0 for f in faces]
    return corners, np.array([f if out else f[::-1] for f, out in zip(faces, outward, strict=True)])


def _parts(cell: list[int], new: dict[tuple[int, int], int], points: Array) -> list[list[int]]:
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


def _angles(pairs: Array) -> Array:
    """(k,) between the ends of segments (k, 2, 3)."""
    a, b = pairs[:, 0], pairs[:, 1]
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1)))
