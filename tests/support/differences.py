"""How contact points move with the joints: differences of the hand's tip placements, none of its Jacobians."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from tests.support.hand import configuration

STEP = 1e-3  # rad; fourth-order differences leave about 1e-13 of rounding and 1e-14 of truncation


def differences(f, q):
    """(…, nv) derivative of f at q, fourth order."""
    columns = []
    for j in range(len(q)):
        h = np.eye(len(q))[j] * STEP
        columns.append((8 * (f(q + h) - f(q - h)) - (f(q + 2 * h) - f(q - 2 * h))) / (12 * STEP))
    return np.moveaxis(np.array(columns), 0, -1)


class Kinematics:
    """Contact points that move with their fingertips, seen at one posture q of the hand; k of them."""

    def __init__(self, hand, q, names, points):
        self.hand, self.q, self.k = hand, q, len(names)
        self.tips = [hand.fingertips.index(name) for name in names]
        here = hand.at(q)
        self.local = [
            here.tip_rotations[t].T @ (p - here.tip_positions[t]) for t, p in zip(self.tips, points, strict=True)
        ]
        self.jacobian, self.turning = self.moves(q), self.turns(q)
        self.model = hand.model

    def points(self, q):
        """(k, 3) at another posture."""
        s = self.hand.at(q)
        pairs = zip(self.tips, self.local, strict=True)
        return np.array([s.tip_positions[t] + s.tip_rotations[t] @ a for t, a in pairs])

    def moves(self, q):
        """(k, 3, nv) Jacobian of the points."""
        return differences(self.points, q)

    def turns(self, q):
        """(k, 3, nv) angular velocity of the tips."""
        dR = differences(lambda x: self.hand.at(x).tip_rotations[self.tips], q)
        W = np.einsum("iabj,icb->iacj", dR, self.hand.at(q).tip_rotations[self.tips])  # R' Rᵀ, skew
        return np.stack([W[:, 2, 1], W[:, 0, 2], W[:, 1, 0]], axis=1)

    def weight(self, gravity):
        """(nv,) how the fingers' potential energy grows with q."""
        self.model.gravity.linear = gravity
        data = self.model.createData()

        def energy(x):
            return np.array(pin.computePotentialEnergy(self.model, data, configuration(self.hand, x)))

        return differences(energy, self.q)

    def bending(self, forces):
        """(nv, nv) ∂(Jᵀ f)/∂q of forces (k, 3) that stay as they are in the world."""
        return differences(lambda x: np.einsum("nbj,nb->j", self.moves(x), forces), self.q)


_SEEN: dict[tuple[str, bytes], Kinematics] = {}


def kinematics(grasp):
    """The same for a hand's springs and limits, whatever they are."""
    hand, q, k = grasp.state.hand, grasp.state.q, len(grasp.fingertips)
    points = np.array([c.position for c in grasp.contacts[:k]])
    key = (hand.name, q.tobytes() + points.tobytes())
    if key not in _SEEN:
        _SEEN[key] = Kinematics(hand, q, grasp.fingertips, points)
    return _SEEN[key]
