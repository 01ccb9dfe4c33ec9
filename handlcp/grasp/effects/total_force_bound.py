"""The paper's bound on the sum of normal forces: at the bound, the hand opens instead of squeezing harder.

    0 ≤ z̄ ⟂ r̄ - Σ r_N ≥ 0,    ε_N += z̄ for every finger

Source: paper, equations (14) to (16).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, number
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown
from handlcp.tolerances import ACTIVE

__all__ = ["TotalForceBound"]


@dataclass(frozen=True, slots=True)
class TotalForceBound(Effect):
    """Upper bound `limit` [N] > 0 on the sum of all unknown normal forces."""

    limit: float

    title = "total normal-force bound"
    equation = "0 ≤ z̄ ⟂ r̄ - Σ r_N ≥ 0,  ε_N += z̄"

    def __post_init__(self) -> None:
        """Check the limit."""
        object.__setattr__(self, "limit", number("TotalForceBound.limit", self.limit, above=0.0))

    def why(self, scene: Scene) -> str:
        """Asked for."""
        return f"asked for: Σ r_N ≤ {self.limit:g} N"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """z̄: the opening common to all fingers."""
        return (Unknown("z̄", 1, False, "motion", "force"),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The bound's slack, and the opening of every gap."""
        system.add("r_N", "z̄", 1.0)
        system.add("z̄", "r_N", -1.0)
        system.load("z̄", self.limit / scene.units.force)

    def opening(self, scene: Scene, extra: dict[str, Array]) -> Array | None:
        """z̄ along the normal of every governed contact."""
        return _normals(scene) * float(extra["z̄"][0])

    def coupling(self, scene: Scene, extra: dict[str, Array]) -> Array | None:
        """Σ r_N stays at the bound while z̄ > 0."""
        return _normals(scene).ravel() if extra["z̄"][0] > ACTIVE * scene.units.motion else None

    def residual(
        self, scene: Scene, forces: Array, extra: dict[str, Array], force_size: float, motion_size: float
    ) -> float:
        """|min(z̄, r̄ - Σ r_N)|, relative."""
        slack = self.limit - float(forces[list(scene.governed), 2].sum())
        return abs(min(float(extra["z̄"][0]) / motion_size, slack / force_size))


def _normals(scene: Scene) -> Array:
    normals = np.zeros((scene.n, 3))
    normals[list(scene.governed), 2] = 1.0
    return normals
