"""The paper's bound on the sum of normal forces: at the bound, the hand opens instead of squeezing harder.

    0 ≤ z̄ ⟂ r̄ - Σ r_N ≥ 0,    ε_N += z̄ for every finger

It is the hand's squeeze that is bounded: contacts of the environment are not in the sum, and z̄ does not open them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import number
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.limit import Limit
from handlcp.grasp.scene import Scene

__all__ = ["TotalForceBound"]


@dataclass(frozen=True, slots=True)
class TotalForceBound(Effect):
    """Upper bound `limit` [N] > 0 (inf: none) on the sum of all unknown normal forces of fingers."""

    limit: float

    title = "total normal-force bound"
    equation = "0 ≤ z̄ ⟂ r̄ - Σ r_N ≥ 0,  ε_N += z̄"
    when = "An actuator or a fragile object that bears only so much squeeze in all."
    in_python = "effects=[TotalForceBound(6.0)]"
    in_file = "effects.total_force_bound_N = 6.0"
    brings = "1"
    source = "Ai & Li (2025), equations (14) to (16)"

    def __post_init__(self) -> None:
        """Check the limit."""
        object.__setattr__(self, "limit", number("TotalForceBound.limit", self.limit, above=0.0, finite=False))

    @property
    def opens(self) -> bool:
        """Not without a bound."""
        return bool(np.isfinite(self.limit))

    def why(self, scene: Scene) -> str:
        """Asked for."""
        return f"asked for: Σ r_N ≤ {self.limit:g} N"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """One, of all normal forces; z̄ is the opening common to all fingers. An infinite bound is none."""
        if not np.isfinite(self.limit):
            return ()
        rows = np.zeros((1, scene.components))
        rows[0, scene.normal_index] = 1.0
        if scene.fingers is not None:
            rows[0, 3 * scene.fingers :] = 0.0
        return (Limit("z̄", rows, np.array([self.limit])),)
