"""Torque saturation: a joint at its limit pushes no harder; it yields, and the load moves to the other fingers.

    0 ≤ s^± ⟂ τ_max ∓ τ ≥ 0,    τ = Jᵀ r + g,    ε += J (s⁺ - s⁻)

Every joint with a limit has two: s⁺ is how far it is driven back at +τ_max, s⁻ at -τ_max, beyond what its spring gives
way. The gravity torque g counts when the fingers' weight does, and so does the torque of prescribed contact forces.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.limit import Limit
from handlcp.grasp.effects.needs import need_joints
from handlcp.grasp.effects.prescribed_force import PrescribedForce
from handlcp.grasp.joints import Joints
from handlcp.grasp.scene import Scene
from handlcp.tolerances import ACTIVE

__all__ = ["TorqueSaturation"]

_REACH = 1e-12  # of the longest lever: a joint with less moves no contact


@dataclass(frozen=True, eq=False)
class TorqueSaturation(Effect):
    """Asked for on a hand's grasp, which knows the joints: `state.grasp(..., effects=[TorqueSaturation()])`.

    joints : the hand's, once it has completed the effect. prescribed : (contact, (nv,) torque of its force [N·m]) for
    those whose force may be prescribed.
    """

    joints: Joints | None = field(default=None, init=False, repr=False)
    prescribed: tuple[tuple[int, Array], ...] = field(default=(), init=False, repr=False)

    title = "torque saturation"
    equation = "0 ≤ s^± ⟂ τ_max ∓ τ ≥ 0,  τ = Jᵀ r + g,  ε += J (s⁺ - s⁻)"
    when = "To see what still holds once a joint is at its torque limit and yields."
    in_python = "effects=[TorqueSaturation()]"
    in_file = "effects.torque_saturation = true"
    brings = "2 a limited joint"
    source = "joint by joint what Ai & Li (2025), equations (14) to (16), say of the sum of forces"

    def for_grasp(self, argument: str, n: int, joints: Joints | None, others: tuple[Effect, ...]) -> Self:
        """Completed by Jacobian, limits and the torques of prescribed forces."""
        joints = need_joints(argument, joints, self)
        known = [e for e in others if isinstance(e, PrescribedForce) and e.contact < n]
        given = [(e.contact, e.force @ joints.jacobian[3 * e.contact : 3 * e.contact + 3]) for e in known]
        made = type(self)()
        object.__setattr__(made, "joints", joints)
        object.__setattr__(made, "prescribed", tuple(given))
        return made

    @property
    def opens(self) -> bool:
        """Not without a limit."""
        return self.joints is None or bool(np.isfinite(self.joints.limits).any())

    def why(self, scene: Scene) -> str:
        """Asked for; how many joints have a limit."""
        joints, _, limited = self._known(scene)
        return f"asked for: {len(limited)} of {len(joints.names)} joints have a limit to reach"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """Both ways, of every joint that has a limit and moves a contact whose force is unknown."""
        joints, levers, k = self._known(scene)
        rows, given = (_jacobian(joints, scene).T * _unknown(scene))[k], self._given(joints, scene)[k]
        return (
            Limit("s⁺", rows, joints.limits[k] - given, levers[k]),
            Limit("s⁻", -rows, joints.limits[k] + given, levers[k]),
        )

    def read(self, scene: Scene, torque: Array, extra: dict[str, Array]) -> tuple[Array, Array]:
        """(nv,) torques of a certified answer, the very limit where a joint yields and none beyond it by rounding; and
        (nv,) s⁺ - s⁻ [rad, m] of all joints. NaN where there is no answer.
        """
        joints, levers, k = self._known(scene)
        total, yielded = torque.copy(), np.zeros(len(torque))
        if len(k):
            s = extra["s⁺"] - extra["s⁻"] if extra else np.full(len(k), np.nan)
            limits = joints.limits[k]
            moved = abs(s) * levers[k] > ACTIVE * scene.units.motion
            total[k] = np.where(moved, np.copysign(limits, s), np.clip(torque[k], -limits, limits))
            yielded[k] = np.where(moved | np.isnan(s), s, 0.0)
        return total, yielded

    def _given(self, joints: Joints, scene: Scene) -> Array:
        """(nv,) torques that do not depend on the unknown forces [N·m]."""
        given = joints.weight.copy()
        for contact, torque in self.prescribed:
            if not scene.governed[contact]:
                given += torque
        return given

    def _known(self, scene: Scene) -> tuple[Joints, Array, Ints]:
        """The joints; the length of each one's lever on the unknown forces [m] (1 for a prismatic joint); and which of
        them have a limit and such a lever.
        """
        assert self.joints is not None  # `for_grasp` saw to it
        unknown = np.concatenate([scene.normal_index, scene.tangent_index])
        levers = np.sqrt((_jacobian(self.joints, scene)[unknown] ** 2).sum(axis=0))
        limited = np.isfinite(self.joints.limits) & (levers > _REACH * levers.max(initial=0.0))
        return self.joints, levers, np.flatnonzero(limited)


def _jacobian(joints: Joints, scene: Scene) -> Array:
    """(c, nv) over the scene's force components, in contact axes."""
    return np.vstack([joints.jacobian, *(joints.turning[i] for i in scene.soft)]) if scene.soft else joints.jacobian


def _unknown(scene: Scene) -> Array:
    """(c,) what one of each component is in contact axes; 0 where the contact's force is prescribed."""
    unknown: Array = np.append(np.repeat(scene.governed_mask, 3).astype(float), np.ones(len(scene.soft)))
    return unknown if scene.scale is None else unknown * scene.scale
