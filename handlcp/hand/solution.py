"""What a hand's grasp answers: a `GraspSolution`, and what its joints have to do for it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from handlcp.actuation.joint_stiffness import TENDON_TENSION, Effort
from handlcp.check import Array
from handlcp.grasp.failure.failure_text import describe_torque_excess
from handlcp.grasp.solution.solution import GraspSolution, format_solution
from handlcp.hand.torque_check import TorqueCheck
from handlcp.record import columns_from_arrays


@dataclass(frozen=True, kw_only=True)
class HandGraspSolution(GraspSolution):
    """A `GraspSolution` with what the joints have to do; NaN where there is no answer.

    torques : (nv,) τ = Jᵀ f that the actuators hold [N·m], plus g(q) when the fingers' weight was asked for, and what
        holds springs of the file beside its actuators, k (q - springref). With `GeometricStiffness` those of the
        deflected posture, to first order: K_g (δq - joint_deflection) more.
    joint_deflection : (nv,) K⁻¹ Jᵀ f [rad], how far the joints give way to the grasp forces, and to the fingers' own
        weight where that is part of the elastic balance, from where they are commanded to be. With
        `GeometricStiffness` (K + K_g)⁻¹ (Jᵀ f + g + K_g δq), δq as commanded.
    joint_yield : (nv,) [rad] how far joints at their limit are driven back beyond that (`TorqueSaturation`): s⁺ - s⁻,
        with the sign of the torque; 0 for all others. Such a joint's torque is its limit.
    torque_check : joint by joint torque, limit, utilisation, and the binding joint.
    effort : what the tendons or synergies of the hand do for these torques, by name; None where it has neither.
    """

    torques: Array
    joint_deflection: Array
    joint_yield: Array
    torque_check: TorqueCheck
    effort: Effort | None

    @cached_property
    def diagnosis(self) -> str:
        """As in `GraspSolution`, and which joints that would ask for more than they have."""
        text, over = super().diagnosis, self.torque_check.over
        if not self.held or not over:
            return text
        most = max(r.utilisation for r in over)
        return f"{text}; but {describe_torque_excess([r.joint for r in over])}, up to {most:.3g} ×"

    @property
    def tendon_tension(self) -> Array | None:
        """(t,) k R K⁻¹ τ [N], how much harder each tendon pulls (below 0: less); None without `Tendons`."""
        return self.effort.values if self.effort is not None and self.effort.kind == TENDON_TENSION else None

    @property
    def actuator_force(self) -> Array | None:
        """(k,) η = Sᵀ τ [N·m where S has no unit] that each synergy's actuator holds; None without `Synergies`."""
        return self.effort.values if self.effort is not None and self.effort.kind == "actuator force" else None

    @property
    def utilisation(self) -> Array:
        """(nv,) |torque| / limit of each joint, 0 where there is no limit or none is known; as in `torque_check`."""
        return self.torque_check.utilisation

    @property
    def torque_margin(self) -> Array:
        """(nv,) N·m, how much more torque each joint has, below 0 where it would need more than it has; inf where there
        is no limit or none is known.
        """
        return self.torque_check.margin

    def _tables(self) -> dict[str, tuple[dict[str, Any], list[str]]]:
        lines = "torque_Nm", "limit_Nm", "utilisation", "margin_Nm"
        joints = columns_from_arrays(self.torque_check, *lines) | {"yield_rad": self.joint_yield}
        return super()._tables() | {"joints": (joints, list(self.torque_check.joints))}

    def __str__(self) -> str:
        return format_solution(self, [self.torque_check.table, *([] if self.effort is None else [self.effort])])
