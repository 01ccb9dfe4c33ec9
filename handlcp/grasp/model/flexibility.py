"""`Flexibility`: the flexibility of many contacts as a factor: E = J K⁻¹ Jᵀ + P of joints and pads.

E has the rank of the joints plus blocks of three. With 60 contacts it has 32,400 entries and its factor a tenth of
them; a solve that keeps the factor costs as much for each further contact as for the first
(`contact/block_newton.py`). Where E is asked for as a matrix, or something else adds to it, it is formed.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

import numpy as np

from handlcp.check import Array, Ints, check_array, check_init_call, check_psd, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.contact import block_diagonal
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.lazy_property import lazy_property
from handlcp.lcp.kernels.dense import kernel

T = TypeVar("T")


class FlexibilityFactor(NamedTuple):
    """What E = J A Aᵀ Jᵀ + P is made of, as kernels take it.

    rows (3n, nv) : J, of the contacts.
    root (nv, m) : A, of the joints' compliance C = A Aᵀ.
    pads (n, 3, 3) : P, of the fingertips.
    """

    rows: Array
    root: Array
    pads: Array


@check_init_call()
class Flexibility:
    """E = J K⁻¹ Jᵀ + P of n contacts, without the matrix; pass it as `flexibility=` of a `Grasp`.

    jacobian : (3n, nv) velocity of the contact points in contact axes [m/rad]. root : (nv, m) A of the joints'
    compliance K⁻¹ = A Aᵀ [rad/(N·m)]; of joints with one stiffness k each, diag(1 / √k). pads : (n, 3, 3) blocks of
    what gives way at each contact alone, in contact axes [m/N].
    Immutable. Raises InputError.
    """

    def __init__(self, jacobian: Any, root: Any, pads: Any) -> None:
        J = check_array("Flexibility.jacobian", jacobian, (-1, -1))
        A = check_array("Flexibility.root", root, (J.shape[1], -1))
        if J.shape[0] % 3:
            raise InputError("Flexibility.jacobian", "three rows a contact", J.shape)
        P = check_array("Flexibility.pads", pads, (J.shape[0] // 3, 3, 3))
        own = read_only(
            np.array([check_psd(f"Flexibility.pads[{i}]", block) for i, block in enumerate(P)]).reshape(P.shape)
        )
        self.factor = FlexibilityFactor(J, A, own)

    @classmethod
    def from_factor(cls, factor: FlexibilityFactor) -> Flexibility:
        """From sound arrays, read-only."""
        made = cls.__new__(cls)
        made.factor = factor
        return made

    @property
    def shape(self) -> tuple[int, int]:
        """The shape (3n, 3n) that the matrix has."""
        return (len(self.factor.rows), len(self.factor.rows))

    def any(self) -> bool:
        """Whether anything gives way."""
        return bool(self.factor.pads.any() or (self.factor.rows.any() and self.factor.root.any()))

    @lazy_property
    def matrix(self) -> Array:
        """The flexibility E (3n, 3n) as a matrix [m/N]."""
        J, A, P = self.factor
        return read_only(joint_flexibility(J, A) + block_diagonal(P, len(P)))

    def __reduce__(self) -> tuple[Any, ...]:
        return Flexibility, tuple(self.factor)

    def __repr__(self) -> str:
        (rows, nv), n = self.factor.rows.shape, len(self.factor.pads)
        return f"Flexibility({n} contacts, {nv} joints, {rows} components)"


def holds_flexibility(kind: type[T]) -> type[T]:
    """Decorates dataclasses with a field `flexibility`: it holds E as it was given (`kept`), and reads as a matrix."""
    kind.flexibility = _MatrixField()  # type: ignore[attr-defined]
    return kind


class _MatrixField:
    def __get__(self, instance: Any, owner: type[Any]) -> Any:
        return self if instance is None else flexibility_matrix(instance.__dict__["flexibility"])

    def __set__(self, instance: Any, value: Array | Flexibility) -> None:
        instance.__dict__["flexibility"] = value


def flexibility_matrix(E: Array | Flexibility) -> Array:
    """The flexibility as a matrix E (c, c) [m/N], however it is stored."""
    return E.matrix if isinstance(E, Flexibility) else E


def stored_flexibility(of: Any) -> Array | Flexibility:
    """The flexibility of a specification or a scene as it was given."""
    value: Array | Flexibility = of.__dict__["flexibility"]
    return value


# ----------------------------------------------------------------
# The factor of a flexibility that was given as one matrix: E = B Bᵀ + P, few columns in B, blocks of three in P.
#
# That is what a hand gives: joints that several contacts share, and pads of each contact alone. Off the blocks E is B
# Bᵀ, and of a matrix of low rank that determines the blocks as well. With rows p and columns q of other contacts than
# i,
#
#     (B Bᵀ)_ii = E_iq E_pq⁻¹ E_pi
#
# Contacts are split into those that pivots p and q are taken from, and the others, whose blocks follow. The columns of
# the others, factored as Cholesky does, are columns of B. What is left couples fewer contacts, and is treated likewise;
# what couples no more than two of them is shared between both.
#
# All is done for contacts that are coupled, a finger at a time, in units in which each contact gives way by one.


# Contacts from which on a factor is looked for: of fewer there is often no telling which it is
MIN_CONTACTS_TO_FACTOR = 30
_NO_COUPLING = 1e-12  # of the largest: no coupling
_MIN_COMPLIANCE_SHARE = 1e-10  # of the largest: no direction, and the least that a pad gives way
_REPEAT_PIVOT_SHARE = 0.1  # a pivot of contacts that had one before, so that many are left whose blocks follow
_SAMPLE_CONTACTS = 10  # contacts on both sides of the first look
_MAX_JACOBI_SWEEPS = 8  # of Jacobi's method on three columns: more than rounding leaves to do


def find_factor(E: Array) -> Flexibility | None:
    """The factor of E (3n, 3n); None where it is no hand's."""
    found, B, P = factorise(E)
    return (
        Flexibility.from_factor(FlexibilityFactor(read_only(B), read_only(np.eye(B.shape[1])), read_only(P)))
        if found
        else None
    )


