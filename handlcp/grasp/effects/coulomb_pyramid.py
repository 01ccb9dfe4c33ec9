"""Coulomb friction on a pyramid of m faces: inside it sticks, on a face it slides against the face.

    ε_T = -N λ,    0 ≤ λ ⟂ μ_m r_N - Nᵀ r_T ≥ 0,    N = (cos α_j; sin α_j), α_j = 2πj/m

with the outward face normals in the columns of N; μ_m = μ cos(π/m) for the inscribed pyramid, μ for the circumscribed.
Signs are the model's: the paper's D is our -N.
"""

from __future__ import annotations

from dataclasses import dataclass

from handlcp.check import Array, Ints
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.pyramid import Pyramid
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown
from handlcp.lcp.kernels.compile import kernel

__all__ = ["CoulombPyramid", "place_faces"]


@dataclass(frozen=True, slots=True)
class CoulombPyramid(Effect):
    """Two tangential forces and m face multipliers for each contact with friction."""

    pyramid: Pyramid

    title = "Coulomb friction, pyramid"
    equation = "ε_T = -N λ,  0 ≤ λ ⟂ μ_m r_N - Nᵀ r_T ≥ 0"
    when = "Friction for solvers of linear problems, and the default: m faces inside the cone."
    in_python = "friction=Coulomb(0.6), faces=8"
    in_file = "grasp.friction = 0.6\nsolve.faces = 8"
    brings = "2 + m a contact"
    source = "Ai & Li (2025), equations (7) to (12)"

    def why(self, scene: Scene) -> str:
        """Which contacts, what pyramid."""
        return f"{len(scene.rough)} contacts with μ > 0, {self.pyramid.name}"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: two a contact; λ: m a contact."""
        k, m = len(scene.rough), int(self.pyramid.faces)
        return (
            Unknown("r_T", 2 * k, True, "force", "motion"),
            Unknown("λ", m * k, False, "motion", "force"),
        )

    def stamp(self, scene: Scene, system: System) -> None:
        """Slip along the faces, and how far the force is inside each of them."""
        at = system.at
        place_faces(
            system.M,
            at["r_T"].start,
            at["λ"].start,
            at["r_N"].start,
            scene.rough_rows,
            self.pyramid.limit(scene.mu[list(scene.rough)]),
            self.pyramid.normals,
        )
        system.load("r_T", scene.tangential_offset)


@kernel
def place_faces(M: Array, tangential: int, faces: int, normals: int, rows: Ints, limits: Array, N: Array) -> None:
    """Write the blocks above for every contact with friction; rows: which normal force is its own."""
    axes, m = N.shape
    for k in range(len(rows)):
        for j in range(m):
            f = faces + m * k + j
            M[f, normals + rows[k]] = limits[k]
            for a in range(axes):
                t = tangential + axes * k + a
                M[t, f], M[f, t] = N[a, j], -N[a, j]
