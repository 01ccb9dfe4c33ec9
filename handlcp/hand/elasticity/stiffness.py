"""Stiffness of joints and pads as users pass it: numbers, by name, as matrices."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import Any, Self

import numpy as np

from handlcp.check import Array, array, dimensions, number, per_name, psd, read_only, spd
from handlcp.errors import InputError
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.hand.elasticity.elasticity import Elasticity, Transmission
from handlcp.lcp.kernels.dense import kernel

# ----------------------------------------------------------------
# What users pass about actuators: a named row over the joints for each, and its stiffness.

Given = Array | dict[str, dict[str, float]]


def given_rows(argument: str, value: Any) -> Given:
    """Finite rows (m, nv), or as many named mappings of joint names to numbers; m ≥ 1. Raises InputError."""
    if not isinstance(value, Mapping):
        rows = array(argument, value, (-1, -1))
        if not len(rows):
            raise InputError(argument, "a row for each, at least one", f"shape {rows.shape}")
        return rows
    out: dict[str, dict[str, float]] = {}
    for name, row in value.items():
        if not isinstance(row, Mapping):
            raise InputError(f"{argument}[{name!r}]", "a mapping of joint names to numbers", repr(row)[:80])
        out[str(name)] = {str(j): number(f"{argument}[{name!r}][{j!r}]", x) for j, x in row.items()}
    if not out:
        raise InputError(argument, "one name or more", "none")
    return out


def read_rows(argument: str, given: Given, kind: str, joints: Sequence[str]) -> tuple[tuple[str, ...], Array]:
    """Names and rows (m, nv) over these joints; joints that a mapping leaves out: 0. An array's rows are "kind 1", …

    Raises InputError (wrong size, a row of zeros), UnknownName.
    """
    if isinstance(given, dict):
        names, rows = tuple(given), np.zeros((len(given), len(joints)))
        for name, row, out in zip(names, given.values(), rows, strict=True):
            for joint, x in per_name(f"{argument}[{name!r}]", row, joints, "a joint").items():
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
        values = per_name(argument, value, names, f"a {kind}")
        if missing := [name for name in names if name not in values]:
            raise InputError(argument, f"a stiffness for every {kind}, {', '.join(missing)} included", sorted(values))
        return np.diag([read(f"{argument}[{name!r}]", values[name]) for name in names])
    diagonal = springs(argument, value, names, read)
    return spd(argument, array(argument, value, (len(names), len(names)))) if diagonal is None else diagonal


# ----------------------------------------------------------------
# Joint stiffness: from what users pass to the root of its inverse.

HOW_STIFF = (  # what is expected where nobody says it
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
    def matrix(self) -> Array:
        """(nv, nv) K [N·m/rad]; inf on the diagonal of a rigid joint."""
        return self._matrix

    def stiffer(self, factor: float) -> JointStiffness:
        """The same with every spring so many times as stiff."""
        return JointStiffness(self._matrix * factor, self.uniform)

    def by_joint(self, factors: Array) -> Self:
        """The same with the spring of each joint so many times as stiff, f (nv,) > 0; K_ij grows by √(f_i f_j)."""
        made, by = copy(self), np.sqrt(factors)
        made._matrix, made.root = read_only(self._matrix * by * by[:, None]), read_only(self.root / by[:, None])
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
        values = per_name(argument, value, joints, "a joint")
        if missing := [name for name in joints if name not in values]:
            expected = f"a stiffness for every joint (numpy.inf: rigid), {', '.join(missing)} included"
            raise InputError(argument, expected, f"only {sorted(values)}")
        return JointStiffness(np.diag([read_spring(f"{argument}[{name!r}]", values[name]) for name in joints]))
    diagonal = springs(argument, value, joints, read_spring)
    if diagonal is not None:
        return JointStiffness(diagonal, uniform=dimensions(value) == 0)
    square = (len(joints), len(joints))
    matrix = array(argument, value, square, what="N·m/rad, finite, one row for each joint,")
    return JointStiffness(spd(argument, matrix))


def stiff_as(elasticity: Elasticity, own: Mapping[str, float], joints: Sequence[str]) -> Elasticity:
    """The same with joints by name that are as stiff as their motors say [N·m/rad]. Raises InputError where other
    springs take part there.
    """
    if not own:
        return elasticity
    at = [joints.index(joint) for joint in own]
    if isinstance(elasticity, JointStiffness):
        K = elasticity.matrix.copy()
        coupled = np.count_nonzero(K, axis=1) > 1
        if not coupled[at].any() and not elasticity.law[1]:
            K[at, at] = list(own.values())
            return JointStiffness(K)
    expected = "None of a motor whose joint shares springs with others (joint_stiffness says how stiff these are)"
    raise InputError("Motor.stiffness", expected, ", ".join(own))


def springs(argument: str, value: Any, names: Sequence[str], read: Callable[[str, Any], float]) -> Array | None:
    """(m, m) diagonal of m springs, from one number for all or m in the order of `names`; None for anything else.

    read : checks a number, from the argument's name and the value. Raises InputError.
    """
    m = len(names)
    if dimensions(value) == 0:
        return np.diag(np.full(m, read(argument, value)))
    if dimensions(value) != 1:
        return None
    if len(value) != m:
        raise InputError(argument, f"{m} values, one for each of {', '.join(names)}", f"{len(value)} of them")
    return np.diag([read(f"{argument}[{i}]", k) for i, k in enumerate(value)])


def read_spring(argument: str, value: Any) -> float:
    """[N·m/rad] of one joint; None and inf are rigid. Raises InputError."""
    return np.inf if value is None else number(argument, value, above=0.0, finite=False)


# ----------------------------------------------------------------
# Fingertip pads: their flexibility, in the axes of the tip frames, adds to that of the joints.


class Pads:
    """Flexibility of n pads: blocks (n, 3, 3) [m/N], PSD, tip axes. isotropic : each is the same in all directions.
    links : blocks (3, 3) of links that were named, in their axes. rest : of those that were not.
    """

    __slots__ = ("_every", "_links", "_rest", "blocks", "isotropic")

    def __init__(self, blocks: Array, links: Mapping[str, Array] | None = None, rest: Array | None = None) -> None:
        self.blocks, self._every = read_only(blocks), tuple(range(len(blocks)))
        self._links, self._rest = links or {}, read_only(np.zeros((3, 3))) if rest is None else read_only(rest)
        self.isotropic = bool((blocks == blocks[:, :1, :1] * np.eye(3)).all())

    def of_link(self, name: str) -> Array:
        """(3, 3) of a link that is no fingertip, in its axes."""
        return self._links.get(name, self._rest)

    def in_axes(self, rotations: Callable[[], Array], tips: tuple[int, ...]) -> Array:
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
def inverse_root(K: Array, A: Array) -> bool:
    """Write L⁻ᵀ of K = L Lᵀ (n, n) into A (n, n), of zeros; False where K is not positive definite."""
    n = len(K)
    L = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            left = K[i, j]
            for k in range(j):
                left -= L[i, k] * L[j, k]
            if i > j:
                L[i, j] = left / L[j, j]
            elif left > 0.0:
                L[i, i] = np.sqrt(left)
            else:
                return False
    for j in range(n):
        A[j, j] = 1.0 / L[j, j]
        for i in range(j + 1, n):
            for k in range(j, i):
                A[j, i] -= L[i, k] * A[j, k]
            A[j, i] /= L[i, i]
    return True


@kernel
def tip_flexibility(jacobian: Array, root: Array, pads: Array) -> Array:
    """E = J K⁻¹ Jᵀ + pads (3m, 3m) [m/N]; jacobian (3m, nv), root as in `joint_flexibility`, pads (m, 3, 3)."""
    E = joint_flexibility(jacobian, root)
    for i in range(len(pads)):
        for a in range(3):
            for b in range(3):
                E[3 * i + a, 3 * i + b] += pads[i, a, b]
    return E


def read_pads(value: Any, tips: Sequence[str], links: Sequence[str] = ()) -> Pads:
    """From a number, of all links, too; (3,), (3, 3), (n, 3, 3) [m/N], of fingertips; or a mapping by name of a
    fingertip or link of the first three (others: rigid).

    Raises InputError for anything that is not positive semidefinite; UnknownName.
    """
    argument, n = "pad_flexibility", len(tips)
    if isinstance(value, Mapping):
        values = per_name(argument, value, tuple(dict.fromkeys((*tips, *links))), "a fingertip or link")
        given = {name: _pad(f"{argument}[{name!r}]", pad) for name, pad in values.items()}
        return Pads(np.array([given.get(tip, np.zeros((3, 3))) for tip in tips]), given)
    if dimensions(value) == 3:
        stack = array(argument, value, (n, 3, 3))
        return Pads(np.array([psd(f"{argument}[{i}]", block) for i, block in enumerate(stack)]))
    pad = _pad(argument, value)
    return Pads(np.tile(pad, (n, 1, 1)), None, pad if dimensions(value) == 0 else None)


def _pad(argument: str, value: Any) -> Array:
    if isinstance(value, (str, bytes, bool)) or value is None:
        raise InputError(argument, "a flexibility [m/N]: a number, (3,) or (3, 3)", repr(value))
    a = array(argument, value, (), (3,), (3, 3))
    return psd(argument, np.eye(3) * a if a.ndim < 2 else a)
