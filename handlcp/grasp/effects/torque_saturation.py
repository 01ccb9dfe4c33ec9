"""Torque saturation: a joint at its limit pushes no harder; it yields, and the load moves to the other fingers.

    0 ≤ s^± ⟂ τ_max ∓ τ ≥ 0,    τ = Jᵀ r + g,    ε += J (s⁺ - s⁻)

Every joint with a limit has two: s⁺ is how far it is driven back at +τ_max, s⁻ at -τ_max, beyond what its spring gives
way. The gravity torque g counts when the fingers' weight does, and so does the torque of prescribed contact forces.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.effect import Effect, Trial
from handlcp.grasp.model.kind import Placement
from handlcp.grasp.model.limit import FileKey, Limit
from handlcp.grasp.model.mechanism import JointReading, Mechanism
from handlcp.grasp.model.scene import Scene
from handlcp.keywords import helped_init
from handlcp.tolerances import ACTIVE, OVER

_REACH = 1e-12  # of the longest lever: a joint with less moves no contact


@helped_init()
@dataclass(frozen=True, eq=False)
class TorqueSaturation(Effect):
    """Asked for on a hand's grasp, which knows the joints: `state.grasp(..., effects=[TorqueSaturation()])`."""

    title = "torque saturation"
    equation = "0 ≤ s^± ⟂ τ_max ∓ τ ≥ 0,  τ = Jᵀ r + g,  ε += J (s⁺ - s⁻)"
    when = "To see what still holds once a joint is at its torque limit and yields."
    in_python = "effects=[TorqueSaturation()]"
    in_file = "effects.torque_saturation = true"
    brings = "2 a limited joint"
    source = "joint by joint what Ai & Li (2025), equations (14) to (16), say of the sum of forces"
    order = 230
    needs_joints = True
    called = "joints' torque limits"
    file_key = FileKey(
        "torque_saturation",
        bool,
        "true or false",
        "joints at their torque limit yield, and the load moves to the other fingers; a scene with a [hand]",
        default=False,
    )

    @classmethod
    def trial(cls, at: Placement, others: tuple[Effect, ...], forces: Array, torque: Array) -> Trial | None:
        """Where a joint is asked for more than it has."""
        if at.mechanism is None or any(e.depends_on_forces for e in others):
            return None
        used = abs(torque) / at.mechanism.limits
        worst = int(used.argmax())
        if used[worst] > 1.0 + OVER:
            words = f"{at.mechanism.names[worst]} at {100 * used[worst]:.3g} % of its limit"
            return Trial(cls(), float(used[worst]) - 1.0, words)
        if not np.isfinite(at.mechanism.limits).any():
            return None
        return Trial(None, 0.0, f"all joints within their limits, {used.max():.0%} at most")

    def why(self, scene: Scene) -> str:
        joints, _, limited = self.limited(scene)
        return f"asked for: {len(limited)} of {len(joints.names)} joints have a limit to reach"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """Both ways, of every joint that has a limit and moves a contact whose force is unknown."""
        joints, levers, k = self.limited(scene)
        known = np.repeat(~scene.governed_mask, 3)
        rows = joints.rows(scene.soft).T[k].copy()
        rows[:, : 3 * scene.n][:, known] = 0.0
        rows = scene.physical(rows)
        given = scene.held_torque[k]
        if scene.prescribed is not None:
            given = given + (scene.physical(scene.prescribed)[: 3 * scene.n] @ joints.jacobian)[k]
        return (
            Limit("s⁺", rows, joints.limits[k] - given, levers[k]),
            Limit("s⁻", -rows, joints.limits[k] + given, levers[k]),
        )

    def read(self, scene: Scene, forces: Array, extra: dict[str, Array], joints: JointReading) -> JointReading:
        """How far joints yield, and torques that are the very limit where they do: none beyond it by rounding."""
        hand, levers, k = self.limited(scene)
        if not len(k):
            return joints
        total, yielded, limits = joints.torque.copy(), np.zeros(len(joints.torque)), hand.limits[k]
        s = extra["s⁺"] - extra["s⁻"] if extra else np.full(len(k), np.nan)
        moved = abs(s) * levers[k] > ACTIVE * scene.units.motion
        total[k] = np.where(moved, np.copysign(limits, s), np.clip(total[k], -limits, limits))
        yielded[k] = np.where(moved | np.isnan(s), s, 0.0)
        return replace(joints, torque=total, yielded=yielded)

    def limited(self, scene: Scene) -> tuple[Mechanism, Array, Ints]:
        """The joints; the length of each one's lever on the unknown forces [m] (1 for a prismatic joint); and which of
        them have a limit and such a lever.
        """
        joints = scene.mechanism
        assert joints is not None  # `needs_joints` saw to it
        levers = np.sqrt((joints.rows(scene.soft)[scene.kind.index] ** 2).sum(axis=0))
        limited = np.isfinite(joints.limits) & (levers > _REACH * levers.max(initial=0.0))
        return joints, levers, np.flatnonzero(limited)
