"""The paper's bound on the sum of normal forces: at the bound, the hand opens instead of squeezing harder.

    0 ≤ z̄ ⟂ r̄ - Σ r_N ≥ 0,    ε_N += z̄ for every finger

It is the hand's squeeze that is bounded: contacts of the environment are not in the sum, and z̄ does not open them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, number
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.limit import Above0, FileKey, Limit
from handlcp.grasp.model.scene import Scene
from handlcp.keywords import helped_init
from handlcp.words import NOTHING, length


@helped_init()
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
    order = 210
    file_key = FileKey(
        "total_force_bound_N", Above0, "a number > 0 (inf: no bound)", "the most that all normal forces may add up to"
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "limit", number("TotalForceBound.limit", self.limit, above=0.0, finite=False))

    def why(self, scene: Scene) -> str:
        return f"asked for: Σ r_N ≤ {self.limit:g} N"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """One, of all normal forces; z̄ is the opening common to all fingers. An infinite bound is none."""
        if not np.isfinite(self.limit):
            return ()
        rows = np.zeros((1, scene.components))
        rows[0, scene.kind.normal_index] = 1.0
        rows[0, 3 * (scene.n - scene.environment) :] = 0.0
        return (Limit("z̄", rows, np.array([self.limit])),)

    def words(self, scene: Scene, names: tuple[str, ...], extra: dict[str, Array]) -> Iterable[str]:
        if (opened := float(extra.get("z̄", np.zeros(1))[0])) > NOTHING:
            yield f"the {self.title} is reached and gives way by {length(opened)}"

    def shortfall(self, least_total: float | None) -> str | None:
        if least_total is None or not least_total > 1.001 * self.limit:  # so that the two numbers differ in print
            return None
        return f"the total normal force is bounded to {self.limit:.4g} N, and balance needs {least_total:.4g} N"
