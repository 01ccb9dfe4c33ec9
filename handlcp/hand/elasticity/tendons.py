"""Tendons: elastic cables over several joints, usually fewer of them than joints.

    l = R q,    K = K_p + Rᵀ k R,    τ = Rᵀ t + K_p δq,    t = k R δq

l is the length by which each tendon is drawn in when the joints are at q, and R holds the moment arms. k is the
stiffness of the tendons, K_p that of the springs at the joints. Under joint torques τ the joints deflect by
δq = K⁻¹ τ, which stretches the tendons by R δq and raises their tension by t. A tendon over several joints couples
them; one over two fingers is a differential. As k → ∞ the joints can only move such that R δq = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, array, number, per_name, psd, read_only
from handlcp.errors import InputError
from handlcp.grasp.analysis.explanation import Description
from handlcp.hand.elasticity.actuators import given_rows, read_rows, read_springs
from handlcp.hand.elasticity.elasticity import TRANSMISSION, Effort, Transmission, spanned
from handlcp.hand.elasticity.stiffness import JointStiffness, springs
from handlcp.tolerances import SEMIDEFINITE

TENDONS = Description(
    title=f"{TRANSMISSION}: tendons",
    equation="K = K_p + Rᵀ k R,  t = k R δq",
    when="Fewer cables than joints, a cable over several joints, a differential between fingers.",
    in_python='joint_stiffness=Tendons({"pull": {"finger_1_distal": 0.01, "finger_2_distal": 0.01}}, 2e4, 4.0)',
    in_file="[hand.tendons]\n"
    "moment_arms_m = { pull = { finger_1_distal = 0.01, finger_2_distal = 0.01 } }\n"
    "stiffness_N_per_m = 2e4\n"
    "passive_Nm_per_rad = 4.0",
    brings="none: part of K",
    source="Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation (1994), section 6.4",
    module=__name__,
)

_SHARE = 0.1  # of the largest motion: joints that move less are not named as loose
_tendon_spring = partial(number, above=0.0)
_passive_spring = partial(number, minimum=0.0, finite=False)


@dataclass(frozen=True, eq=False)
class Tendons(Transmission):
    """Pass it as a hand's `joint_stiffness`.

    moment_arms : (t, nv) R [m/rad, m/m] over the hand's joints, or a mapping of tendon names to mappings of joint names
        to arms (joints left out: 0). A positive arm: pulling the tendon turns the joint to larger angles.
    stiffness : k [N/m] a number, (t,), a mapping by tendon name, or an SPD matrix (t, t).
    passive : springs at the joints themselves [N·m/rad]: a number ≥ 0, a mapping by joint name (joints left out: 0),
        (nv,), or a positive semidefinite matrix (nv, nv); numpy.inf: that joint is rigid.

    Tendons are assumed taut: one that would go slack still acts as a spring.
    Raises InputError, UnknownName; also when a hand is made with it, where K is singular: the error names the joints
    that no spring drives back.
    """

    moment_arms: Any
    stiffness: Any
    passive: Any = 0.0

    def __post_init__(self) -> None:
        """Check what does not depend on the joints."""
        arms = given_rows("Tendons.moment_arms", self.moment_arms)
        object.__setattr__(self, "moment_arms", arms)
        if not isinstance(self.stiffness, Mapping):
            numbers = [str(i) for i in range(len(arms))]
            read_springs("Tendons.stiffness", self.stiffness, "tendon", numbers, _tendon_spring)

    def for_joints(self, joints: Sequence[str]) -> TendonStiffness:
        """K over these joints."""
        names, R = read_rows("Tendons.moment_arms", self.moment_arms, "tendon", joints)
        k = read_springs("Tendons.stiffness", self.stiffness, "tendon", names, _tendon_spring)
        K = _passive("Tendons.passive", self.passive, joints).copy()
        rigid = np.isinf(np.diagonal(K))
        through = R.T @ k @ R
        through[rigid] = through[:, rigid] = 0.0  # no load reaches the tendons through a rigid joint
        K += (through + through.T) / 2
        _check_sprung(K, rigid, joints)
        return TendonStiffness(K, names, R, k)


class TendonStiffness(JointStiffness):
    """K = K_p + Rᵀ k R, and the tendons behind it: names (t,), arms R (t, nv), springs k (t, t)."""

    def __init__(self, matrix: Array, names: tuple[str, ...], arms: Array, springs: Array) -> None:
        super().__init__(matrix)
        self.names, self.arms, self.springs = names, arms, springs

    @property
    def commands(self) -> Array:
        """K⁻¹ Rᵀ: where the springs let the joints go when a tendon is drawn in."""
        return spanned(self.root @ (self.arms @ self.root).T)

    def effort(self, torque: Array) -> Effort:
        """The tension t = k R K⁻¹ τ [N]: how much harder each tendon pulls; below 0 it pulls less."""
        tension = self.springs @ (self.arms @ self.deflection(torque))
        return Effort("tendon tension", "N", self.names, read_only(tension))

    @property
    def law(self) -> tuple[str, str]:
        """For `explain()`."""
        t, nv = self.arms.shape
        return TENDONS.equation, f"{t} tendon{'s' if t > 1 else ''} over {nv} joints"


def _passive(argument: str, value: Any, joints: Sequence[str]) -> Array:
    """(nv, nv) K_p, with inf on the diagonal of a rigid joint."""
    if isinstance(value, Mapping):
        values = per_name(argument, value, joints, "a joint")
        return np.diag([_passive_spring(f"{argument}[{j!r}]", values.get(j, 0.0)) for j in joints])
    diagonal = springs(argument, value, joints, _passive_spring)
    if diagonal is not None:
        return diagonal
    n = len(joints)
    return psd(argument, array(argument, value, (n, n), what="N·m/rad, finite, one row for each joint,"))


def _check_sprung(K: Array, rigid: Bools, joints: Sequence[str]) -> None:
    """Raises InputError with the joints of every motion that K does not resist."""
    free = np.flatnonzero(~rigid)
    size = np.sqrt(np.diagonal(K)[free])
    size[size == 0.0] = 1.0
    scaled = K[np.ix_(free, free)] / np.outer(size, size)  # without units, so that hinges and slides compare
    stiff, motions = np.linalg.eigh(scaled)
    loose = motions[:, stiff <= SEMIDEFINITE * max(1.0, float(stiff[-1]))] if len(free) else motions
    if loose.shape[1]:
        moves = abs(loose).max(axis=1)
        named = [joints[i] for i, m in zip(free.tolist(), moves, strict=True) if m > _SHARE * moves.max()]
        expected = "tendons and passive springs that leave no joint without one"
        together = " against each other" if len(named) > loose.shape[1] else ""
        raise InputError("Tendons.passive", expected, f"nothing that springs back {', '.join(named)}{together}")
