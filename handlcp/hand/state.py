"""The hand in one posture: tip placements, Jacobians and flexibility, as values that nothing changes any more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.hand.place import grasp as _grasp

if TYPE_CHECKING:
    from handlcp.hand.hand import Hand

__all__ = ["HandState"]

# Rows of v + ω × p as a linear map of the world Jacobian (v; ω): three rows of v, then those that x, y and z of p
# multiply.
_SPREAD = np.zeros((12, 6))
_SPREAD[:3, :3] = np.eye(3)
_SPREAD[[4, 5], [5, 4]] = 1.0, -1.0  # x: (0, ω_z, -ω_y)
_SPREAD[[6, 8], [5, 3]] = -1.0, 1.0  # y: (-ω_z, 0, ω_x)
_SPREAD[[9, 10], [4, 3]] = 1.0, -1.0  # z: (ω_y, -ω_x, 0)
_set = object.__setattr__


class HandState:
    """A posture of a hand: immutable, all arrays read-only, world axes, metres and radians. Made by `hand.at(q)`.

    q : (nv,) independent joint positions.
    tip_positions : (n, 3). tip_rotations : (n, 3, 3), columns the tip frame's axes.
    jacobian : (3n, nv) velocity of the tip origins in world axes (Pinocchio's LOCAL_WORLD_ALIGNED), tip by tip.
    flexibility : (3n, 3n) E = J K⁻¹ Jᵀ + pads [m/N], the displacement of the tips in world axes under forces on them.
    """

    __slots__ = ("_flexibility", "_jacobian", "_spread", "hand", "q", "tip_positions", "tip_rotations")

    hand: Hand
    q: Array
    tip_positions: Array
    tip_rotations: Array
    _spread: Array
    _jacobian: Array
    _flexibility: Array

    def __init__(self, hand: Hand, q: Array, placements: Array, columns: Array) -> None:
        """From `Hand.at`: placements (n, 4, 4) of the tips, columns (6, joints) of the world Jacobian, linear part
        first.
        """
        placements.flags.writeable = False
        _set(self, "hand", hand)
        _set(self, "q", q)
        _set(self, "tip_positions", placements[:, :3, 3])
        _set(self, "tip_rotations", placements[:, :3, :3])
        _set(self, "_spread", (_SPREAD @ columns).reshape(4, -1))

    @property
    def jacobian(self) -> Array:
        """(3n, nv) translational Jacobian of the tip origins, world axes."""
        if not hasattr(self, "_jacobian"):
            J = self.jacobian_at(self.tip_positions, self.hand.tips.every)
            self._jacobian = read_only(J.reshape(-1, self.hand.nv))
        return self._jacobian

    @property
    def flexibility(self) -> Array:
        """(3n, 3n) symmetric positive semidefinite flexibility at the tips [m/N], world axes, the pads included."""
        if not hasattr(self, "_flexibility"):
            E = self.hand.stiffness.compliance(self.jacobian)
            self.hand.pads.add_to(E, self.tip_rotations, self.hand.tips.every)
            self._flexibility = read_only(E)
        return self._flexibility

    def jacobian_at(self, points: Array, tips: Sequence[int]) -> Array:
        """(m, 3, nv) Jacobian of points (m, 3) that move rigidly with the tips numbered `tips`: v + ω × p, joint by
        joint.
        """
        spread, hand = self._spread, self.hand
        J = (points @ spread[1:] + spread[0]).reshape(len(points), 3, -1)
        J *= hand.tips.support if tips is hand.tips.every else hand.tips.support[list(tips)]
        coupling = hand.kinematics.coupling
        return J if coupling is None else np.asarray(J @ coupling)

    def turning(self, tips: Sequence[int]) -> Array:
        """(m, 3, nv) angular Jacobian of the tips numbered `tips`, world axes [rad/rad]."""
        spread, hand = self._spread.reshape(4, 3, -1), self.hand
        J = np.stack([spread[2, 2], -spread[1, 2], spread[1, 1]]) * hand.tips.support[list(tips)]
        coupling = hand.kinematics.coupling
        return np.asarray(J if coupling is None else J @ coupling)

    def gravity_torque(self, gravity: Any = (0.0, 0.0, -9.81)) -> Array:
        """(nv,) torque g(q) that holds the fingers' own weight [N·m], over the independent joints; gravity (3,)
        [m/s²] world axes.
        """
        return self.hand.kinematics.gravity_torque(self.q, array("gravity", gravity, (3,)))

    grasp = _grasp

    def __setattr__(self, name: str, value: object) -> None:
        """Everything is set once."""
        if hasattr(self, name):
            raise AttributeError(f"a HandState is immutable: {name} cannot be set")
        _set(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as the call that made it."""
        return (_again, (self.hand, self.q))

    def __repr__(self) -> str:
        """Name and posture."""
        return f"HandState({self.hand.name!r}, q={np.round(self.q, 4).tolist()})"


def _again(hand: Hand, q: Array) -> HandState:
    return hand.at(q)
