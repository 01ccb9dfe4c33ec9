"""Contact modes on friction sets: cells of the disc, the polygon or the ball that enclose force and slip.

A contact is open, sticks, or slides within a cell. In each mode its force and its motion are nonnegative multiples of a
few generators. Rays cut the disc into sectors; meridians and parallels, as in `friction.limit_set`, cut the ball into
cells. A polygon's cells are those of a disc with as many rays, which meet the middles of its faces.

Sliding in a cell, the force lies on the patch of the set's surface and the slip in the opposite cell. The one is
enclosed by the corners n_a, the points where the tangents (tangent planes) of two neighbours meet,
(n_a + n_b) / (1 + n_a·n_b), and where all of the cell's do; the other by the cone of the -n_a.
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

    limit : radius of the disc or the ball, or distance of the polygon's faces. faces : of the polygon; 0: the disc.

    Modes: open; touching, or stuck where there is friction; sliding within each cell. Motion generators end with the
    normal: the gap.
    """
    if tangents == 0 or limit <= 0.0:
        up = np.eye(1 + tangents)[:, -1:]
        return up, up, np.array([[False], [True]]), np.array([[True], [False]])
    normals, points, corners, patch, whole = _sectors(faces or _SECTORS) if tangents == 2 else _cells()
    (d, n), p = normals.shape, points.shape[1]
    force = np.vstack([limit * points, np.ones(p)])
    motion = np.hstack([np.vstack([-normals, np.zeros(n)]), np.eye(1 + d)[:, -1:]])
    closed = np.zeros((len(corners) + 1, 1), bool)
    A = np.vstack([np.zeros(p, bool), whole, patch])
    B = np.vstack([np.append(np.zeros(n, bool), True), np.hstack([np.vstack([np.zeros(n, bool), corners]), closed])])
    return force, motion, A, B


def slide_bits(slides: int) -> Array:
    """(bits, slides) Gray code of the sectors in the order of their angles; none for two or less."""
    if slides <= 2:
        return np.zeros((0, max(slides, 0)))
    order = np.arange(slides)
    return np.array([((order ^ (order >> 1)) >> k) & 1 for k in range(int(slides - 1).bit_length())], dtype=float)


@lru_cache(maxsize=16)
def _sectors(m: int) -> tuple[Array, Array, Bools, Bools, Bools]:
    """As `_cells`, for m sectors: the rays between them, and where the tangents at neighbouring rays meet."""
    a, one = 2 * np.pi * np.arange(m) / m, np.eye(m, dtype=bool)
    rays = np.vstack([np.cos(a), np.sin(a)])
    outer = np.vstack([np.cos(a + np.pi / m), np.sin(a + np.pi / m)]) / np.cos(np.pi / m)  # between j and j + 1
    both = one | np.roll(one, 1, 1)  # row j: j and j + 1
    return rays, np.hstack([outer, rays]), both, np.hstack([one, both]), np.arange(2 * m) < m


@lru_cache(maxsize=1)
def _cells() -> tuple[Array, Array, Bools, Bools, Bools]:
    """Normals (3, n) of the corners; points (3, p): those, then what encloses the patches; corners (cells, n) and patch
    (cells, p) of each; apexes (p,): whose hull holds the whole ball.
    """
    m, k = _MERIDIANS, _PARALLELS
    normals: list[Array] = []
    place: dict[tuple[int, int], int] = {}

    def corner(level: int, j: int) -> int:
        key = (level, 0 if abs(level) == k else j % m)
        if key not in place:
            phi, alpha = 0.5 * np.pi * level / k, 2 * np.pi * key[1] / m
            place[key] = len(normals)
            flat = 0.0 if abs(level) == k else np.cos(phi)
            normals.append(np.array([flat * np.cos(alpha), flat * np.sin(alpha), np.sin(phi)]))
        return place[key]

    cells = []
    for level in range(-k, k):
        for j in range(m):
            around = [corner(level, j), corner(level, j + 1), corner(level + 1, j + 1), corner(level + 1, j)]
            cells.append(list(dict.fromkeys(around)))
    points, patches, apexes = list(normals), [], []
    shared: dict[tuple[int, int], int] = {}
    for cell in cells:
        patch = list(cell)
        for a, b in zip(cell, cell[1:] + cell[:1], strict=True):
            edge = (min(a, b), max(a, b))
            if edge not in shared:
                shared[edge] = len(points)
                points.append((normals[a] + normals[b]) / (1.0 + normals[a] @ normals[b]))
            patch.append(shared[edge])
        apexes.append(len(points))
        patch.append(len(points))
        # All tangent planes of a cell's corners meet in one point, by symmetry
        points.append(np.linalg.lstsq(np.array([normals[a] for a in cell]), np.ones(len(cell)), rcond=None)[0])
        patches.append(patch)
    in_cell, in_patch = np.zeros((len(cells), len(normals)), bool), np.zeros((len(cells), len(points)), bool)
    for c, (cell, patch) in enumerate(zip(cells, patches, strict=True)):
        in_cell[c, cell], in_patch[c, patch] = True, True
    whole = np.zeros(len(points), bool)
    whole[apexes] = True
    return np.array(normals).T, np.array(points).T, in_cell, in_patch, whole
