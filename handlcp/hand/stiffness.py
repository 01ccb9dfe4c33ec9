"""Joint stiffness: what users pass, turned into a factor once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtrs

from handlcp.check import Array, array, dimensions, number, read_only, spd
from handlcp.errors import InputError, UnknownName
from handlcp.hand.elasticity import Elasticity, Softener, Transmission
from handlcp.hand.posture import flexibility

__all__ = ["JointStiffness", "per_name", "read_stiffness"]


class JointStiffness(Elasticity):
    """K over the independent joints, kept as a factor of its inverse; a rigid joint deflects by nothing.

    `matrix`: (nv, nv) [N·m/rad]; the diagonal holds inf for rigid joints. `uniform`: one number was given for all
    joints.
    """

    __slots__ = ("_factor", "_matrix", "_root", "uniform")

    def __init__(self, matrix: Array, uniform: bool = False) -> None:
        self._matrix, self.uniform = read_only(matrix), uniform
        diagonal = np.diagonal(matrix)
        off = matrix - np.diag(np.where(np.isfinite(diagonal), diagonal, 0.0))
        self._root: Array | None = None  # 1/√k, when K is diagonal
        self._factor: Array | None = None  # L with K = L Lᵀ, when it is not
        if np.any(off[np.isfinite(off)]):
            self._factor = dpotrf(matrix, lower=1, clean=1)[0]
        else:
            self._root = 1.0 / np.sqrt(diagonal)

    @property
    def matrix(self) -> Array:
        """(nv, nv) K [N·m/rad]; inf on the diagonal of a rigid joint."""
        return self._matrix

    @property
    def root(self) -> Array:
        """(nv, nv) L⁻ᵀ with K = L Lᵀ."""
        if self._root is not None:
            return np.diag(self._root)
        return np.asarray(dtrtrs(self._factor, np.eye(len(self._matrix)), lower=1)[0].T)

    def softener(self) -> Softener:
        """By substitution with L (inf on the diagonal of a rigid joint)."""
        diagonal = self._factor is None
        factor = np.diag(np.sqrt(np.diagonal(self._matrix))) if diagonal else np.ascontiguousarray(self._factor)
        return lambda J, pads, E: flexibility(J, factor, pads, E)

    def compliance(self, J: Array) -> Array:
        """J K⁻¹ Jᵀ = B Bᵀ, symmetric to the last bit; J (m, nv), result (m, m)."""
        B = J * self._root if self._root is not None else dtrtrs(self._factor, J.T, lower=1)[0].T
        return np.asarray(B @ B.T)

    def deflection(self, torque: Array) -> Array:
        """K⁻¹ τ [rad] for torques (nv,) [N·m]."""
        if self._root is not None:
            return np.asarray(torque * self._root * self._root)
        y = dtrtrs(self._factor, torque, lower=1)[0]
        return np.asarray(dtrtrs(self._factor, y, lower=1, trans=1)[0])


def read_stiffness(value: Any, joints: Sequence[str], argument: str = "joint_stiffness") -> Elasticity:
    """A number, a mapping by joint name (all of them), (nv,) or a full SPD matrix (nv, nv) [N·m/rad]; None or inf is
    rigid. A transmission says itself what it makes of the joints.

    Raises InputError (a stiffness that is not positive, a matrix that is not SPD, a joint left out), UnknownName.
    """
    n = len(joints)
    if isinstance(value, Transmission):
        return value.for_joints(joints)
    if isinstance(value, Mapping):
        values = per_name(argument, value, joints, "a joint")
        missing = [name for name in joints if name not in values]
        if missing:
            raise InputError(
                argument,
                f"a stiffness for every joint (numpy.inf: rigid), {', '.join(missing)} included",
                f"only {sorted(values)}",
            )
        return JointStiffness(np.diag([_stiffness(f"{argument}[{name!r}]", values[name]) for name in joints]))
    if value is None or isinstance(value, (int, float)) or dimensions(value) == 0:
        return JointStiffness(np.diag(np.full(n, _stiffness(argument, value))), uniform=True)
    if _is_vector(value):
        if len(value) != n:
            raise InputError(argument, f"{n} values, one for each of {', '.join(joints)}", f"{len(value)} of them")
        return JointStiffness(np.diag([_stiffness(f"{argument}[{i}]", k) for i, k in enumerate(value)]))
    return JointStiffness(
        spd(argument, array(argument, value, (n, n), what="N·m/rad, finite, one row for each joint,")).copy()
    )


def per_name(argument: str, values: Mapping[Any, Any], names: Sequence[str], kind: str) -> dict[str, Any]:
    """The mapping with its keys checked against `names`. Raises UnknownName, listing them."""
    unknown = [str(key) for key in values if key not in names]
    if unknown:
        raise UnknownName(argument, kind, unknown, names)
    return dict(values)


def _stiffness(argument: str, value: Any) -> float:
    return np.inf if value is None else number(argument, value, above=0.0, finite=False)


def _is_vector(value: Any) -> bool:
    return (
        isinstance(value, (Sequence, np.ndarray))
        and not isinstance(value, (str, bytes))
        and all(v is None or dimensions(v) == 0 for v in value)
    )
