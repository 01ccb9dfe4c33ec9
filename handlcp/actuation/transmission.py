"""Tendons: cables that pull at joints, what they bear, and what the stiffness of a hand becomes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from handlcp.actuation.cable_routing import read_cable_routing
from handlcp.actuation.joint_stiffness import (
    TRANSMISSION,
    Effort,
    Elasticity,
    JointStiffness,
    Transmission,
    check_numbers,
    check_rows,
    diagonal_springs,
    orthonormal_basis,
    read_rows,
    read_springs,
    read_stiffness,
)
from handlcp.actuation.motor import read_tendon_motors
from handlcp.actuation.route import Route
from handlcp.actuation.tendon_stiffness import TENDON_EQUATION, RoutedStiffness, TendonModel, TendonStiffness
from handlcp.check import (
    Array,
    NumbersByName,
    check_array,
    check_init_call,
    check_keys,
    check_method_calls,
    check_number,
    check_psd,
    read_only,
)
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.analysis.explanation import EffectDescription
from handlcp.tolerances import SEMIDEFINITE_TOLERANCE

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

TENDONS = EffectDescription(
    title=f"{TRANSMISSION}: tendons",
    equation=TENDON_EQUATION,
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

_read_tendon_spring = partial(check_number, above=0.0)
_read_passive_spring = partial(check_number, minimum=0.0, finite=False)
PRETENSIONS = NumbersByName("tendon", minimum=0.0, finite=False)
TENSION_LIMITS = NumbersByName("tendon", above=0.0, finite=False, rest=np.inf)
_read_friction = partial(check_number, minimum=0.0)
_ARMS_ARGUMENT = "Tendons.moment_arms"


@check_init_call()
@check_method_calls
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
        arms = self.moment_arms
        if isinstance(arms, Mapping):  # routes stay as they are
            plain = {str(name): row for name, row in arms.items() if not isinstance(row, Route)}
            checked: Any = check_rows(_ARMS_ARGUMENT, plain) if plain or not arms else {}
            arms = {str(name): row if isinstance(row, Route) else checked[str(name)] for name, row in arms.items()}
        else:
            arms = check_rows(_ARMS_ARGUMENT, arms)
        object.__setattr__(self, "moment_arms", arms)
        if not isinstance(self.stiffness, Mapping):
            numbers = [str(i) for i in range(len(arms))]
            read_springs("Tendons.stiffness", self.stiffness, "tendon", numbers, _read_tendon_spring)
        check_numbers("Tendons.passive", self.passive, _read_passive_spring)
        check_numbers("Tendons.friction", self.friction, _read_friction)
        begun, _ = self._read_forces(self.names)
        read_tendon_motors(self.motors, self.names, begun)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the t tendons, "tendon 1", … where none were given."""
        arms = self.moment_arms
        return tuple(arms) if isinstance(arms, dict) else tuple([f"tendon {i + 1}" for i in range(len(arms))])

    def motored(self, motors: Mapping[str, Any] | None) -> Tendons:
        """The same with motors by tendon, None: without."""
        return replace(self, motors=motors)

    def _read_forces(self, names: Sequence[str]) -> tuple[Array, Array]:
        """Read pretension and limit (t,) of each tendon [N]. Raises InputError, UnknownName."""
        begun = PRETENSIONS.read("Tendons.pretension", self.pretension, names)
        most = TENSION_LIMITS.read("Tendons.limits", self.limits, names)
        for name, least, limit in zip(names, begun.tolist(), most.tolist(), strict=True):
            if limit < least < np.inf:
                raise InputError(f"Tendons.limits[{name!r}]", f"at least the pretension, {least:g} N", f"{limit:g} N")
        return begun, most

    def for_joints(self, joints: Sequence[str], kinematics: Any = None) -> TendonStiffness:
        """K over these joints; with routes, in the neutral posture of kinematics. Raises Unsupported without."""
        arms = self.moment_arms
        routed = [] if not isinstance(arms, dict) else [name for name, row in arms.items() if isinstance(row, Route)]
        if not routed:
            names, R = read_rows(_ARMS_ARGUMENT, arms, "tendon", joints)
        else:
            plain = {name: row for name, row in arms.items() if name not in routed}
            known = read_rows(_ARMS_ARGUMENT, plain, "tendon", joints)[1] if plain else np.zeros((0, len(joints)))
            names, R = tuple(arms), np.zeros((len(arms), len(joints)))
            R[[name not in routed for name in names]] = known
        k = read_springs("Tendons.stiffness", self.stiffness, "tendon", names, _read_tendon_spring)
        own = _read_passive("Tendons.passive", self.passive, joints)
        lays = read_cable_routing(names, R, arms if isinstance(arms, dict) else None, self.friction, joints)
        begun, most = self._read_forces(names)
        made = TendonModel(names, joints, k, own, begun, most, lays, read_tendon_motors(self.motors, names, begun))
        if not routed:
            return made.elasticity_at(TendonStiffness, None, np.zeros(len(joints)), None)
        if kinematics is None:
            raise Unsupported("tendons with routes need a hand, whose links they pass")
        return RoutedStiffness.from_model(made, kinematics, kinematics.neutral)


def _read_passive(argument: str, value: Any, joints: Sequence[str]) -> Array:
    """(nv, nv) K_p, with inf on the diagonal of a rigid joint."""
    if isinstance(value, Mapping):
        values = check_keys(argument, value, joints, "a joint")
        return np.diag([_read_passive_spring(f"{argument}[{j!r}]", values.get(j, 0.0)) for j in joints])
    diagonal = diagonal_springs(argument, value, joints, _read_passive_spring)
    if diagonal is not None:
        return diagonal
    n = len(joints)
    return check_psd(argument, check_array(argument, value, (n, n), what="N·m/rad, finite, one row for each joint,"))


