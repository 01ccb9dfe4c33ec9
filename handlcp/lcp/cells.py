"""Contact modes on friction sets: intervals, polygons, and cells of the disc or the ball that enclose force and slip.

A contact is open, sticks, or slides. In each mode its force and its motion are nonnegative multiples of a few
generators. On an interval it slides at one end or the other, on a polygon on a face or at the vertex between two.
Rays cut the disc into sectors; meridians and parallels, as in `friction.limit_set`, cut the ball into cells. Sliding in
a cell, the force lies on the patch of the set's surface and the slip in the opposite cell. The one is enclosed by the
corners n_a, the points where the tangents (tangent planes) of two neighbours meet, (n_a + n_b) / (1 + n_a·n_b), and
where all of the cell's do; the other by the cone of the -n_a.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from handlcp.check import Array, Bools

__all__ = ["Modes", "cell_modes", "slide_bits"]

_SECTORS = 16  # that enclose the disc
_MERIDIANS, _PARALLELS = 8, 2  # of the ball; the latter from the equator to a pole

Modes = tuple[Array, Array, Bools, Bools]


def cell_modes(limit: float, tangents: int, faces: int) -> Modes:
    """Force generators (1 + d, a), motion generators (1 + d, b), and which of them each mode allows, (modes, a) and
    (modes, b); components: the d tangents, then the normal.

    limit : radius of the disc or the ball, or distance of the faces. faces : of the polygon; 2: the interval; 0: disc
    and ball. There is no polyhedron.

    Modes: open; touching, or stuck where there is friction; sliding within each cell. Motion generators end with the
    normal: the gap.
    """
    if tangents == 0 or limit <= 0.0:
        up = np.eye(1 + tangents)[:, -1:]
        return up, up, np.array([[False], [True]]), np.array([[True], [False]])
    normals, points, corners, patch, whole = _shape(tangents, faces)
    (d, n), p = normals.shape, points.shape[1]
    force = np.vstack([limit * points, np.ones(p)])
    motion = np.hstack([np.vstack([-normals, np.zeros(n)]), np.eye(1 + d)[:, -1:]])
    A = np.vstack([np.zeros(p, bool), whole, patch])
    still = np.zeros((1, n + 1), bool)  # what is open slips as it likes
    B = np.vstack([~still, still, np.hstack([corners, np.zeros((len(corners), 1), bool)])])
    return force, motion, A, B


def slide_bits(slides: int) -> Array:
    """(bits, slides) Gray code of the sectors in the order of their angles; none for two or less."""
    if slides <= 2:
        return np.zeros((0, max(slides, 0)))
    order = np.arange(slides)
    return np.array([((order ^ (order >> 1)) >> k) & 1 for k in range(int(slides - 1).bit_length())], dtype=float)


def _shape(tangents: int, faces: int) -> tuple[Array, Array, Bools, Bools, Bools]:
    """As `_cells`, of any set."""
    if tangents == 1:
        both = np.eye(2, dtype=bool)
        return np.array([[1.0, -1.0]]), np.array([[1.0, -1.0]]), both, both, np.ones(2, bool)
    return _cells() if tangents == 3 else _polygon(faces) if faces else _sectors()


@lru_cache(maxsize=16)
def _polygon(m: int) -> tuple[Array, Array, Bools, Bools, Bools]:
    """As `_cells`: faces and vertices in turn, by the angle; vertex j lies between the faces j and j + 1."""
    one = np.eye(m, dtype=bool)
    normals, vertices = _ring(m, 0.0), _ring(m, 0.5) / np.cos(np.pi / m)
    corners = np.stack([one, one | np.roll(one, 1, 1)], axis=1).reshape(2 * m, m)
    patch = np.stack([one | np.roll(one, -1, 1), one], axis=1).reshape(2 * m, m)
    return normals, vertices, corners, patch, np.ones(m, bool)


def _ring(m: int, shift: float) -> Array:
    """(2, m) unit vectors."""
    a = 2 * np.pi * (np.arange(m) + shift) / m
    return np.vstack([np.cos(a), np.sin(a)])


@lru_cache(maxsize=1)
def _sectors() -> tuple[Array, Array, Bools, Bools, Bools]:
    """As `_cells`, for the disc: the rays between sectors, and where the tangents at neighbouring rays meet."""
    m = _SECTORS
    rays, outer, one = _ring(m, 0.0), _ring(m, 0.5) / np.cos(np.pi / m), np.eye(m, dtype=bool)
    both = one | np.roll(one, 1, 1)  # row j: j and j + 1
    return rays, np.hstack([outer, rays]), both, np.hstack([one, both]), np.arange(2 * m) < m


@lru_cache(maxsize=1)
def _cells() -> tuple[Array, Array, Bools, Bools, Bools]:
    """Normals (3, n) of the corners; points (3, p): those, then what encloses the patches; corners (cells, n) and patch
    (cells, p) of each; apexes (p,): whose hull holds the whole ball.
    """
    m, k = _MERIDIANS, _PARALLELS
    phi = np.arange(1 - k, k) * (0.5 * np.pi / k)
    circles = [np.vstack([np.cos(p) * _ring(m, 0.0), np.full(m, np.sin(p))]) for p in phi]
    poles = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]).T
    normals = np.hstack([poles[:, :1], *circles, poles[:, 1:]])
    place = np.zeros((2 * k + 1, m), int)  # of the corners of each parallel; all of a pole's are one
    place[1:-1], place[-1] = 1 + np.arange(m * (2 * k - 1)).reshape(-1, m), normals.shape[1] - 1
    beside = np.roll(place, -1, axis=1)
    around = np.stack([place[:-1], beside[:-1], beside[1:], place[1:]], axis=-1).reshape(-1, 4)
    cells = [list(dict.fromkeys(corners)) for corners in around.tolist()]
    in_cell = np.array([np.isin(np.arange(normals.shape[1]), cell) for cell in cells])
    sides = {tuple(sorted(side)) for cell in cells for side in zip(cell, cell[1:] + cell[:1], strict=True)}
    a, b = np.array(sorted(sides)).T
    edges = (normals[:, a] + normals[:, b]) / (1.0 + (normals[:, a] * normals[:, b]).sum(axis=0))
    # All tangent planes of a cell's corners meet in one point, by symmetry
    apexes = [np.linalg.lstsq(normals[:, cell].T, np.ones(len(cell)), rcond=None)[0] for cell in cells]
    points = np.hstack([normals, edges, np.array(apexes).T])
    in_patch = np.hstack([in_cell, in_cell[:, a] & in_cell[:, b], np.eye(len(cells), dtype=bool)])
    return normals, points, in_cell, in_patch, np.arange(points.shape[1]) >= points.shape[1] - len(cells)
