"""Friction as a plain LCP: one multiplier for each face of the set that a block's tangential unknowns may be in.

    y_T = -N λ,    0 ≤ λ ⟂ limit · x_N - Nᵀ x_T ≥ 0

with the faces' outward normals in the columns of N. Where the block F of the free unknowns is well conditioned, they
are eliminated, and a standard LCP is left (paper, equation (17)):

    x_F = x₀ - X x_C,  X = F⁻¹ M_FC,  x₀ = -F⁻¹ q_F,    S = M_CC - M_CF X,  s = q_C + M_CF x₀
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.lcp.contact import ContactProblem, FrictionSets
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.lcp.problem import LCP, Scaled
from handlcp.lcp.scaling import Units
from handlcp.tolerances import ELIMINATE_RCOND


class WithMultipliers(LCP):
    """A contact problem as an `LCP`.

    contact : the contact problem. sets : flat ones to take in place of its own; None: its own. behind : how many pairs,
    the first ones, the multipliers stand behind; None: all. eliminated : whether the free unknowns were. rcond :
    reciprocal condition of their block, which decided that.
    """

    def __init__(self, contact: ContactProblem, sets: FrictionSets | None = None, behind: int | None = None) -> None:
        self.contact = contact
        self._sets = sets = contact.sets if sets is None else sets
        normals = [_normals(sets, int((block[1:] >= 0).sum())) for block in contact.blocks]
        self.faces = tuple([N.shape[1] for N in normals])
        count, many, pairs = contact.n, sum(self.faces), int((contact.role == 1).sum())
        first = pairs if behind is None else behind
        at = np.arange(count)
        self._place = at + many * (at >= first)  # of the unknowns of the contact problem
        M, q = np.zeros((count + many,) * 2), np.zeros(count + many)
        M[np.ix_(self._place, self._place)], q[self._place] = contact.M, contact.q
        self._whole = len(q)  # unknowns before any are eliminated
        z, w = np.empty(len(q)), np.empty(len(q))
        z[self._place], w[self._place] = contact.units.z, contact.units.w
        self._multipliers = slice(first, first + many)
        for block, limit, N in zip(contact.blocks, sets.limits, normals, strict=True):
            own, tangents = slice(first, first + N.shape[1]), self._place[block[1 : 1 + len(N)]]
            M[tangents, own], M[own, tangents], M[own, block[0]] = N, -N.T, limit
            z[own], w[own] = w[tangents[0]], z[block[0]]
            first = own.stop
        c = pairs + many
        S, s, self._X, self._x0, self.rcond = _eliminated(M, q, c)
        free, self.eliminated = np.arange(len(q)) >= c, self.rcond > ELIMINATE_RCOND
        free.flags.writeable = False
        if self.eliminated:
            M, q, free, z, w = S, s, free[:c], z[:c], w[:c]
        self._hold(Scaled(read_only(M), read_only(q), free, Units(read_only(z), read_only(w))))

    def back(self, z: Array) -> Array:
        """(n,) x of the contact problem from z of this one, natural units."""
        if self.eliminated:
            z = np.concatenate([z, self._x0 - self._X @ z])
        return np.asarray(z[self._place])

    def lift(self, x: Array) -> Array:
        """(n,) z of this problem from x of the contact problem, natural units: multipliers follow from the slip y_T."""
        contact, sets, at = self.contact, self._sets, self._multipliers.start
        z = lift_flat(contact.M, contact.q, x, self._place, contact.blocks, sets.faces, at, self._whole)
        if len(sets.normals) and (contact.blocks[:, 3] >= 0).any():
            from scipy.optimize import nnls  # half a second of import that only soft contacts should pay

            slip = contact.M @ x + contact.q
            for block, faces in zip(contact.blocks, self.faces, strict=True):
                if block[3] >= 0:
                    z[at : at + faces] = nnls(sets.normals.T, -slip[block[1:]])[0]
                at += faces
        return z[: self.n]


def _normals(sets: FrictionSets, tangents: int) -> Array:
    """(tangents, m) outward normals of the faces of a block with so many tangents."""
    if tangents == 1:
        return np.array([[1.0, -1.0]])
    if tangents == 3:
        return sets.normals.T
    angles = 2 * np.pi * np.arange(sets.faces) / sets.faces
    normals = np.vstack([np.cos(angles), np.sin(angles)])
    normals[abs(normals) < 1e-15] = 0.0  # cos(π/2) and its like: an exact zero couples nothing
    return normals


def _eliminated(M: Array, q: Array, c: int) -> tuple[Array, Array, Array, Array, float]:
    """(S, s, X, x₀, rcond) of the module's docstring; without meaning where rcond, of F, is 0: F is singular."""
    F = M[c:, c:]
    rcond = _rcond(F)
    if rcond == 0.0:
        return M, q, F, q[c:], rcond
    B: Array = np.linalg.solve(F, np.column_stack([M[c:, :c], q[c:]])).astype(float, copy=False)
    X, x0 = B[:, :-1], -B[:, -1]
    return M[:c, :c] - M[:c, c:] @ X, q[:c] + M[:c, c:] @ x0, X, x0, rcond


def _rcond(F: Array) -> float:
    """1 / (‖F‖₁ ‖F⁻¹‖₁); 0 where F is singular, 1 where it has no rows."""
    if not len(F):
        return 1.0
    try:
        inverse = np.linalg.inv(F)
    except np.linalg.LinAlgError:
        return 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        rcond = 1.0 / float(abs(F).sum(axis=0).max() * abs(inverse).sum(axis=0).max())
    return rcond if rcond == rcond else 0.0


@kernel
def lift_flat(M: Array, q: Array, x: Array, place: Ints, blocks: Ints, faces: int, at: int, size: int) -> Array:
    """(size,) z for x (n,). It has x at `place` (n,), and from `at` on λ ≥ 0 with Σ λ_j n_j = -y_T for the blocks
    before the first with three tangents: on an end of an interval, or on the two faces of a polygon whose normals
    enclose the slip y_T of y = M x + q.
    """
    z, slip, step = np.zeros(size), np.empty(len(q)), 2.0 * np.pi / max(faces, 1)
    multiply_add(M, x, q, slip)
    for i in range(len(x)):
        z[place[i]] = x[i]
    for k in range(len(blocks)):
        if blocks[k, 3] >= 0:
            break
        a = -slip[blocks[k, 1]]
        if blocks[k, 2] < 0:
            z[at], z[at + 1] = max(a, 0.0), max(-a, 0.0)
            at += 2
            continue
        b = -slip[blocks[k, 2]]
        angle = np.arctan2(b, a) % (2.0 * np.pi)
        first = int(angle / step)
        rest = angle - first * step
        length = np.hypot(a, b) / np.sin(step)
        z[at + first % faces] = length * max(np.sin(step - rest), 0.0)
        z[at + (first + 1) % faces] += length * max(np.sin(rest), 0.0)
        at += faces
    return z