# ----------------------------------------------------------------
# Soft synergies: each actuator moves many joints at once, through a spring.
#
# q = S z,    C = K_q⁻¹ + S K_z⁻¹ Sᵀ,    η = Sᵀ τ
#
# Each column of S is a posture towards which one actuator pulls the hand. Actuator springs K_z and joint springs K_q
# are in series: both carry the torque τ, the actuators as η, so their compliances add. With rigid joints (K_q = ∞) the
# hand gives way in as many directions as it has actuators; C is then singular and has no inverse. A column with one
# joint and the joints that mimic it acts as a mimic joint.

SYNERGIES = EffectDescription(
    title=f"{TRANSMISSION}: synergies",
    equation="C = K_q⁻¹ + S K_z⁻¹ Sᵀ,  η = Sᵀ τ",
    when="A few actuators move many joints at once; joints that mimic another.",
    in_python='joint_stiffness=Synergies({"fist": {"finger_1_distal": 1, "finger_2_distal": 1}}, 4.0, 8.0)',
    in_file="[hand.synergies]\n"
    "columns = { fist = { finger_1_distal = 1, finger_2_distal = 1 } }\n"
    "stiffness_Nm_per_rad = 4.0\n"
    "joint_stiffness_Nm_per_rad = 8.0",
    brings="none: part of K",
    source="Gabiccini, Bicchi, Prattichizzo & Malvezzi, Autonomous Robots 31 (2011); Brown & Asada, IROS 2007",
    module=__name__,
)


_read_actuator_spring = partial(check_number, above=0.0, finite=False)


@check_init_call()
@dataclass(frozen=True, eq=False)
class Synergies(Transmission):
    """Pass it as a hand's `joint_stiffness`.

    S : (nv, k), a column for each actuator [rad or m of a joint per unit of z], or a mapping of synergy names to
        mappings of joint names to entries (joints left out: 0).
    stiffness : K_z of the actuators, a number, (k,), a mapping by synergy name, or an SPD matrix (k, k); [N·m/rad]
        where S has no unit. numpy.inf: that actuator is rigid.
    joint_stiffness : K_q [N·m/rad] of the joints' own springs, in series with the actuators, as for a hand without
        synergies; None: the joints are rigid.

    Raises InputError, UnknownName.
    """

    S: Any
    stiffness: Any
    joint_stiffness: Any = None

    def __post_init__(self) -> None:
        """Check what does not depend on the joints. `S` becomes rows, one for each actuator."""
        columns = self.S if isinstance(self.S, Mapping) else check_array("Synergies.S", self.S, (-1, -1)).T
        rows = check_rows("Synergies.S", columns)
        object.__setattr__(self, "S", rows)
        if not isinstance(self.stiffness, Mapping):
            numbers = [str(i) for i in range(len(rows))]
            read_springs("Synergies.stiffness", self.stiffness, "synergy", numbers, _read_actuator_spring)
        if isinstance(self.joint_stiffness, Transmission):
            expected = "the springs of the joints themselves, or None where they are rigid"
            raise InputError("Synergies.joint_stiffness", expected, type(self.joint_stiffness).__name__)
        if not (self.joint_stiffness is None or isinstance(self.joint_stiffness, Elasticity)):
            check_numbers("Synergies.joint_stiffness", self.joint_stiffness, _read_actuator_spring)

    def for_joints(self, joints: Sequence[str], kinematics: Any = None) -> SynergyCompliance:
        """C over these joints."""
        names, rows = read_rows("Synergies.S", self.S, "synergy", joints)
        springs = read_springs("Synergies.stiffness", self.stiffness, "synergy", names, _read_actuator_spring)
        root = rows.T @ JointStiffness(springs).compliance_factor
        if self.joint_stiffness is not None:
            own = read_stiffness(self.joint_stiffness, joints, "Synergies.joint_stiffness")
            root = np.hstack([own.compliance_factor, root])
        return SynergyCompliance(names, rows, root)


class SynergyCompliance(Elasticity):
    """C = A Aᵀ with A = (K_q^-½, S K_z^-½), and the synergies behind it: names (k,), columns (k, nv) of S as rows."""

    def __init__(self, names: tuple[str, ...], columns: Array, root: Array) -> None:
        super().__init__(root)
        self.names, self.columns = names, columns

    @property
    def stiffness_matrix(self) -> Array:
        """K = C⁻¹ (nv, nv) of the joints. Raises Unsupported where C is singular: some joints only move together."""
        U, s, _ = np.linalg.svd(self.compliance_factor, full_matrices=False)
        nv = len(self.compliance_factor)
        if len(s) < nv or s[-1] ** 2 <= SEMIDEFINITE_TOLERANCE * s[0] ** 2:
            raise Unsupported(
                f"{len(self.names)} synergies move {nv} joints that are rigid but for them: these have a compliance "
                "(hand.joint_compliance) and no stiffness"
            )
        return read_only((U / s**2) @ U.T)

    @property
    def command_directions(self) -> Array:
        """The columns of S: an actuator moves its joints together."""
        return orthonormal_basis(self.columns.T)

    def effort(self, torque: Array, command: Array) -> Effort:
        """The force η = Sᵀ τ [N·m where S has no unit] of each actuator."""
        none = len(self.names)
        free = read_only(np.full(none, np.inf)), read_only(np.zeros(none))
        return Effort("actuator force", "N·m", self.names, read_only(self.columns @ torque), *free)

    @property
    def law(self) -> tuple[str, str]:
        """The equation of the synergies and how many there are, for `explain()`."""
        k, nv = self.columns.shape
        return SYNERGIES.equation, f"{k} synerg{'ies' if k > 1 else 'y'} over {nv} joints"
