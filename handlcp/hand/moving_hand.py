"""A hand that moves while it grasps: its Jacobian and flexibility at contacts that stay where they are, compiled."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.model.effect import Effect
from handlcp.hand.elasticity.pads import tip_flexibility
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.robot.contact_jacobian import contact_jacobian


class MovingHand:
    """The hand of a stream; Pinocchio's data and what does not change are made once.

    q : (nv,) its posture. mechanism, effects : of the grasp; the Jacobian, and the torques of the fingers' weight, are
    buffers that `move` writes into. `fixed` copies the effects.
    """

    def __init__(self, mechanism: HandMechanism, effects: tuple[Effect, ...]) -> None:
        hand = mechanism.posture.hand
        kinematics = hand.kinematics
        self.hand, self.q = hand, mechanism.posture.q
        self.mechanism = replace(mechanism, jacobian=mechanism.jacobian.copy())
        self.effects = self.fixed(effects)
        self._weights = [e for e in self.effects if isinstance(e, FingerWeight)]  # one, or none
        self._model, self._data = kinematics.model, kinematics.model.createData()
        self._tips = mechanism.tips
        self._support = np.ascontiguousarray(hand.tips.support[list(self._tips), 0])
        self._coupling = np.empty((0, 0)) if kinematics.coupling is None else np.array(kinematics.coupling)

    def checked(self, q: Any) -> Array:
        """(nv,) from what users pass. Raises InputError, UnknownName."""
        return self.hand.kinematics.posture("q", q)

    def move(self, q: Array | None, positions: Array, frames: Array) -> Array:
        """Take the hand to q (None: it stays); returns E (3k, 3k) at its contacts, k of them, in contact axes."""
        self.q = self.q if q is None else q
        pin.computeJointJacobians(self._model, self._data, self.hand.kinematics.configuration(self.q))
        J = contact_jacobian(self._data.J.T, self._support, self._coupling, positions, frames)
        self.mechanism.jacobian[: len(J)] = J
        if q is not None:
            for weight in self._weights:
                weight.torque[:] = self.hand.kinematics.gravity_torque(q, self.mechanism.gravity)
        pads = self.hand.pads.in_axes(lambda: frames.transpose(0, 2, 1) @ self._tip_rotations(), self._tips)
        return tip_flexibility(J, self.mechanism.root, pads)

    def fixed(self, effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
        """The effects as they are now, with arrays of their own."""
        return tuple([replace(e, torque=e.torque.copy()) if isinstance(e, FingerWeight) else e for e in effects])

    def _tip_rotations(self) -> Array:
        """(k, 3, 3) from tip axes to world axes, where the hand is now."""
        pin.updateFramePlacements(self._model, self._data)
        return np.array([self._data.oMf[self.hand.tips.frames[t]].rotation for t in self._tips])
