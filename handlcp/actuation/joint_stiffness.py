"""`Elasticity`: how the joints of a hand give way under load, and what stands between its actuators and its joints.

    δq = C τ,    C = K⁻¹ = A Aᵀ,    E = J C Jᵀ = (J A)(J A)ᵀ

Everything follows from the root A of the compliance. `JointStiffness` has a spring at every joint. In a transmission
(`Tendons`, `Synergies`) an actuator moves several joints, and C may be singular. τ is
what the actuators hold: the joints stand at the commanded posture minus δq.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from handlcp import words
from handlcp.check import (
    Array,
    check_array,
    check_keys,
    check_method_calls,
    check_number,
    check_psd,
    check_spd,
    count_dimensions,
    freeze_arrays,
    read_only,
)
from handlcp.errors import InputError
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.lcp.kernels.dense import kernel
from handlcp.record import Record
from handlcp.tolerances import SEMIDEFINITE_TOLERANCE
from handlcp.words import TextTable

TRANSMISSION = "transmission"  # the effect's name in `explain()`
TENDON_TENSION = "tendon tension"  # the kind of effort of a tendon


@dataclass(frozen=True, slots=True, eq=False)
class Effort(Record):
    """What the actuators behind a transmission do, one by one.

    kind : "tendon tension" or "actuator force". names : of the tendons or synergies.
    values : as many, in `unit`; of tendons how much harder they pull than their pretension, or the whole tension where
        a loading was followed.
    limits : what tendons bear, or their motors hold for good where that is less [N]; inf where there is no limit.
    used : the share of it that the whole tension is, pretension included; 0 of a slack tendon and without a limit.
    """

    entries = ("kind", "unit", "each", "limits (t,)", "used (t,)")

    kind: str
    unit: str
    names: tuple[str, ...]
    values: Array
    limits: Array
    used: Array

    @property
    def each(self) -> dict[str, float]:
        """The values by name."""
        return dict(zip(self.names, self.values.tolist(), strict=True))

    @property
    def table(self) -> TextTable:
        """One by one, with limits and the shares of them where there are any."""
        heads: tuple[str, ...] = (self.kind, self.unit)
        columns, align = [words.format_column(self.values.tolist())], "<>"
        if (limited := np.isfinite(self.limits)).any():
            most = zip(words.format_column(self.limits.tolist()), limited.tolist(), strict=True)
            shares = zip(self.used.tolist(), limited.tolist(), strict=True)
            heads, align = (*heads, f"limit\n{self.unit}", "of limit"), "<>>>"
            columns.append([text if its else "none" for text, its in most])
            columns.append([words.format_percent(share) if its else "–" for share, its in shares])
        return TextTable(heads, tuple(zip(self.names, *columns, strict=True)), align)

    def __str__(self) -> str:
        return str(self.table)


# Springs at a joint, all of them diagonal or (nv, nv) over the joints:
#
#     K = `stiffness_matrix`       everything that gives way: actuators, tendons and springs at joints
#     `joint_springs`              of these the springs at joints, beside actuators or tendons
#     `springs_with_rest`          of these the springs that have a rest angle of their own (MuJoCo's springref)
#     `Cables.passive`, `ServoStiffness.passive`    K_p, `joint_springs` as a matrix, of tendons and of servos


class Elasticity:
    """Compliance C = A Aᵀ of the nv independent joints, symmetric positive semidefinite.

    compliance_factor : (nv, m) A, read-only and C-contiguous; the row of a rigid joint is zero.
    uniform : whether the user gave one number for all joints.
    """

    compliance_factor: Array
    uniform: bool = False

    def __init__(self, root: Array) -> None:
        self.compliance_factor = read_only(np.ascontiguousarray(root))

    @property
    def stiffness_matrix(self) -> Array:
        """(nv, nv) K [N·m/rad]; inf on the diagonal of a rigid joint. Raises Unsupported where C has no inverse."""
        raise NotImplementedError

    @property
    def is_from_file(self) -> bool:
        """Whether it is what the hand's file says."""
        return False

    def contact_compliance(self, J: Array) -> Array:
        """(m, m) E = J C Jᵀ, symmetric to the last bit: compliance at contacts whose Jacobian is J (m, nv)."""
        return joint_flexibility(J, self.compliance_factor)

    def deflection(self, torque: Array) -> Array:
        """(nv,) C τ [rad] for torques (nv,) [N·m]."""
        return np.asarray(self.compliance_factor @ (torque @ self.compliance_factor))

    @property
    def command_directions(self) -> Array:
        """(nv, m) joint motions that the actuators can command, in orthonormal columns; a rigid joint can be, too."""
        return np.eye(len(self.compliance_factor))

    def effort(self, torque: Array, command: Array) -> Effort | None:
        """What the actuators do for joint torques (nv,) [N·m] once they have commanded the joints by so much, (nv,)
        [rad]; None where each joint has its own actuator.
        """
        return None

    def actuator_torque(self, torque: Array, command: Array) -> Array:
        """(nv,) the torques with which the actuators themselves pull at the joints [N·m], springs beside them left out;
        arguments as of `effort`.
        """
        return torque

    @property
    def joint_springs(self) -> Array:
        """(nv,) of the springs at joints that K counts beside actuators or tendons [N·m/rad]; 0: none."""
        return np.zeros(len(self.compliance_factor))

    @property
    def springs_with_rest(self) -> Array:
        """(nv,) k of springs with a rest angle of their own, at joints that servos turn alone [N·m/rad]; 0: none."""
        return np.zeros(len(self.compliance_factor))

    def parallel_spring_torque(self, q: Array) -> Array | None:
        """(nv,) with which drives pull against springs beside them at q (nv,) [N·m]; None: none that counts."""
        return None

    def unmade_torque(self, command: Array) -> Array:
        """(nv,) the part of the torques K δq of a command (nv,) [rad] that no actuator makes [N·m]."""
        return np.zeros(len(command))

    def command_torque(self, command: Array) -> Array:
        """(nv,) K δq of a command (nv,) [rad], of joints that springs hold [N·m]."""
        free = np.asarray(self.compliance_factor.any(axis=1))
        return np.where(free, np.where(np.isinf(self.stiffness_matrix), 0.0, self.stiffness_matrix) @ command, 0.0)

    def in_posture(self, kinematics: Any, q: Array) -> Elasticity:
        """In a posture q (nv,) of a hand with these kinematics: the same, unless tendons run along routes."""
        return self

    def scale_stiffness(self, factor: float) -> Self:
        """The same with every spring so many times as stiff."""
        made = copy(self)
        made.compliance_factor = read_only(self.compliance_factor / np.sqrt(factor))
        return made

    @property
    def law(self) -> tuple[str, str]:
        """Equation and words for `explain()`; no words where each joint has its own spring."""
        return "K = K_p + Rᵀ k R  or  K⁻¹ = K_q⁻¹ + S K_z⁻¹ Sᵀ", ""

    @property
    def is_transmission(self) -> bool:
        """Whether actuators behind it move joints together; no: each joint has its own spring."""
        return bool(self.law[1])

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Arrays stay read-only when pickled."""
        self.__dict__.update(freeze_arrays(state))


def orthonormal_basis(motions: Array) -> Array:
    """(nv, r) orthonormal basis of what columns (nv, m) span, each as good as any other whatever its length."""
    lengths = np.sqrt((motions * motions).sum(axis=0))
    U, s, _ = np.linalg.svd(motions[:, lengths > 0.0] / lengths[lengths > 0.0], full_matrices=False)
    return read_only(U[:, s > SEMIDEFINITE_TOLERANCE])


def check_numbers(argument: str, value: Any, read: Callable[[str, Any], float]) -> None:
    """Of a number for all, one for each, a mapping by name, or a matrix, what does not depend on how many there are.

    read : checks one, from the argument's name and the value. Raises InputError.
    """
    if isinstance(value, Mapping):
        for name, one in value.items():
            check_numbers(f"{argument}[{name!r}]", one, read)
    elif count_dimensions(value) == 0:
        read(argument, value)
    elif count_dimensions(value) == 1:
        for k, one in enumerate(value):
            read(f"{argument}[{k}]", one)
    else:
        check_array(argument, value, (-1, -1))


@check_method_calls
class Transmission:
    """What users pass in place of a joint stiffness where an actuator moves several joints."""

    def for_joints(self, joints: Sequence[str], kinematics: Any = None) -> Elasticity:
        """The elasticity of these joints, of a hand with kinematics. Raises InputError, UnknownName."""
        raise NotImplementedError


# ----------------------------------------------------------------
# What users pass about actuators: a named row over the joints for each, and its stiffness.

GivenRows = Array | dict[str, dict[str, float]]


def check_rows(argument: str, value: Any) -> GivenRows:
    """Finite rows (m, nv), or as many named mappings of joint names to numbers; m ≥ 1. Raises InputError."""
    if not isinstance(value, Mapping):
        rows = check_array(argument, value, (-1, -1))
        if not len(rows):
            raise InputError(argument, "a row for each, at least one", f"shape {rows.shape}")
        return rows
    out: dict[str, dict[str, float]] = {}
    for name, row in value.items():
        if not isinstance(row, Mapping):
            raise InputError(f"{argument}[{name!r}]", "a mapping of joint names to numbers", repr(row)[:80])
        out[str(name)] = {str(j): check_number(f"{argument}[{name!r}][{j!r}]", x) for j, x in row.items()}
    if not out:
        raise InputError(argument, "one name or more", "none")
    return out


def read_rows(argument: str, given: GivenRows, kind: str, joints: Sequence[str]) -> tuple[tuple[str, ...], Array]:
    """Names and rows (m, nv) over these joints; joints that a mapping leaves out: 0. An array's rows are "kind 1", …

    Raises InputError (wrong size, a row of zeros), UnknownName.
    """
    if isinstance(given, dict):
        names, rows = tuple(given), np.zeros((len(given), len(joints)))
        for name, row, out in zip(names, given.values(), rows, strict=True):
            for joint, x in check_keys(f"{argument}[{name!r}]", row, joints, "a joint").items():
                out[joints.index(joint)] = x
    else:
        names, rows = tuple(f"{kind} {i + 1}" for i in range(len(given))), given
        if rows.shape[1] != len(joints):
            listed = ", ".join(joints)
            raise InputError(argument, f"{len(joints)} numbers a {kind}, one for each of {listed}", rows.shape[1])
    for name, out in zip(names, rows, strict=True):
        if not out.any():
            raise InputError(argument, f"a {kind} that moves with some joint", f"only zeros for {name!r}")
    return names, read_only(rows)


def read_springs(
    argument: str, value: Any, kind: str, names: Sequence[str], read: Callable[[str, Any], float]
) -> Array:
    """(m, m) stiffness of the actuators from a number, a mapping by name (all of them), (m,) or an SPD matrix.

    read : checks a number, as in `springs`. Raises InputError, UnknownName.
    """
    if isinstance(value, Mapping):
        values = check_keys(argument, value, names, f"a {kind}")
        if missing := [name for name in names if name not in values]:
            raise InputError(argument, f"a stiffness for every {kind}, {', '.join(missing)} included", sorted(values))
        return np.diag([read(f"{argument}[{name!r}]", values[name]) for name in names])
    diagonal = diagonal_springs(argument, value, names, read)
    return check_spd(argument, check_array(argument, value, (len(names), len(names)))) if diagonal is None else diagonal


# ----------------------------------------------------------------
# Joint stiffness: from what users pass to the root of its inverse.

STIFFNESS_EXPECTED = (  # what is expected where nobody says it
    "how stiff the joints are [N·m/rad]: a number, such as 1 to 10 for the motors of a hand, a mapping by joint name, "
    "or a matrix"
)


class JointStiffness(Elasticity):
    """Stiffness K of the joints [N·m/rad], positive definite; inf on the diagonal: rigid. A = L⁻ᵀ for K = L Lᵀ."""

    def __init__(self, matrix: Array, uniform: bool = False, root: Array | None = None) -> None:
        """Of a matrix (nv, nv); root : A, where it is known."""
        if root is None:
            rigid = np.isinf(np.diagonal(matrix))
            L = np.linalg.cholesky(np.where(np.isinf(matrix), 1.0, matrix))
            root = np.asarray(np.linalg.inv(L).T, dtype=float)
            root[rigid] = 0.0
        super().__init__(root)
        self._matrix, self.uniform = read_only(matrix), uniform

    @property
    def stiffness_matrix(self) -> Array:
        """(nv, nv) K [N·m/rad]; inf on the diagonal of a rigid joint."""
        return self._matrix

    def scale_stiffness(self, factor: float) -> JointStiffness:
        """The same with every spring so many times as stiff."""
        return JointStiffness(self._matrix * factor, self.uniform)

    def scale_by_joint(self, factors: Array) -> Self:
        """The same with the spring of each joint so many times as stiff, f (nv,) > 0; K_ij grows by √(f_i f_j)."""
        made, by = copy(self), np.sqrt(factors)
        made._matrix = read_only(self._matrix * by * by[:, None])
        made.compliance_factor = read_only(self.compliance_factor / by[:, None])
        return made


def read_stiffness(
    value: Any, joints: Sequence[str], argument: str = "joint_stiffness", kinematics: Any = None
) -> Elasticity:
    """From a number, a mapping by joint name, (nv,), an SPD matrix (nv, nv) [N·m/rad], or a transmission.

    None and inf are rigid. Raises InputError (not positive, not SPD, a joint left out), UnknownName.
    """
    if isinstance(value, Elasticity):
        return value
    if isinstance(value, Transmission):
        return value.for_joints(joints, kinematics)
    if isinstance(value, Mapping):
        values = check_keys(argument, value, joints, "a joint")
        if missing := [name for name in joints if name not in values]:
            expected = f"a stiffness for every joint (numpy.inf: rigid), {', '.join(missing)} included"
            raise InputError(argument, expected, f"only {sorted(values)}")
        return JointStiffness(np.diag([read_spring(f"{argument}[{name!r}]", values[name]) for name in joints]))
    diagonal = diagonal_springs(argument, value, joints, read_spring)
    if diagonal is not None:
        return JointStiffness(diagonal, uniform=count_dimensions(value) == 0)
    square = (len(joints), len(joints))
    matrix = check_array(argument, value, square, what="N·m/rad, finite, one row for each joint,")
    return JointStiffness(check_spd(argument, matrix))


def with_motor_stiffness(elasticity: Elasticity, own: Mapping[str, float], joints: Sequence[str]) -> Elasticity:
    """With joints by name as stiff as their motors say [N·m/rad]; InputError where other springs take part."""
    if not own:
        return elasticity
    at = [joints.index(joint) for joint in own]
    if isinstance(elasticity, JointStiffness):
        K = elasticity.stiffness_matrix.copy()
        coupled = np.count_nonzero(K, axis=1) > 1
        if not coupled[at].any() and not elasticity.is_transmission:
            K[at, at] = list(own.values())
            return JointStiffness(K)
    expected = "None of a motor whose joint shares springs with others (joint_stiffness says how stiff these are)"
    raise InputError("Motor.stiffness", expected, ", ".join(own))


def diagonal_springs(
    argument: str, value: Any, names: Sequence[str], read: Callable[[str, Any], float]
) -> Array | None:
    """(m, m) diagonal of m springs, from one number for all or m in the order of `names`; None for anything else.

    read : checks a number, from the argument's name and the value. Raises InputError.
    """
    m = len(names)
    if count_dimensions(value) == 0:
        return np.diag(np.full(m, read(argument, value)))
    if count_dimensions(value) != 1:
        return None
    if len(value) != m:
        raise InputError(argument, f"{m} values, one for each of {', '.join(names)}", f"{len(value)} of them")
    return np.diag([read(f"{argument}[{i}]", k) for i, k in enumerate(value)])


def read_spring(argument: str, value: Any) -> float:
    """[N·m/rad] of one joint; None and inf are rigid. Raises InputError."""
    return np.inf if value is None else check_number(argument, value, above=0.0, finite=False)


# ----------------------------------------------------------------
# Fingertip pads: their flexibility, in the axes of the tip frames, adds to that of the joints.


class FingertipPads:
    """Flexibility of n pads: blocks (n, 3, 3) [m/N], PSD, tip axes. isotropic : each is the same in all directions.
    links : blocks (3, 3) of links that were named, in their axes. rest : of those that were not.
    """

    __slots__ = ("_every", "_links", "_rest", "blocks", "isotropic")

    def __init__(self, blocks: Array, links: Mapping[str, Array] | None = None, rest: Array | None = None) -> None:
        self.blocks, self._every = read_only(blocks), tuple(range(len(blocks)))
        self._links, self._rest = links or {}, read_only(np.zeros((3, 3))) if rest is None else read_only(rest)
        self.isotropic = bool((blocks == blocks[:, :1, :1] * np.eye(3)).all())

    def link_pad(self, name: str) -> Array:
        """(3, 3) of a link that is no fingertip, in its axes."""
        return self._links.get(name, self._rest)

    def rotate_blocks(self, rotations: Callable[[], Array], tips: tuple[int, ...]) -> Array:
        """(m, 3, 3) of the m tips numbered `tips`; rotations makes what turns tip axes into those of the result, (m, 3,
        3), and is asked only where a pad is not the same in all axes.
        """
        pads = self.blocks if tips == self._every else read_only(self.blocks[list(tips)])
        if self.isotropic:
            return pads
        R = rotations()
        turned = R @ pads @ R.transpose(0, 2, 1)
        return read_only((turned + turned.transpose(0, 2, 1)) / 2)


@kernel
def tip_flexibility(jacobian: Array, root: Array, pads: Array) -> Array:
    """E = J K⁻¹ Jᵀ + pads (3m, 3m) [m/N]; jacobian (3m, nv), root as in `joint_flexibility`, pads (m, 3, 3)."""
    E = joint_flexibility(jacobian, root)
    for i in range(len(pads)):
        for a in range(3):
            for b in range(3):
                E[3 * i + a, 3 * i + b] += pads[i, a, b]
    return E


def read_pads(value: Any, tips: Sequence[str], links: Sequence[str] = ()) -> FingertipPads:
    """From a number, of all links, too; (3,), (3, 3), (n, 3, 3) [m/N], of fingertips; or a mapping by name of a
    fingertip or link of the first three (others: rigid).

    Raises InputError for anything that is not positive semidefinite; UnknownName.
    """
    argument, n = "pad_flexibility", len(tips)
    if isinstance(value, Mapping):
        values = check_keys(argument, value, tuple(dict.fromkeys((*tips, *links))), "a fingertip or link")
        given = {name: _read_pad(f"{argument}[{name!r}]", pad) for name, pad in values.items()}
        return FingertipPads(np.array([given.get(tip, np.zeros((3, 3))) for tip in tips]), given)
    if count_dimensions(value) == 3:
        stack = check_array(argument, value, (n, 3, 3))
        return FingertipPads(np.array([check_psd(f"{argument}[{i}]", block) for i, block in enumerate(stack)]))
    pad = _read_pad(argument, value)
    return FingertipPads(np.tile(pad, (n, 1, 1)), None, pad if count_dimensions(value) == 0 else None)


def _read_pad(argument: str, value: Any) -> Array:
    if isinstance(value, (str, bytes, bool)) or value is None:
        raise InputError(argument, "a flexibility [m/N]: a number, (3,) or (3, 3)", repr(value))
    a = check_array(argument, value, (), (3,), (3, 3))
    return check_psd(argument, np.eye(3) * a if a.ndim < 2 else a)
