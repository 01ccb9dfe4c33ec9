"""Tendons and synergies: how fewer drives than joints move a hand, and what its stiffness becomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, array, dimensions, number, per_name, psd, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.analysis.explanation import Description
from handlcp.grasp.model.cables import Cables
from handlcp.hand.elasticity.elasticity import TENSION, TRANSMISSION, Effort, Elasticity, Transmission, spanned
from handlcp.hand.elasticity.motor import Drives
from handlcp.hand.elasticity.stiffness import (
    JointStiffness,
    given_rows,
    read_rows,
    read_springs,
    read_stiffness,
    springs,
)
from handlcp.hand.elasticity.tendon_motors import check_driven_once, read_tendon_motors
from handlcp.tolerances import SEMIDEFINITE

# ----------------------------------------------------------------
# Soft synergies: each actuator moves many joints at once, through a spring.
#
# q = S z,    C = K_q⁻¹ + S K_z⁻¹ Sᵀ,    η = Sᵀ τ
#
# Each column of S is a posture towards which one actuator pulls the hand. Actuator springs K_z and joint springs K_q
# are in series: both carry the torque τ, the actuators as η, so their compliances add. With rigid joints (K_q = ∞) the
# hand gives way in as many directions as it has actuators; C is then singular and has no inverse. A column with one
# joint and the joints that mimic it acts as a mimic joint.

SYNERGIES = Description(
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


_spring = partial(number, above=0.0, finite=False)


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
        columns = self.S if isinstance(self.S, Mapping) else array("Synergies.S", self.S, (-1, -1)).T
        rows = given_rows("Synergies.S", columns)
        object.__setattr__(self, "S", rows)
        if not isinstance(self.stiffness, Mapping):
            numbers = [str(i) for i in range(len(rows))]
            read_springs("Synergies.stiffness", self.stiffness, "synergy", numbers, _spring)
        if isinstance(self.joint_stiffness, Transmission):
            expected = "the springs of the joints themselves, or None where they are rigid"
            raise InputError("Synergies.joint_stiffness", expected, type(self.joint_stiffness).__name__)

    def for_joints(self, joints: Sequence[str]) -> SynergyCompliance:
        """C over these joints."""
        names, rows = read_rows("Synergies.S", self.S, "synergy", joints)
        springs = read_springs("Synergies.stiffness", self.stiffness, "synergy", names, _spring)
        root = rows.T @ JointStiffness(springs).root
        if self.joint_stiffness is not None:
            own = read_stiffness(self.joint_stiffness, joints, "Synergies.joint_stiffness")
            root = np.hstack([own.root, root])
        return SynergyCompliance(names, rows, root)


class SynergyCompliance(Elasticity):
    """C = A Aᵀ with A = (K_q^-½, S K_z^-½), and the synergies behind it: names (k,), columns (k, nv) of S as rows."""

    def __init__(self, names: tuple[str, ...], columns: Array, root: Array) -> None:
        super().__init__(root)
        self.names, self.columns = names, columns

    @property
    def matrix(self) -> Array:
        """(nv, nv) K = C⁻¹. Raises Unsupported where C is singular: some joints only move together."""
        U, s, _ = np.linalg.svd(self.root, full_matrices=False)
        nv = len(self.root)
        if len(s) < nv or s[-1] ** 2 <= SEMIDEFINITE * s[0] ** 2:
            raise Unsupported(
                f"{len(self.names)} synergies move {nv} joints that are rigid but for them: these have a compliance "
                "(hand.joint_compliance) and no stiffness"
            )
        return read_only((U / s**2) @ U.T)

    @property
    def commands(self) -> Array:
        """The columns of S: an actuator moves its joints together."""
        return spanned(self.columns.T)

    def effort(self, torque: Array, command: Array) -> Effort:
        """The force η = Sᵀ τ [N·m where S has no unit] of each actuator."""
        return Effort("actuator force", "N·m", self.names, read_only(self.columns @ torque))

    @property
    def law(self) -> tuple[str, str]:
        """For `explain()`."""
        k, nv = self.columns.shape
        return SYNERGIES.equation, f"{k} synerg{'ies' if k > 1 else 'y'} over {nv} joints"


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

_MADE = 1e-6  # of the largest torque of a command: less is rounding
_SHARE = 0.1  # of the largest motion: joints that move less are not named as loose
_tendon_spring = partial(number, above=0.0)
_passive_spring = partial(number, minimum=0.0, finite=False)
_pretension = partial(number, minimum=0.0, finite=False)
_limit = partial(number, above=0.0, finite=False)


@dataclass(frozen=True, eq=False)
class Tendons(Transmission):
    """Pass it as a hand's `joint_stiffness`.

    moment_arms : (t, nv) R [m/rad, m/m] over the hand's joints, or a mapping of tendon names to mappings of joint names
        to arms (joints left out: 0). A positive arm: pulling the tendon turns the joint to larger angles.
    stiffness : k [N/m] a number, (t,), a mapping by tendon name, or an SPD matrix (t, t).
    passive : springs at the joints themselves [N·m/rad]: a number ≥ 0, a mapping by joint name (joints left out: 0),
        (nv,), or a positive semidefinite matrix (nv, nv); numpy.inf: that joint is rigid.
    pretension : [N] ≥ 0 with which tendons pull in the grasp's posture before the hand closes, springs at the joints in
        balance with them: a number, (t,), or a mapping by tendon name (tendons left out: 0); numpy.inf: taut whatever
        comes, and pushing where it must, as a rod or a sheathed cable does.
    limits : [N] > 0 that tendons bear, in the same forms; numpy.inf, and tendons left out: no limit.
    motors : a `Motor` for every tendon, or a mapping by tendon name (others: none), whose reduction is newtons of
        tension per N·m of the motor, n / r for a spool of radius r behind a gear n. What it holds for good limits its
        tendon beside `limits`; closing is judged by its peak less dry friction, as of joints.

    In a loading that is followed (`follow`, `check`, `load_limit`) a tendon never pushes: it goes slack, and is a
    spring less. Drives keep all tendons taut while the hand closes, with the least tensions that make its torques; then
    they hold. One solve in one posture takes all tendons as taut.
    Raises InputError, UnknownName; also when a hand is made with it, where K is singular: the error names the joints
    that no spring drives back.
    """

    moment_arms: Any
    stiffness: Any
    passive: Any = 0.0
    pretension: Any = 0.0
    limits: Any = np.inf
    motors: Any = None

    def __post_init__(self) -> None:
        """Check what does not depend on the joints."""
        arms = given_rows("Tendons.moment_arms", self.moment_arms)
        object.__setattr__(self, "moment_arms", arms)
        if not isinstance(self.stiffness, Mapping):
            numbers = [str(i) for i in range(len(arms))]
            read_springs("Tendons.stiffness", self.stiffness, "tendon", numbers, _tendon_spring)
        names = tuple(arms) if isinstance(arms, dict) else [f"tendon {i + 1}" for i in range(len(arms))]
        begun, _ = self._forces(names)
        read_tendon_motors(self.motors, names, begun)

    def _forces(self, names: Sequence[str]) -> tuple[Array, Array]:
        """(t,) pretension and limits. Raises InputError, UnknownName."""
        begun = _by_tendon("Tendons.pretension", self.pretension, names, _pretension, 0.0)
        most = _by_tendon("Tendons.limits", self.limits, names, _limit, np.inf)
        for name, least, limit in zip(names, begun.tolist(), most.tolist(), strict=True):
            if limit < least < np.inf:
                raise InputError(f"Tendons.limits[{name!r}]", f"at least the pretension, {least:g} N", f"{limit:g} N")
        return begun, most

    def for_joints(self, joints: Sequence[str]) -> TendonStiffness:
        """K over these joints."""
        names, R = read_rows("Tendons.moment_arms", self.moment_arms, "tendon", joints)
        k = read_springs("Tendons.stiffness", self.stiffness, "tendon", names, _tendon_spring)
        own = _passive("Tendons.passive", self.passive, joints)
        K = own.copy()
        rigid = np.isinf(np.diagonal(K))
        through = R.T @ k @ R
        through[rigid] = through[:, rigid] = 0.0  # no load reaches the tendons through a rigid joint
        K += (through + through.T) / 2
        _check_sprung(K, rigid, joints)
        through = read_only(np.where(rigid, 0.0, R))
        own = read_only(np.where(np.isinf(own), 0.0, own))
        cables = Cables(names, through, k, own, np.zeros(len(K)), *self._forces(names))
        drives = read_tendon_motors(self.motors, names, cables.pretension)
        return TendonStiffness(K, R, cables).driven(drives, cables.limits)


class TendonStiffness(JointStiffness):
    """K = K_p + Rᵀ k R, and the tendons behind it; arms (t, nv) : R as it was given. drives : motors of tendons, None
    without; bears (t,) : what tendons bear, whatever their motors hold [N]. `cables.limits` are the smaller of both.
    """

    drives: Drives | None = None

    def __init__(self, matrix: Array, arms: Array, cables: Cables) -> None:
        super().__init__(matrix)
        self.arms, self.cables, self.bears = arms, cables, cables.limits

    def driven(self, drives: Drives | None, bears: Array) -> TendonStiffness:
        """The same with these motors, of tendons that bear so much, (t,) [N]."""
        made = copy(self)
        limits = bears if drives is None else read_only(np.minimum(bears, drives.holds(bears)))
        made.drives, made.bears, made.cables = drives, bears, self.cables._replace(limits=limits)
        return made

    @property
    def closes(self) -> Array:
        """(t,) with which motors can draw tendons in [N]; inf where no motor says it."""
        return np.full(len(self.bears), np.inf) if self.drives is None else self.drives.closes

    def check_driven_once(self, drives: Drives | None, joints: Sequence[str]) -> None:
        """No joint has a motor of its own that a tendon with a motor moves."""
        check_driven_once(self.arms, self.drives, drives, joints)

    @property
    def commands(self) -> Array:
        """K⁻¹ Rᵀ: where the springs let the joints go when a tendon is drawn in."""
        return spanned(self.root @ (self.arms @ self.root).T)

    def stiffer(self, factor: float) -> TendonStiffness:
        """The same with every spring so many times as stiff."""
        c = self.cables
        springs, passive = read_only(factor * c.springs), read_only(factor * c.passive)
        made = TendonStiffness(self.matrix * factor, self.arms, c._replace(springs=springs, passive=passive))
        return made.driven(self.drives, self.bears)

    def effort(self, torque: Array, command: Array) -> Effort:
        """The tension t = k R K⁻¹ τ + t_c [N]: how much harder each tendon pulls; below 0 it pulls less. t_c is what it
        takes to turn the joints to where they are commanded against their own springs, Rᵀ t_c = K_p δq_c.
        """
        c = self.cables
        tension = c.springs @ (self.arms @ self.deflection(torque))
        if command.any():
            tension = tension + np.linalg.lstsq(self.arms.T, c.passive @ command)[0]
        return self.tensions(tension)

    def tensions(self, values: Array) -> Effort:
        """With which tendons pull, (t,) [N]."""
        return Effort(TENSION, "N", self.cables.names, read_only(values))

    def pulled(self, torque: Array, command: Array) -> Array:
        """Rᵀ t."""
        return np.asarray(self.arms.T @ self.effort(torque, command).values)

    def beyond(self, command: Array) -> Array:
        """Tendons that pull make torques Rᵀ (t - T₀), none of them below 0; what else K δq_c asks for, springs at the
        joints would have to be commanded to, or tendons would have to push.
        """
        free = np.asarray(self.root.any(axis=1))
        asked = np.where(free, np.where(np.isinf(self.matrix), 0.0, self.matrix) @ command, 0.0)
        left = self.cables.not_made(asked)
        return np.where(abs(left) > _MADE * abs(asked).max(initial=0.0), left, 0.0)

    @property
    def law(self) -> tuple[str, str]:
        """For `explain()`."""
        t, nv = self.arms.shape
        return TENDONS.equation, f"{t} tendon{'s' if t > 1 else ''} over {nv} joints"


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
