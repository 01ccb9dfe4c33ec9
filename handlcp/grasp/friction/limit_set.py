"""What a contact may transmit along its tangents, per newton of normal force, in the coordinates of its law.

A law is a ball in one, two or three tangents (x, y, moment over lever). A section takes it as it is, or puts a set with
flat faces nᵀ y ≤ 1 in its place:

    tangents   cone   pyramid of m faces                                   interval
    1          –      –                                                    both ends, exact
    2          disc   regular polygon, normals at 2πj/m                    –
    3          ball   polyhedron with a normal n at every meeting of m     –
                      meridians and the parallels between them

    n = (cos φ cos α, cos φ sin α, sin φ),    α = 2πj/m,  φ = (π/2) l/k,  |l| ≤ k = max(1, round(m/4))

Along the equator the meridians are the faces of the polygon. By symmetry the polyhedron's vertices lie halfway between
meridians, where two neighbouring parallels' planes meet. Source: Howe & Cutkosky, Int. J. Robotics Research 15 (1996),
the ellipsoid, here in (r_T, r_τ / lever).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.friction.sections import Cone, Interval, Pyramid, Section

_OUTSIDE = Pyramid(64, inscribed=False)  # stands for the disc; its edges lie outside by 0.12 %
_MERIDIANS = 24  # of the polyhedron that stands for the ball


@dataclass(frozen=True, slots=True, eq=False)
class LimitSet:
    """The set for one coefficient of friction.

    normals : (d, f) outward unit normals of the faces. vertices : (d, p) corners of the set whose faces touch the unit
    ball. share : of the coefficient, at which the faces lie (1: they touch the ball; less: the vertices do). The set of
    the cone is the ball itself; normals and vertices are then those of a set around it, for statements that are linear
    programs: what lies outside that lies outside the ball.
    """

    normals: Array
    vertices: Array
    share: float


@lru_cache(maxsize=64)
def limit_set(section: Section, tangents: int) -> LimitSet:
    """Of contacts with so many tangents; an interval has one."""
    if tangents == 1 or isinstance(section, Interval):
        ends = read_only(np.array([[1.0, -1.0]]))
        return LimitSet(ends, ends, 1.0)
    if tangents == 2:
        polygon = _OUTSIDE if isinstance(section, Cone) else section
        return LimitSet(polygon.normals, polygon.edges, polygon.share)
    normals, vertices = _polyhedron(section.faces or _MERIDIANS)
    reach = float(np.sqrt((vertices**2).sum(axis=0)).max())
    return LimitSet(read_only(normals), read_only(vertices), 1.0 / reach if section.share < 1.0 else 1.0)


def _polyhedron(m: int) -> tuple[Array, Array]:
    """Normals (3, f) and vertices (3, p)."""
    k = max(1, round(m / 4))
    meridian, parallel = 2 * np.pi * np.arange(m) / m, 0.5 * np.pi * np.arange(-k + 1, k) / k
    rings = [[np.cos(p) * np.cos(meridian), np.cos(p) * np.sin(meridian), np.full(m, np.sin(p))] for p in parallel]
    poles = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, -1.0]])
    normals = np.hstack([*(np.array(r) for r in rings), poles])
    normals[abs(normals) < 1e-15] = 0.0
    between, corners = meridian + np.pi / m, []
    for low, high in zip(*(0.5 * np.pi * np.arange(a, a + k) / k for a in (0, 1)), strict=True):
        # nᵀ y = 1 on both parallels, in the plane halfway between two meridians
        planes = np.array([[np.cos(p) * np.cos(np.pi / m), np.sin(p)] for p in (low, high)])
        a, b = np.linalg.solve(planes, np.ones(2))
        for side in (b, -b):
            corners.append(np.array([a * np.cos(between), a * np.sin(between), np.full(m, side)]))
    return normals, np.hstack(corners)
