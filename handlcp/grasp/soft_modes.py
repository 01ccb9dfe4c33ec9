"""Contact modes of soft fingers on the exact cone, for `modes`: cells of the ball that enclose force and slip.

Meridians and parallels, as in `limit_surface`, cut the ball into cells. Sliding in a cell, the force lies on the ball's
patch and the slip in the opposite cell: the one is enclosed by the corners n_a, the points where the tangent planes of
two neighbours meet, (n_a + n_b) / (1 + n_a·n_b), and where all of the cell's do; the other by the cone of the -n_a.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from handlcp.check import Array, Bools

__all__ = ["soft_modes"]

_MERIDIANS, _PARALLELS = 8, 2  # the latter from the equator to a pole


def soft_modes(mu: float) -> tuple[Array, Array, Bools, Bools]:
    """Force generators (4, a), motion generators (4, b), and which of them each mode allows, (modes, a), (modes, b).

    mu : coefficient; components x, y, moment over lever, normal. Modes: open; stuck; sliding within each cell. Motion
    generators end with the normal: the gap.
    """
    normals, points, corners, patch, apexes = _cells()
    n, p = normals.shape[1], points.shape[1]
    force = np.vstack([mu * points, np.ones(p)])
    motion = np.hstack([np.vstack([-normals, np.zeros(n)]), [[0.0], [0.0], [0.0], [1.0]]])
    closed = np.zeros((len(corners) + 1, 1), bool)
    A = np.vstack([np.zeros(p, bool), apexes, patch])
    B = np.vstack([np.append(np.zeros(n, bool), True), np.hstack([np.vstack([np.zeros(n, bool), corners]), closed])])
    return force, motion, A, B


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
