"""A hand that moves while it grasps: its Jacobian and flexibility at contacts that stay where they are, compiled."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.hand.elasticity.pads import add_pads
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.robot.contact_jacobian import contact_jacobian

__all__ = ["MovingHand"]


class MovingHand:
    """The hand of a stream; Pinocchio's data and what does not change are made once.

    q : (nv,) its posture. mechanism : of the grasp, with the Jacobian as it is now. still : how many contacts are the
    environment's, which no joint moves.
    """

    def __init__(self, mechanism: HandMechanism, still: int) -> None:
        hand = mechanism.posture.hand
        kinematics = hand.kinematics
        self.hand, self.q, self.mechanism = hand, mechanism.posture.q, mechanism
        self._model, self._data = kinematics.model, kinematics.model.createData()
        self._tips = list(mechanism.tips)
        self._support = np.ascontiguousarray(hand.tips.support[self._tips, 0])
        self._coupling = np.empty((0, 0)) if kinematics.coupling is None else np.array(kinematics.coupling)
        self._still = np.zeros((3 * still, hand.nv))

    def checked(self, q: Any) -> Array:
        """(nv,) from what users pass. Raises InputError, UnknownName."""
        return self.hand.kinematics.posture("q", q)

    def move(self, q: Array | None, positions: Array, frames: Array) -> Array:
        """Take the hand to q (None: it stays); returns E (3k, 3k) at its contacts, k of them, in contact axes."""
        self.q = self.q if q is None else q
        pin.computeJointJacobians(self._model, self._data, self.hand.kinematics.configuration(self.q))
        J = contact_jacobian(self._data.J.T, self._support, self._coupling, positions, frames)
        E = joint_flexibility(J, self.mechanism.root)
        add_pads(E, self._pads(frames))
        self.mechanism = replace(self.mechanism, jacobian=np.concatenate([J, self._still]) if len(self._still) else J)
        return E

    def weighed(self, effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
        """The effects, with the fingers' weight in this posture."""
        gravity, kinematics = self.mechanism.gravity, self.hand.kinematics
        return tuple(
            [
                replace(e, torque=kinematics.gravity_torque(self.q, gravity)) if isinstance(e, FingerWeight) else e
                for e in effects
            ]
        )

    def _pads(self, frames: Array) -> Array:
        """(k, 3, 3) in contact axes."""
        pads, turn = self.hand.pads, frames
        if not pads.isotropic:
            pin.updateFramePlacements(self._model, self._data)
            tips = [self._data.oMf[self.hand.tips.frames[t]].rotation for t in self._tips]
            turn = frames.transpose(0, 2, 1) @ np.array(tips)
        return pads.in_axes(turn, self._tips)