@kernel
def factorise(E: Array) -> tuple[bool, Array, Array]:
    """(whether it is one, B (3n, m), P (n, 3, 3)) of E (3n, 3n), symmetric; m is at most the number of contacts."""
    n = len(E) // 3
    B, P, size, m = np.zeros((3 * n, n)), np.empty((n, 3, 3)), np.empty(n), 0
    for i in range(n):
        size[i] = np.sqrt(max(E[3 * i, 3 * i], E[3 * i + 1, 3 * i + 1], E[3 * i + 2, 3 * i + 2]))
        if not size[i] > 0.0:
            return False, B, P
    label = _coupled_groups(E, size)
    for group in range(n):
        members = np.flatnonzero(label == group)
        if len(members) == 0:
            break
        R = np.empty((3 * len(members), 3 * len(members)))
        for a in range(len(members)):
            for b in range(len(members)):
                i, j = 3 * members[a], 3 * members[b]
                scale = 1.0 / (size[members[a]] * size[members[b]])
                for k in range(9):
                    R[3 * a + k // 3, 3 * b + k % 3] = E[i + k // 3, j + k % 3] * scale
        own = np.zeros((len(R), n - m))
        count = _peel_columns(R, own) if len(members) < 4 or _is_low_rank(R) else -1
        if count < 0:
            return False, B, P
        for a in range(len(members)):
            i, s = members[a], size[members[a]]
            for k in range(3):
                for j in range(count):
                    B[3 * i + k, m + j] = own[3 * a + k, j] * s
                for j in range(3):
                    P[i, k, j] = R[3 * a + k, 3 * a + j] * s * s
        m += count
    return True, B[:, :m].copy(), P


@kernel
def _coupled_groups(E: Array, size: Array) -> Ints:
    """(n,) which group of coupled contacts each belongs to, numbered from 0."""
    n, count = len(size), 0
    label, todo = np.full(n, -1), np.empty(n, np.int64)
    for first in range(n):
        if label[first] >= 0:
            continue
        label[first], todo[0], known = count, first, 1
        at = 0
        while at < known:
            i = todo[at]
            at += 1
            for j in range(n):
                if label[j] >= 0:
                    continue
                least, linked = _NO_COUPLING * size[i] * size[j], False
                for k in range(9):
                    linked = linked or abs(E[3 * i + k // 3, 3 * j + k % 3]) > least
                if linked:
                    label[j], todo[known] = count, j
                    known += 1
        count += 1
    return label


@kernel
def _is_low_rank(R: Array) -> bool:
    """Whether every other of the first contacts is coupled to those between them by fewer columns than it could be."""
    n = min(len(R) // 3, 2 * _SAMPLE_CONTACTS)
    rows = n // 2
    A = np.empty((3 * rows, 3 * rows))
    for i in range(rows):
        for j in range(rows):
            for k in range(9):
                A[3 * i + k // 3, 3 * j + k % 3] = R[6 * i + k // 3, 6 * j + 3 + k % 3]
    for s in range(len(A)):
        best, p, q = _NO_COUPLING, -1, -1
        for i in range(s, len(A)):
            for j in range(s, len(A)):
                if abs(A[i, j]) > best:
                    best, p, q = abs(A[i, j]), i, j
        if p < 0:
            return True
        for j in range(len(A)):
            A[s, j], A[p, j] = A[p, j], A[s, j]
        for i in range(len(A)):
            A[i, s], A[i, q] = A[i, q], A[i, s]
        for i in range(s + 1, len(A)):
            f = A[i, s] / A[s, s]
            for j in range(s, len(A)):
                A[i, j] -= f * A[s, j]
    return False


@kernel
def _peel_columns(R: Array, B: Array) -> int:
    """Take B Bᵀ from R (3g, 3g) until only blocks are left, writing B (3g, ·). Returns how many columns; -1: too many,
    or a block that gives way in no direction of its own.
    """
    g, m = len(R) // 3, 0
    while True:
        W = R.copy()
        for i in range(g):
            W[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = 0.0
        side = np.zeros(g, np.int64)
        rank, i, j = _cross_eliminate(W, side)
        if rank == 0:
            break
        new = _write_columns(R, W, side, B[:, m:]) if m + rank <= B.shape[1] else -1
        if new == 0:
            new = _write_shared_columns(R, i, j, B[:, m:])
        if new < 0:
            return -1
        for k in range(m, m + new):
            for a in range(len(R)):
                f = B[a, k]
                if f != 0.0:
                    for b in range(len(R)):
                        R[a, b] -= f * B[b, k]
        m += new
    return m if _is_positive_definite(R) else -1


@kernel
def _cross_eliminate(W: Array, side: Ints) -> tuple[int, int, int]:
    """Eliminate W with pivots off the blocks, its rank and the contacts of the largest entry. side (g,) : contacts that
    gave a row, 1, or a column, 2; the blocks of all others become minus those of B Bᵀ.
    """
    g, rank, first, second = len(side), 0, 0, 0
    while True:
        best, again, p, q, p2, q2 = _NO_COUPLING, _NO_COUPLING, -1, -1, -1, -1
        for i in range(g):
            if side[i] == 2:
                continue
            for j in range(g):
                if side[j] == 1 or i == j:
                    continue
                both = side[i] == 1 and side[j] == 2
                for k in range(9):
                    a, b = 3 * i + k // 3, 3 * j + k % 3
                    value = abs(W[a, b])
                    if value > best:
                        best, p, q = value, a, b
                    if both and value > again:
                        again, p2, q2 = value, a, b
        if p < 0:
            return rank, first, second
        if rank == 0:
            first, second = p // 3, q // 3
        if again > _REPEAT_PIVOT_SHARE * best:
            p, q = p2, q2
        side[p // 3], side[q // 3] = 1, 2
        rank += 1
        top, pivot = W[p].copy(), 1.0 / W[p, q]
        for i in range(len(W)):
            f = W[i, q] * pivot
            if f != 0.0 and side[i // 3] != 2:
                for j in range(len(W)):
                    W[i, j] -= f * top[j]


@kernel
def _write_columns(R: Array, W: Array, side: Ints, B: Array) -> int:
    """Write the columns of Cholesky's factor whose pivots belong to contacts of no side. Returns how many."""
    size, count = len(R), 0
    left = np.zeros(size)
    for a in range(size):
        if side[a // 3] == 0:
            left[a] = -W[a, a]
    while count < B.shape[1]:
        p = 0
        for a in range(size):
            if left[a] > left[p]:
                p = a
        if not left[p] > _MIN_COMPLIANCE_SHARE:
            break
        i, scale = p // 3, 1.0 / np.sqrt(left[p])
        for a in range(size):
            value = R[a, p] if a // 3 != i else -0.5 * (W[a, p] + W[p, a])
            for k in range(count):
                value -= B[a, k] * B[p, k]
            B[a, count] = value * scale
            left[a] -= B[a, count] ** 2
        count += 1
    return count


@kernel
def _write_shared_columns(R: Array, i: int, j: int, B: Array) -> int:
    """Write columns that couple contacts i and j as R does, in equal shares of what both give way. Returns how many."""
    G, H, X = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    if not (_write_cholesky(R, 3 * i, G) and _write_cholesky(R, 3 * j, H)):
        return -1
    for a in range(3):  # X = G⁻¹ R_ij H⁻ᵀ
        for b in range(3):
            X[a, b] = R[3 * i + a, 3 * j + b]
            for k in range(a):
                X[a, b] -= G[a, k] * X[k, b]
            X[a, b] /= G[a, a]
    for a in range(3):
        for b in range(3):
            for k in range(b):
                X[a, b] -= X[a, k] * H[b, k]
            X[a, b] /= H[b, b]
    V, count = _orthogonalise_columns(X), 0
    for c in range(3):
        strength = np.sqrt(X[0, c] ** 2 + X[1, c] ** 2 + X[2, c] ** 2)
        if strength > _NO_COUPLING:
            if count == B.shape[1] or not strength < 1.0 - _MIN_COMPLIANCE_SHARE:
                return -1
            half = np.sqrt(strength)
            for a in range(3):
                for k in range(a + 1):
                    B[3 * i + a, count] += G[a, k] * X[k, c] / half
                    B[3 * j + a, count] += H[a, k] * V[k, c] * half
            count += 1
    return count


@kernel
def _orthogonalise_columns(X: Array) -> Array:
    """Turn the columns of X (3, 3) until each is across the others (Jacobi). Returns V (3, 3): X before was X Vᵀ."""
    V = np.eye(3)
    for _ in range(_MAX_JACOBI_SWEEPS):
        for a, b in ((0, 1), (0, 2), (1, 2)):  # the longer one comes first
            aa = X[0, a] ** 2 + X[1, a] ** 2 + X[2, a] ** 2
            bb = X[0, b] ** 2 + X[1, b] ** 2 + X[2, b] ** 2
            ab = X[0, a] * X[0, b] + X[1, a] * X[1, b] + X[2, a] * X[2, b]
            angle = 0.5 * np.arctan2(2.0 * ab, aa - bb)
            x, y = np.cos(angle), np.sin(angle)
            for k in range(3):
                X[k, a], X[k, b] = x * X[k, a] + y * X[k, b], x * X[k, b] - y * X[k, a]
                V[k, a], V[k, b] = x * V[k, a] + y * V[k, b], x * V[k, b] - y * V[k, a]
    return V


@kernel
def _write_cholesky(R: Array, at: int, G: Array) -> bool:
    """Write Cholesky's factor of the block that begins there. Returns whether it gives way in all directions."""
    for a in range(3):
        for b in range(a + 1):
            value = R[at + a, at + b]
            for k in range(b):
                value -= G[a, k] * G[b, k]
            if a > b:
                G[a, b] = value / G[b, b]
            elif value > _MIN_COMPLIANCE_SHARE:
                G[a, a] = np.sqrt(value)
            else:
                return False
    return True


@kernel
def _is_positive_definite(R: Array) -> bool:
    """Whether every block gives way in all directions."""
    G = np.empty((3, 3))
    found = True
    for i in range(len(R) // 3):
        found = found and _write_cholesky(R, 3 * i, G)
    return found
