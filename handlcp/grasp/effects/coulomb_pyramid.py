"""Coulomb friction on a pyramid of m faces: inside it sticks, on a face it slides against the face.

    ε_T = -N λ,    0 ≤ λ ⟂ μ_m r_N - Nᵀ r_T ≥ 0,    N = (cos α_j; sin α_j), α_j = 2πj/m

with the outward face normals in the columns of N; μ_m = μ cos(π/m) for the inscribed pyramid, μ for the circumscribed.
Signs are the model's: the paper's D is our -N.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from handlcp.check import Array, Ints
from handlcp.grasp.friction import Interval, Pyramid, Section, limit_set
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown
from handlcp.lcp.kernels.compile import kernel

__all__ = ["CoulombPyramid", "place_faces", "points_without_friction", "tangential_forces", "why_no_points"]


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
    order = 30

    @classmethod
    def called_for(cls, scene: Scene, section: Section, multipliers: bool) -> Effect | None:
        """On pyramids, with multipliers."""
        return _of(section) if scene.rough and multipliers and isinstance(section, Pyramid) else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """Another form of friction was asked for."""
        return why_no_points(scene, section)

    def why(self, scene: Scene) -> str:
        """Which contacts, what pyramid."""
        return f"{len(scene.rough)} contacts with μ > 0, {self.pyramid.name}"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        """Frictionless."""
        return points_without_friction(contacts)

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: two a contact; λ: m a contact."""
        faces = int(self.pyramid.faces)
        return tangential_forces(scene), Unknown("λ", faces * len(scene.rough), False, "motion", "force")

    def stamp(self, scene: Scene, system: System) -> None:
        """Slip along the faces, and how far the force is inside each of them."""
        place_faces(system, scene, scene.rough, ("r_T", "λ"), self.pyramid)
        system.load_tangents("r_T", scene)


_of = lru_cache(maxsize=64)(CoulombPyramid)


def tangential_forces(scene: Scene) -> Unknown:
    """r_T of all contacts with friction but no moment."""
    return Unknown("r_T", sum(scene.kind.tangents[i] for i in scene.rough), True, "force", "motion")


def points_without_friction(contacts: tuple[Contact, ...]) -> dict[str, Any]:
    """The contacts, those with friction frictionless."""
    return {"contacts": tuple([c.with_friction(c.friction.with_mu(0.0)) if c.mu > 0.0 else c for c in contacts])}


def why_no_points(scene: Scene, section: Section) -> str:
    """Why a form of friction is absent."""
    if not scene.rough:
        return "every contact with friction is soft" if scene.soft else "no contact has μ > 0"
    if isinstance(section, Interval):
        return "the scene is planar: one tangent, exact"
    return "a pyramid was asked for" if isinstance(section, Pyramid) else "the exact cone was asked for"


def place_faces(
    system: System, scene: Scene, contacts: tuple[int, ...], names: tuple[str, str], section: Section | None = None
) -> None:
    """Write the blocks above for these contacts, which have as many tangents each; names : of forces and multipliers.

    section : None: an interval.
    """
    at, own = system.at, limit_set(section or Interval(), scene.kind.tangents[contacts[0]])
    forces, faces = (at[name].start for name in names)
    limits = own.limit(scene.mu[list(contacts)])
    _place(system.M, (forces, faces, at["r_N"].start), scene.kind.rows_of(contacts), limits, own.normals)


@kernel
def _place(M: Array, at: tuple[int, int, int], rows: Ints, limits: Array, N: Array) -> None:
    """At: where forces, multipliers and normal forces begin. rows : which normal force is each contact's own."""
    axes, m = N.shape
    for k in range(len(rows)):
        for j in range(m):
            f = at[1] + m * k + j
            M[f, at[2] + rows[k]] = limits[k]
            for a in range(axes):
                t = at[0] + axes * k + a
                M[t, f], M[f, t] = N[a, j], -N[a, j]
