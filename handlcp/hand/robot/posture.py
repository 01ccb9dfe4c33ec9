"""A hand in one posture: where its fingertips are, how its joints move them, and how they give way under forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, array, integer, read_only, several
from handlcp.errors import InputError
from handlcp.hand.elasticity.stiffness import tip_flexibility
from handlcp.hand.robot.model import HandModel
from handlcp.keywords import helped_methods
from handlcp.lazy import lazy
from handlcp.tolerances import LARGEST

GRAVITY = (0.0, 0.0, -9.81)  # m/s², world axes
_ACCELERATION = "an acceleration [m/s²], such as (0, 0, -9.81) or (0, 0, 0): finite numbers"


def read_gravity(value: Any) -> Array:
    """(3,) [m/s²] as a user gives it, world axes. Raises InputError, which offers a vector for a size alone."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and 0.0 < abs(value) <= LARGEST:
        came = f"{value:g} (is (0, 0, {-abs(value):g}) meant?)"
        raise InputError("gravity", f"{_ACCELERATION} of shape (3,)", came)
    return array("gravity", value, (3,), what=_ACCELERATION)


# A joint moves a point p = (x, y, z) of its finger by v + ω × p = v + x a + y b + z c. `_SPREAD` maps (v; ω) to
# (v; a; b; c).
_SPREAD = np.zeros((12, 6))
_SPREAD[:3, :3] = np.eye(3)
_SPREAD[[4, 5], [5, 4]] = 1.0, -1.0  # a = (0, ω_z, -ω_y)
_SPREAD[[6, 8], [5, 3]] = -1.0, 1.0  # b = (-ω_z, 0, ω_x)
_SPREAD[[9, 10], [4, 3]] = 1.0, -1.0  # c = (ω_y, -ω_x, 0)


@helped_methods
class Posture:
    """Immutable; all arrays read-only, world axes, metres and radians.

    q : (nv,) positions of the independent joints.
    tip_positions : (n, 3). tip_rotations : (n, 3, 3), columns the tip frame's axes.
    jacobian : (3n, nv) velocity of the tip origins in world axes (Pinocchio's LOCAL_WORLD_ALIGNED), tip by tip.
    flexibility : (3n, 3n) E = J K⁻¹ Jᵀ + pads [m/N], the displacement of the tips in world axes under forces on them.
    """

    hand: HandModel
    q: Array
    tip_positions: Array
    tip_rotations: Array
    _spread: Array

    def __init__(self, hand: HandModel, q: Array) -> None:
        hand = hand.posed(q)
        placements, columns = hand.kinematics.frames_at(q, hand.tips.frames)
        placements.flags.writeable = False
        self.__dict__.update(hand=hand, q=read_only(q), _spread=np.dot(_SPREAD, columns).reshape(4, -1))
        self.__dict__.update(tip_positions=placements[:, :3, 3], tip_rotations=placements[:, :3, :3])

    @lazy
    def jacobian(self) -> Array:
        """(3n, nv) translational Jacobian of the tip origins, world axes."""
        J = self.jacobian_at(self.tip_positions, self.hand.tips.every)
        return read_only(J.reshape(-1, self.hand.nv))

    @lazy
    def flexibility(self) -> Array:
        """(3n, 3n) symmetric positive semidefinite flexibility at the tips [m/N], world axes, the pads included."""
        pads = self.hand.pads.in_axes(lambda: self.tip_rotations, self.hand.tips.every)
        return read_only(tip_flexibility(self.jacobian, self.hand.stiffness.root, pads))

    def jacobian_at(self, points: Array, tips: tuple[int, ...]) -> Array:
        """(…, m, 3, nv) Jacobian v + ω × p of points (…, m, 3) that move with the tips numbered `tips`, world axes."""
        tips, at = self._tips(tips), array("points", points)
        if at.ndim < 2 or at.shape[-2:] != (len(tips), 3):
            raise InputError("points", f"finite numbers of shape (…, {len(tips)}, 3)", f"shape {at.shape}")
        J = np.dot(at, self._spread[1:]) + self._spread[0]
        return self._independent(J.reshape(*at.shape[:-1], 3, -1), tips)

    def turning(self, tips: tuple[int, ...]) -> Array:
        """(m, 3, nv) angular Jacobian of the tips numbered `tips`, world axes [rad/rad]. Raises InputError."""
        tips = self._tips(tips)
        _, a, b, _ = self._spread.reshape(4, 3, -1)
        omega = np.stack([b[2], -a[2], a[1]])
        return self._independent(np.tile(omega, (len(tips), 1, 1)), tips)

    def gravity_torque(self, gravity: Any = (0.0, 0.0, -9.81)) -> Array:
        """(nv,) torque g(q) that holds the fingers' own weight [N·m]; gravity (3,) [m/s²], world axes."""
        return self.hand.kinematics.gravity_torque(self.q, read_gravity(gravity))

    def _tips(self, tips: Any) -> tuple[int, ...]:
        """Numbers of fingertips. Raises InputError."""
        every = self.hand.tips.every
        if isinstance(tips, tuple) and tips == every:
            return every
        given = several("tips", tips, "numbers of fingertips")
        return tuple([integer(f"tips[{k}]", tip, 0, len(every) - 1) for k, tip in enumerate(given)])

    def _independent(self, J: Array, tips: tuple[int, ...]) -> Array:
        """(m, 3, nv) from columns (m, 3, joints): 0 where a joint moves no tip; mimic joints added to their masters."""
        support, coupling = self.hand.tips.support, self.hand.kinematics.coupling
        J *= support if tips == self.hand.tips.every else support[list(tips)]
        return J if coupling is None else np.asarray(J @ coupling)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a {type(self).__name__} is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self.hand, self.q))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.hand.name!r}, q={np.round(self.q, 4).tolist()})"


# ----------------------------------------------------------------
# How the Jacobian of contact points changes with the joints.
#
# ∂J_j/∂q_i = ω_i × J_j  where joint i carries joint j or is it,  J_j = v_j + ω_j × p;  symmetric in i and j
#
# J_j is the motion of a point p of the finger under joint j; turning joint i turns all of it, point, axis and motion. A
# slide (ω_i = 0) turns nothing. The columns (v_j; ω_j) are Pinocchio's, in the world frame: a joint is carried by those
# of its finger with smaller numbers. Mimic joints q_full = C q + offset give Cᵀ (…) C. Source: Featherstone, Rigid Body
# Dynamics Algorithms (2008), chapter 2, derivatives of vectors that move with a body.


def contact_hessian(state: Posture, tips: Sequence[int], positions: Array, frames: Array) -> Array:
    """(3n, nv, nv) ∂J/∂q [m/rad²] of points (n, 3) [m] on the tips numbered `tips`, in frames (n, 3, 3) that stay."""
    hand = state.hand
    _, columns = hand.kinematics.frames_at(state.q, ())
    v, w = columns[:3].T, columns[3:].T  # (joints, 3)
    motion = (v + np.cross(w, positions[:, None])) * hand.tips.support[list(tips)].transpose(0, 2, 1)
    first, last = np.triu_indices(len(w))  # pairs of which the first, on one finger, carries the last
    turned = np.cross(w[first], motion[:, last]) * hand.tips.support[list(tips), 0][:, first, None]
    world = np.zeros((len(positions), len(w), len(w), 3))
    world[:, first, last] = world[:, last, first] = turned
    H = np.einsum("nxc,njkx->ncjk", frames, world)
    C = hand.kinematics.coupling
    if C is not None:
        H = C.T @ H @ C
    return np.asarray(H.reshape(-1, *H.shape[2:]))
