"""Springs of joints of which some stand still and some tendons are slack, and a fixed point that is found fast."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.model.mechanism import Cables

DEPENDS = 1e-9  # of the longest: rows shorter than this across others say nothing that these do not
_LIMP = 1e-5  # of its stiffness: what a joint keeps that no taut tendon and no spring holds


class Sprung(NamedTuple):
    """Joints of which some stand still, and some tendons are slack. K (nv, nv) : their stiffness. root (nv, m) : C =
    root rootᵀ of those that move, free (nv, nv) : C itself. lost (nv, t) : Rᵀ (t - a), from a.
    """

    K: Array
    root: Array
    free: Array
    lost: Array


def sprung_of(K: Array, gives: Bools, still: Array, cables: Cables, slack: Bools) -> Sprung:
    """Of joints with stiffness K (nv, nv) where all tendons are taut, of which those give way that `gives` (nv,) says.
    still (m, nv) : rows along which nothing moves. slack (t,) : which tendons are.
    """
    nv = len(K)
    lost = np.zeros((nv, len(slack)))
    if slack.any():
        k, R = cables.springs, cables.arms
        # t = 0 of the slack ones, s = -k⁻¹ a of these alone; the others lose what springs between tendons take
        lost[:, slack] = -R[slack].T - R[~slack].T @ np.linalg.solve(k[np.ix_(slack, slack)], k[slack][:, ~slack]).T
        K = _held(K + lost @ (k @ R), K, gives)
    root = np.zeros((nv, nv))
    if gives.any():
        ways = np.eye(nv)[:, gives] @ _across(still[:, gives])  # in which joints can move
        L = np.linalg.cholesky(ways.T @ K @ ways)
        root[:, : ways.shape[1]] = np.linalg.solve(L, ways.T).T
    return Sprung(K, root, root @ root.T, lost)


class Mixed:
    """A fixed point from its iterates: Anderson's mixing of the last ones (Journal of the ACM 12, 1965)."""

    def __init__(self) -> None:
        self._at, self._apart = list[Array](), list[Array]()

    def next(self, at: Array, apart: Array) -> Array:
        """From where an iterate began (m,), and how far from there it ended (m,)."""
        self._at, self._apart = [*self._at[-3:], at], [*self._apart[-3:], apart]
        if len(self._at) == 1:
            return np.asarray(at + apart)
        steps, changes = np.diff(self._at, axis=0), np.diff(self._apart, axis=0)
        share = np.linalg.lstsq(changes.T, apart)[0]
        return np.asarray(at + apart - share @ (steps + changes))


def _across(rows: Array) -> Array:
    """(nv, r) orthonormal basis of what is across rows (m, nv)."""
    if not len(rows):
        return np.eye(rows.shape[1])
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    _, s, Vt = np.linalg.svd(rows / np.where(lengths > 0.0, lengths, 1.0))
    return np.asarray(Vt[int((s > DEPENDS * s.max(initial=0.0)).sum()) :].T)


def _held(K: Array, before: Array, on: Bools) -> Array:
    """K (nv, nv) that leaves no joint without a spring; before (nv, nv) : with all tendons taut. on (nv,) : which."""
    size = np.sqrt(before.diagonal())
    size[size == 0.0] = 1.0
    scaled = (K / np.outer(size, size))[np.ix_(on, on)]
    limp = on.any() and np.linalg.eigvalsh(scaled)[0] < _LIMP
    return K + _LIMP * np.diag(before.diagonal()) if limp else K
