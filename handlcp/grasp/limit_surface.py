"""The limit surface of a soft finger: which tangential force and moment it bears, per newton of normal force.

In the coordinates of its law (x, y, moment over lever) it is the unit ball on the exact cone, and with m faces the
polyhedron nᵀ y ≤ 1 with a normal at every meeting of m meridians and the parallels between them:

    n = (cos φ cos α, cos φ sin α, sin φ),    α = 2πj/m,  φ = (π/2) l/k,  |l| ≤ k = max(1, round(m/4))

Along the equator the meridians are the faces of the pyramid. By symmetry its vertices lie halfway between meridians,
where two neighbouring parallels' planes meet. Source: Howe & Cutkosky, Int. J. Robotics Research 15 (1996), the
ellipsoid; model, "soft finger" (facets in (r_T, r_τ/ρ)).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.pyramid import Cone, Pyramid, Section
from handlcp.lcp.kernels.polyhedron import nearest_in_ball, nearest_in_polyhedron

__all__ = ["LimitSurface", "limit_surface"]

_OUTER = 24  # meridians of the polyhedron that stands for the ball in statements that are linear programs


@dataclass(frozen=True, slots=True, eq=False)
class LimitSurface:
    """normals (3, f), unit, and the same in rows, outward (f, 3); vertices (3, p) of the polyhedron whose faces touch
    the unit ball; share : of the coefficient, at which its faces lie (1: they touch the ball; less: its vertices
    do). exact : whether it is the ball, and the polyhedron only one around it.
    """

    normals: Array
    outward: Array
    vertices: Array
    share: float
    exact: bool

    @property
    def faces(self) -> int:
        """How many multipliers a contact has; none on the exact cone."""
        return 0 if self.exact else self.normals.shape[1]

    def limit(self, mu: Array) -> Array:
        """(n,) distance of the faces from the axis, per newton of normal force."""
        return mu * self.share

    def nearest(self, y: Array, size: float) -> Array:
        """(3,) the point nearest to y of the surface and what it encloses, `size` times as large."""
        p, D = np.empty(3), np.empty((3, 4))
        if self.exact:
            nearest_in_ball(y, max(size, 0.0), p, D)
        else:
            nearest_in_polyhedron(y, max(size, 0.0), self.outward, p, D)
        return p


@lru_cache(maxsize=64)
def limit_surface(section: Section) -> LimitSurface:
    """Of this section of the friction cones; an interval has none, because nothing turns out of its plane."""
    exact = isinstance(section, Cone)
    m = _OUTER if exact else int(section.faces)
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
    vertices = np.hstack(corners)
    reach = float(np.sqrt((vertices**2).sum(axis=0)).max())
    share = 1.0 / reach if isinstance(section, Pyramid) and section.inscribed else 1.0
    outward = read_only(np.ascontiguousarray(normals.T))
    return LimitSurface(read_only(normals), outward, read_only(vertices), share, exact)
