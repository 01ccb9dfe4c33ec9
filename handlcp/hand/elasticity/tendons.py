"""Tendons: cables that pull at joints, what they bear, and what the stiffness of a hand becomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, number, per_name, psd, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.analysis.explanation import Description
from handlcp.hand.elasticity.elasticity import TRANSMISSION, Transmission, check_numbers
from handlcp.hand.elasticity.laid import lays_of
from handlcp.hand.elasticity.route import Route
from handlcp.hand.elasticity.stiffness import (
    given_rows,
    read_rows,
    read_springs,
    springs,
)
from handlcp.hand.elasticity.tendon_motors import read_tendon_motors
from handlcp.hand.elasticity.tendon_stiffness import EQUATION, Made, RoutedStiffness, TendonStiffness
from handlcp.keywords import helped_init, helped_methods

# ----------------------------------------------------------------
# Tendons: elastic cables over several joints, usually fewer of them than joints.
#
# l = R q,    K = K_p + Rᵀ k R,    τ = Rᵀ t + K_p δq,    t = k R δq
#
# l is the length by which each tendon is drawn in when the joints are at q, and R holds the moment arms. k is the
# stiffness of the tendons, K_p that of the springs at the joints. Under joint torques τ the joints deflect by
# δq = K⁻¹ τ, which stretches the tendons by R δq and raises their tension by t. Drawn in by x they command the joints
# to δq_c = K⁻¹ Rᵀ k x: springs at the joints keep their rest angle, and the tendons pull against them, too. A tendon
# over several joints couples them; one over two fingers is a differential. As k → ∞ the joints can only move such that
# R δq = 0.

TENDONS = Description(
    title=f"{TRANSMISSION}: tendons",
    equation=EQUATION,
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

_tendon_spring = partial(number, above=0.0)
_passive_spring = partial(number, minimum=0.0, finite=False)
_pretension = partial(number, minimum=0.0, finite=False)
_limit = partial(number, above=0.0, finite=False)
_friction = partial(number, minimum=0.0)
_ARMS = "Tendons.moment_arms"


@helped_init()
@helped_methods
@dataclass(frozen=True, eq=False)
class Tendons(Transmission):
    """Pass it as a hand's `joint_stiffness`.

    moment_arms : (t, nv) R [m/rad, m/m] over the hand's joints, or a mapping of tendon names to mappings of joint names
        to arms (joints left out: 0), or to a `Route` through the links, whose arms change with the posture. A positive
        arm: pulling the tendon turns the joint to larger angles.
    stiffness : k [N/m] a number, (t,), a mapping by tendon name, or an SPD matrix (t, t).
    passive : springs at the joints themselves [N·m/rad]: a number ≥ 0, a mapping by joint name (joints left out: 0),
        (nv,), or a positive semidefinite matrix (nv, nv); numpy.inf: that joint is rigid.
    pretension : [N] ≥ 0 with which tendons pull in the grasp's posture before the hand closes, springs at the joints in
        balance with them: a number, (t,), or a mapping by tendon name (tendons left out: 0); numpy.inf: taut whatever
        comes, and pushing where it must, as a rod or a sheathed cable does.
    limits : [N] > 0 that tendons bear, in the same forms; numpy.inf, and tendons left out: no limit.
    motors : a `Motor` for every tendon, or a mapping by tendon name (others: none), as in `motors=` of a hand, whose
        reduction is newtons of tension per N·m of the motor, n / r for a spool of radius r behind a gear n. What it
        holds for good limits its tendon beside `limits`; closing is judged by its peak less dry friction, as of joints.
    friction : μθ of the posts or pulleys that a tendon wraps around at its joints, in the order of its arms from the
        drive on: friction times the angle of the wrap [rad], such as 0.16 for 15 % of the tension. A number for every
        joint that a tendon moves, a mapping by tendon name to a number or to a mapping by joint name (those left out:
        0), or (t, nv). Of a route it is μ alone; the angles are those of its wraps.

    In a loading that is followed (`follow`, `check`, `load_limit`) a tendon never pushes: it goes slack, and is a
    spring less. Drives keep all tendons taut while the hand closes, with the least tensions that make its torques; then
    they hold. At a post a tendon loses T (1 - exp(-μθ)) of its tension T where it is drawn in, and is held by up to
    T (exp(μθ) - 1) more where it is drawn out. One solve in one posture takes all tendons as taut and smooth.
    Raises InputError, UnknownName; also when a hand is made with it, where K is singular: the error names the joints
    that no spring drives back.
    """

    moment_arms: Any
    stiffness: Any
    passive: Any = 0.0
    pretension: Any = 0.0
    limits: Any = np.inf
    friction: Any = 0.0
    motors: Any = None

    def __post_init__(self) -> None:
        """Check what does not depend on the joints."""
        arms = _given_arms(self.moment_arms)
        object.__setattr__(self, "moment_arms", arms)
        if not isinstance(self.stiffness, Mapping):
            numbers = [str(i) for i in range(len(arms))]
            read_springs("Tendons.stiffness", self.stiffness, "tendon", numbers, _tendon_spring)
        check_numbers("Tendons.passive", self.passive, _passive_spring)
        check_numbers("Tendons.friction", self.friction, _friction)
        begun, _ = self._forces(self.names)
        read_tendon_motors(self.motors, self.names, begun)

    @property
    def names(self) -> tuple[str, ...]:
        """(t,) of the tendons."""
        arms = self.moment_arms
        return tuple(arms) if isinstance(arms, dict) else tuple([f"tendon {i + 1}" for i in range(len(arms))])

    def motored(self, motors: Mapping[str, Any] | None) -> Tendons:
        """The same with motors by tendon, None: without."""
        return replace(self, motors=motors)

    def _forces(self, names: Sequence[str]) -> tuple[Array, Array]:
        """(t,) pretension and limits. Raises InputError, UnknownName."""
        begun = _by_tendon("Tendons.pretension", self.pretension, names, _pretension, 0.0)
        most = _by_tendon("Tendons.limits", self.limits, names, _limit, np.inf)
        for name, least, limit in zip(names, begun.tolist(), most.tolist(), strict=True):
            if limit < least < np.inf:
                raise InputError(f"Tendons.limits[{name!r}]", f"at least the pretension, {least:g} N", f"{limit:g} N")
        return begun, most

    def for_joints(self, joints: Sequence[str], kinematics: Any = None) -> TendonStiffness:
        """K over these joints; with routes, in the neutral posture of kinematics. Raises Unsupported without."""
        arms = self.moment_arms
        routed = [] if not isinstance(arms, dict) else [name for name, row in arms.items() if isinstance(row, Route)]
        if not routed:
            names, R = read_rows(_ARMS, arms, "tendon", joints)
        else:
            plain = {name: row for name, row in arms.items() if name not in routed}
            known = read_rows(_ARMS, plain, "tendon", joints)[1] if plain else np.zeros((0, len(joints)))
            names, R = tuple(arms), np.zeros((len(arms), len(joints)))
            R[[name not in routed for name in names]] = known
        k = read_springs("Tendons.stiffness", self.stiffness, "tendon", names, _tendon_spring)
        own = _passive("Tendons.passive", self.passive, joints)
        lays = lays_of(names, R, arms if isinstance(arms, dict) else None, self.friction, joints)
        begun, most = self._forces(names)
        made = Made(names, joints, k, own, begun, most, lays, read_tendon_motors(self.motors, names, begun))
        if not routed:
            return made.at(TendonStiffness, None, np.zeros(len(joints)), None)
        if kinematics is None:
            raise Unsupported("tendons with routes need a hand, whose links they pass")
        return RoutedStiffness.of(made, kinematics, kinematics.neutral)


def _given_arms(value: Any) -> Any:
    """Checked, with routes as they are. Raises InputError."""
    if not isinstance(value, Mapping):
        return given_rows(_ARMS, value)
    plain = {str(name): row for name, row in value.items() if not isinstance(row, Route)}
    checked: Any = given_rows(_ARMS, plain) if plain or not value else {}
    return {str(name): row if isinstance(row, Route) else checked[str(name)] for name, row in value.items()}


def _by_tendon(argument: str, value: Any, names: Sequence[str], read: Callable[[str, Any], float], out: float) -> Array:
    """(t,) numbers from one for all, (t,), or a mapping, `out` for tendons that it leaves out."""
    if isinstance(value, Mapping):
        values = per_name(argument, value, names, "a tendon")
        return read_only(np.array([read(f"{argument}[{n!r}]", values[n]) if n in values else out for n in names]))
    if dimensions(value) == 0:
        return read_only(np.full(len(names), read(argument, value)))
    if len(value) != len(names):
        raise InputError(argument, f"{len(names)} numbers, one for each tendon", f"{len(value)} of them")
    return read_only(np.array([read(f"{argument}[{i}]", x) for i, x in enumerate(value)]))


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
