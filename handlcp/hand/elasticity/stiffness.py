"""Joint stiffness: from what users pass to the root of its inverse."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, number, per_name, read_only, spd
from handlcp.errors import InputError
from handlcp.hand.elasticity.elasticity import Elasticity, Transmission


class JointStiffness(Elasticity):
    """Stiffness K of the joints [N·m/rad], positive definite; inf on the diagonal: rigid. A = L⁻ᵀ for K = L Lᵀ."""

    def __init__(self, matrix: Array, uniform: bool = False) -> None:
        rigid = np.isinf(np.diagonal(matrix))
        L = np.linalg.cholesky(np.where(np.isinf(matrix), 1.0, matrix))
        A = np.asarray(np.linalg.inv(L).T, dtype=float)
        A[rigid] = 0.0
        super().__init__(A)
        self._matrix, self.uniform = read_only(matrix), uniform

    @property
    def matrix(self) -> Array:
        """(nv, nv) K [N·m/rad]; inf on the diagonal of a rigid joint."""
        return self._matrix

    def stiffer(self, factor: float) -> JointStiffness:
        """The same with every spring so many times as stiff."""
        return JointStiffness(self._matrix * factor, self.uniform)

    def by_joint(self, factors: Array) -> JointStiffness:
        """The same with the spring of each joint so many times as stiff, f (nv,) > 0; K_ij grows by √(f_i f_j)."""
        made, by = copy(self), np.sqrt(factors)
        made._matrix, made.root = read_only(self._matrix * by * by[:, None]), read_only(self.root / by[:, None])
        return made


def read_stiffness(value: Any, joints: Sequence[str], argument: str = "joint_stiffness") -> Elasticity:
    """From a number, a mapping by joint name, (nv,), an SPD matrix (nv, nv) [N·m/rad], or a transmission.

    None and inf are rigid. Raises InputError (not positive, not SPD, a joint left out), UnknownName.
    """
    if isinstance(value, Transmission):
        return value.for_joints(joints)
    if isinstance(value, Mapping):
        values = per_name(argument, value, joints, "a joint")
        if missing := [name for name in joints if name not in values]:
            expected = f"a stiffness for every joint (numpy.inf: rigid), {', '.join(missing)} included"
            raise InputError(argument, expected, f"only {sorted(values)}")
        return JointStiffness(np.diag([_stiffness(f"{argument}[{name!r}]", values[name]) for name in joints]))
    diagonal = springs(argument, value, joints, _stiffness)
    if diagonal is not None:
        return JointStiffness(diagonal, uniform=dimensions(value) == 0)
    square = (len(joints), len(joints))
    matrix = array(argument, value, square, what="N·m/rad, finite, one row for each joint,")
    return JointStiffness(spd(argument, matrix))


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


def _stiffness(argument: str, value: Any) -> float:
    return np.inf if value is None else number(argument, value, above=0.0, finite=False)
