"""`FingerWeight` and `TorqueSaturation`: the fingers' own weight, and joints that yield at their torque limits.

The fingers' own weight: torques that hold it, and joints that sag under it before anything is loaded.

    τ = Jᵀ f + g(q),    d += J K⁻¹ g(q)

g(q) is the torque that holds the links in the posture q. A joint of stiffness K that is told to be at q holds it by
giving way: it ends at q - K⁻¹ g, its fingertip J K⁻¹ g lower, so that the object lies that far off, seen from the tip.
The same K⁻¹ (Jᵀ f + g) is the deflection of the joints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from handlcp.check import Array, Ints, check_init_call
from handlcp.contact.friction import Section
from handlcp.grasp.model.contact import Placement
from handlcp.grasp.model.effect import Effect, EffectTrial, FileKey, Limit
from handlcp.grasp.model.mechanism import JointReading, Mechanism
from handlcp.grasp.model.scene import Scene
from handlcp.tolerances import ACTIVE_TOLERANCE, OVER_LIMIT_TOLERANCE


@dataclass(frozen=True, eq=False)
class FingerWeight(Effect):
    """Asked for with `finger_weight=True` or `"torques"` of `state.grasp`.

    torque : (nv,) g(q) [N·m]. sags : whether the joints give way to it, because the posture is the one commanded.
    """

    torque: Array
    sags: bool = True

    title = "finger weight"
    equation = "τ += g(q),  d += J K⁻¹ g(q)"
    when = "Fingers heavy beside what they hold, or joints soft enough to sag."
    in_python = "finger_weight=True"
    in_file = "grasp.finger_weight = true"
    brings = "none: data"
    source = "Siciliano et al., Robotics (2009), chapter 7"
    order = 110
    needs_joints = True
    by_name = False

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """Only a hand has fingers that weigh anything."""
        return None if scene.mechanism is None else "not asked for"

    @classmethod
    def trial(cls, at: Placement, others: tuple[Effect, ...], forces: Array, torque: Array) -> EffectTrial | None:
        """In torques and elastic balance, where gravity was given."""
        weight = None if at.mechanism is None else at.mechanism.gravity_torque()
        if weight is None or any(e.depends_on_forces for e in others):
            return None
        k = int(abs(weight).argmax())
        share = float(abs(weight[k])) / (float(abs(torque).max()) or 1.0)
        words = f"{100 * share:.2g} % of the largest torque, at {at.mechanism.names[k]}"  # type: ignore[union-attr]
        return EffectTrial(cls(weight), share, words, instead=True)

    def why(self, scene: Scene) -> str:
        why = f"asked for: up to {abs(self.torque).max(initial=0.0):.3g} N·m in a joint"
        if not self.sags:
            return f"{why}; the posture has sagged already"
        assert scene.mechanism is not None  # `needs_joints` saw to it
        tips = (scene.mechanism.jacobian @ scene.mechanism.deflection(self.torque)).reshape(-1, 3)
        moved = float(np.sqrt((tips * tips).sum(axis=1)).max(initial=0.0))
        return f"{why}, a fingertip sags by up to {moved:.3g} m"

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """How far the object lies off the tips that sag away from it."""
        if not self.sags:
            return None
        assert at.mechanism is not None
        return np.asarray(at.mechanism.jacobian_rows(soft) @ at.mechanism.deflection(self.torque))

    def added_torque(self) -> Array | None:
        """g(q), which the actuators hold."""
        return self.torque

    def read(self, scene: Scene, forces: Array, extra: dict[str, Array], joints: JointReading) -> JointReading:
        """Add to the joints' deflection how far they sag under the fingers' weight."""
        if not self.sags or scene.mechanism is None:
            return joints
        return replace(joints, deflection=joints.deflection + scene.mechanism.deflection(self.torque))


# ----------------------------------------------------------------
# Torque saturation: a joint at its limit pushes no harder; it yields, and the load moves to the other fingers.
#
#     0 ≤ s^± ⟂ τ_max ∓ τ ≥ 0,    τ = Jᵀ r + g,    ε += J (s⁺ - s⁻)
#
# Every joint with a limit has two: s⁺ is how far it is driven back at +τ_max, s⁻ at -τ_max, beyond what its spring
# gives way. The gravity torque g counts when the fingers' weight does, and so does the torque of prescribed contact
# forces.


_MIN_LEVER_SHARE = 1e-12  # of the longest lever: a joint with less moves no contact


@check_init_call()
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
    def trial(cls, at: Placement, others: tuple[Effect, ...], forces: Array, torque: Array) -> EffectTrial | None:
        """Where a joint is asked for more than it has."""
        if at.mechanism is None or any(e.depends_on_forces for e in others):
            return None
        used = abs(torque) / at.mechanism.limits
        worst = int(used.argmax())
        if used[worst] > 1.0 + OVER_LIMIT_TOLERANCE:
            words = f"{at.mechanism.names[worst]} at {100 * used[worst]:.3g} % of its limit"
            return EffectTrial(cls(), float(used[worst]) - 1.0, words)
        if not np.isfinite(at.mechanism.limits).any():
            return None
        return EffectTrial(None, 0.0, f"all joints within their limits, {used.max():.0%} at most")

    def why(self, scene: Scene) -> str:
        joints, _, limited = self.limited(scene)
        return f"asked for: {len(limited)} of {len(joints.names)} joints have a limit to reach"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """Both ways, of every joint that has a limit and moves a contact whose force is unknown."""
        joints, levers, k = self.limited(scene)
        known = np.repeat(~scene.force_unknown_mask, 3)
        rows = joints.jacobian_rows(scene.soft).T[k].copy()
        rows[:, : 3 * scene.n][:, known] = 0.0
        rows = scene.rows_to_law_axes(rows)
        given = scene.bias_torque_or_zero[k]
        if scene.prescribed is not None:
            given = given + (scene.forces_to_contact_axes(scene.prescribed)[: 3 * scene.n] @ joints.jacobian)[k]
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
        moved = abs(s) * levers[k] > ACTIVE_TOLERANCE * scene.units.motion_unit
        total[k] = np.where(moved, np.copysign(limits, s), np.clip(total[k], -limits, limits))
        yielded[k] = np.where(moved | np.isnan(s), s, 0.0)
        return replace(joints, torque=total, yielded=yielded)

    def limited(self, scene: Scene) -> tuple[Mechanism, Array, Ints]:
        """The joints; the length of each one's lever on the unknown forces [m] (1 for a prismatic joint); and which of
        them have a limit and such a lever.
        """
        joints = scene.mechanism
        assert joints is not None  # `needs_joints` saw to it
        levers = np.sqrt((joints.jacobian_rows(scene.soft)[scene.kind.index] ** 2).sum(axis=0))
        limited = np.isfinite(joints.limits) & (levers > _MIN_LEVER_SHARE * levers.max(initial=0.0))
        return joints, levers, np.flatnonzero(limited)
