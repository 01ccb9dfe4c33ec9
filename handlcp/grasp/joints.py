"""What a hand tells the effects of its grasp about its joints; this room knows no robots."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from handlcp.check import Array

__all__ = ["Joints"]


@dataclass(frozen=True, slots=True, eq=False)
class Joints:
    """nv independent joints of the hand that grasps with n contacts.

    names : (nv,). jacobian : (3n, nv) velocity of the contact points in contact axes [m/rad, m/m].
    weight : (nv,) g(q), torque for the fingers' own weight, zero unless it counts [N·m, N].
    limits : (nv,) torque limits, inf where there is none or none is known [N·m, N].
    root : (nv, m) A of their compliance K⁻¹ = A Aᵀ [rad/(N·m)].
    hessian : makes (3n, nv, nv) ∂J/∂q for the few that ask, contact axes.
    turning : (nv,) how fast its fingertip turns about its normal [rad/rad], for each contact that may bear a moment.
    """

    names: tuple[str, ...]
    jacobian: Array
    weight: Array
    limits: Array
    root: Array
    hessian: Callable[[], Array]
    turning: dict[int, Array] = field(default_factory=dict)
