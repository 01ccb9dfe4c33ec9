"""The flexibility of many contacts as a factor: E = J K⁻¹ Jᵀ + P, with K⁻¹ = A Aᵀ of the joints and P of the pads.

E has the rank of the joints plus blocks of three. With 60 contacts it has 32,400 entries and its factor a tenth of
them; a solve that keeps the factor costs as much for each further contact as for the first
(`lcp/kernels/contact_blocks.py`). Where E is asked for as a matrix, or something else adds to it, it is formed.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

import numpy as np

from handlcp.check import Array, array, psd, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.kind import block_diagonal
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.keywords import helped_init
from handlcp.lazy import lazy

T = TypeVar("T")


class Factor(NamedTuple):
    """For kernels: rows (3n, nv) J, root (nv, m) A, pads (n, 3, 3) P."""

    rows: Array
    root: Array
    pads: Array


@helped_init()
class Flexibility:
    """E = J K⁻¹ Jᵀ + P of n contacts, without the matrix; pass it as `flexibility=` of a `Grasp`.

    jacobian : (3n, nv) velocity of the contact points in contact axes [m/rad]. root : (nv, m) A of the joints'
    compliance K⁻¹ = A Aᵀ [rad/(N·m)]; of joints with one stiffness k each, diag(1 / √k). pads : (n, 3, 3) blocks of
    what gives way at each contact alone, in contact axes [m/N].
    Immutable. Raises InputError.
    """

    def __init__(self, jacobian: Any, root: Any, pads: Any) -> None:
        J = array("Flexibility.jacobian", jacobian, (-1, -1))
        A = array("Flexibility.root", root, (J.shape[1], -1))
        if J.shape[0] % 3:
            raise InputError("Flexibility.jacobian", "three rows a contact", J.shape)
        P = array("Flexibility.pads", pads, (J.shape[0] // 3, 3, 3))
        own = read_only(np.array([psd(f"Flexibility.pads[{i}]", block) for i, block in enumerate(P)]).reshape(P.shape))
        self.factor = Factor(J, A, own)

    @classmethod
    def of(cls, factor: Factor) -> Flexibility:
        """From sound arrays, read-only."""
        made = cls.__new__(cls)
        made.factor = factor
        return made

    @property
    def shape(self) -> tuple[int, int]:
        """Of the matrix."""
        return (len(self.factor.rows), len(self.factor.rows))

    def any(self) -> bool:
        """Whether anything gives way."""
        return bool(self.factor.pads.any() or (self.factor.rows.any() and self.factor.root.any()))

    @lazy
    def matrix(self) -> Array:
        """(3n, 3n) E [m/N]."""
        J, A, P = self.factor
        return read_only(joint_flexibility(J, A) + block_diagonal(P, len(P)))

    def __reduce__(self) -> tuple[Any, ...]:
        return Flexibility, tuple(self.factor)

    def __repr__(self) -> str:
        (rows, nv), n = self.factor.rows.shape, len(self.factor.pads)
        return f"Flexibility({n} contacts, {nv} joints, {rows} components)"


def flexible(kind: type[T]) -> type[T]:
    """Decorates dataclasses with a field `flexibility`: it holds E as it was given (`kept`), and reads as a matrix."""
    kind.flexibility = _AsMatrix()  # type: ignore[attr-defined]
    return kind


class _AsMatrix:
    def __get__(self, instance: Any, owner: type[Any]) -> Any:
        return self if instance is None else matrix_of(instance.__dict__["flexibility"])

    def __set__(self, instance: Any, value: Array | Flexibility) -> None:
        instance.__dict__["flexibility"] = value


def matrix_of(E: Array | Flexibility) -> Array:
    """(c, c) E [m/N]."""
    return E.matrix if isinstance(E, Flexibility) else E


def kept(of: Any) -> Array | Flexibility:
    """The flexibility of a specification or a scene as it was given."""
    value: Array | Flexibility = of.__dict__["flexibility"]
    return value
