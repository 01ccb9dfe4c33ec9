"""`ContactProblem`: frictional contact in natural units, as solvers take it, and as an LCP with a multiplier a face."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import scipy

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.lazy_property import lazy_property
from handlcp.lcp.kernels.contact_newton import ContactArrays, reorder_problem
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.lcp.problem import LCP, ScaledLCP, Units
from handlcp.tolerances import MIN_ELIMINATION_RCOND

# ----------------------------------------------------------------
# Frictional contact as a complementarity problem with friction as a set: its size does not depend on any faces.


NO_NORMALS = read_only(np.zeros((0, 3)))


@dataclass(frozen=True, slots=True, eq=False)
class FrictionSets:
    """Where the tangential unknowns of each block may be, per unit of its normal unknown.

    limits : (k,) radius of the block's ball, or distance of the faces of its polygon or polyhedron from the axis [-].
    faces : 0 balls; ≥ 3 regular polygons with outward normals at 2πj/m from the first tangent; 2 intervals. Blocks with
        one tangent have an interval in any case.
    normals : (f, 3) outward unit normals of the polyhedra of blocks with three tangents, where there are faces.
    """

    limits: Array
    faces: int
    normals: Array = field(default_factory=lambda: NO_NORMALS)


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """Which role each unknown plays, whatever the numbers. Make it with `Pattern.from_blocks`.

    free : (n,) bool. blocks : (k, 4) indices of a normal unknown and its tangents, -1 for those that there are not.
    role : (n,) 0 free, 1 pair, 2 tangent. order : (n,) the unknowns in the order in which kernels take them: contact by
        contact, then single pairs, then the free ones. A finger's rows meet few columns but its own and the object's,
        so that elimination in this order finds most multipliers zero.
    """

    free: Bools
    blocks: Ints
    role: Ints
    order: Ints

    @staticmethod
    def from_blocks(free: Bools, blocks: Ints) -> Pattern:
        """From the free unknowns and the blocks; blocks (k, 3) have two tangents at most."""
        if blocks.shape[1] < 4:
            blocks = np.pad(blocks, ((0, 0), (0, 4 - blocks.shape[1])), constant_values=-1)
        role = np.where(free, 0, 1)
        role[blocks[:, 1:][blocks[:, 1:] >= 0]] = 2
        in_blocks = blocks[blocks >= 0]
        alone = np.setdiff1d(np.arange(len(free)), in_blocks)
        order = np.concatenate([in_blocks, alone[role[alone] == 1], alone[role[alone] == 0]])
        return Pattern(free, blocks, role, order)


class ContactProblem:
    """Find x with y = M x + q, in natural units, where each unknown plays one of three roles:

    a free one, y_i = 0; one of a pair, 0 ≤ x_i ⟂ y_i ≥ 0; or part of a
    friction block (N, T, …): N is a pair; x_T in the set of the block, x_N times as large, and y_T in minus the set's
        normal cone at x_T: zero inside, against x_T on the limit. For balls this is second-order-cone complementarity.

    M (n, n), q (n,). pattern : roles of the unknowns. sets : of the blocks. units : natural sizes of every x and y, or
    a function that makes them. flat : the sets with m faces in their place, as a function of m; None: nobody knows.
    free, role, blocks, limits and faces are those of the pattern and the sets.
    """

    def __init__(
        self,
        M: Array,
        q: Array,
        pattern: Pattern,
        sets: FrictionSets,
        units: Units | Callable[[], Units],
        flat: Callable[[int], FrictionSets] | None = None,
    ) -> None:
        self.M, self.q, self.pattern, self.sets, self.flat = read_only(M), read_only(q), pattern, sets, flat
        self.n, self.free, self.role, self.blocks = len(q), pattern.free, pattern.role, pattern.blocks
        self.limits, self.faces, self._units = sets.limits, sets.faces, units

    @lazy_property
    def units(self) -> Units:
        """Natural sizes of every x and y."""
        return self._units if isinstance(self._units, Units) else self._units()

    @lazy_property
    def arrays(self) -> ContactArrays:
        """What kernels work on: the problem with its unknowns in the order of its pattern."""
        s, p = self.sets, self.pattern
        return reorder_problem(self.M, self.q, p.role, p.blocks, p.order, s.limits, s.faces, s.normals)

    def with_numbers(self, M: Array, q: Array, limits: Array) -> ContactProblem:
        """Another problem with the same pattern."""
        return ContactProblem(M, q, self.pattern, FrictionSets(limits, self.sets.faces, self.sets.normals), self._units)

    def complete(self) -> None:
        """Compute now what is otherwise computed when first asked for."""
        self.arrays, self.units  # noqa: B018

    def __repr__(self) -> str:
        kind = {0: "exact cone", 2: "planar"}.get(self.faces, f"{self.faces} faces")
        return f"{type(self).__name__}(n={self.n}, {len(self.blocks)} contacts with friction, {kind})"


# ----------------------------------------------------------------
# Friction as a plain LCP: one multiplier for each face of the set that a block's tangential unknowns may be in.
#
#     y_T = -N λ,    0 ≤ λ ⟂ limit · x_N - Nᵀ x_T ≥ 0
#
# with the faces' outward normals in the columns of N. Where the block F of the free unknowns is well conditioned, they
# are eliminated, and a standard LCP is left (paper, equation (17)):
#
#     x_F = x₀ - X x_C,  X = F⁻¹ M_FC,  x₀ = -F⁻¹ q_F,    S = M_CC - M_CF X,  s = q_C + M_CF x₀


class MultiplierLCP(LCP):
    """A contact problem as an `LCP`.

    contact : the contact problem. sets : flat ones to take in place of its own; None: its own. behind : how many pairs,
    the first ones, the multipliers stand behind; None: all. eliminated : whether the free unknowns were. rcond :
    reciprocal condition of their block, which decided that.
    """

    def __init__(self, contact: ContactProblem, sets: FrictionSets | None = None, behind: int | None = None) -> None:
        self.contact = contact
        self._sets = sets = contact.sets if sets is None else sets
        normals = [_face_normals(sets, int((block[1:] >= 0).sum())) for block in contact.blocks]
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
        S, s, self._X, self._x0, self.rcond = _eliminate_free(M, q, c)
        free, self.eliminated = np.arange(len(q)) >= c, self.rcond > MIN_ELIMINATION_RCOND
        free.flags.writeable = False
        if self.eliminated:
            M, q, free, z, w = S, s, free[:c], z[:c], w[:c]
        self._adopt_scaled(ScaledLCP(read_only(M), read_only(q), free, Units(read_only(z), read_only(w))))

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
            slip = contact.M @ x + contact.q
            for block, faces in zip(contact.blocks, self.faces, strict=True):
                if block[3] >= 0:
                    z[at : at + faces] = scipy.optimize.nnls(sets.normals.T, -slip[block[1:]])[0]
                at += faces
        return z[: self.n]


def _face_normals(sets: FrictionSets, tangents: int) -> Array:
    """(tangents, m) outward normals of the faces of a block with so many tangents."""
    if tangents == 1:
        return np.array([[1.0, -1.0]])
    if tangents == 3:
        return sets.normals.T
    return ring_vectors(sets.faces, 0.0)


@lru_cache(maxsize=256)
def ring_vectors(m: int, shift: float) -> Array:
    """(2, m) unit vectors all around, `shift` of a step on from x."""
    a = 2 * np.pi * (np.arange(m) + shift) / m
    ring = np.vstack([np.cos(a), np.sin(a)])
    ring[abs(ring) < 1e-15] = 0.0  # cos(π/2) and its like: an exact zero couples nothing
    return read_only(ring)


def _eliminate_free(M: Array, q: Array, c: int) -> tuple[Array, Array, Array, Array, float]:
    """(S, s, X, x₀, rcond) of the module's docstring; without meaning where rcond, of F, is 0: F is singular."""
    F, rcond = M[c:, c:], 1.0  # 1 / (‖F‖₁ ‖F⁻¹‖₁); 0 where F is singular, 1 where it has no rows
    if len(F):
        try:
            inverse = np.linalg.inv(F)
        except np.linalg.LinAlgError:
            return M, q, F, q[c:], 0.0
        with np.errstate(over="ignore", invalid="ignore"):
            rcond = 1.0 / float(abs(F).sum(axis=0).max() * abs(inverse).sum(axis=0).max())
    if not rcond > 0.0:
        return M, q, F, q[c:], 0.0
    B: Array = np.linalg.solve(F, np.column_stack([M[c:, :c], q[c:]])).astype(float, copy=False)
    X, x0 = B[:, :-1], -B[:, -1]
    return M[:c, :c] - M[:c, c:] @ X, q[:c] + M[:c, c:] @ x0, X, x0, rcond


@kernel
def lift_flat(M: Array, q: Array, x: Array, place: Ints, blocks: Ints, faces: int, at: int, size: int) -> Array:
    """Lift a solution x (n,) of the contact problem to the unknowns z (size,) of the pyramid's.

    z has x at `place` (n,), and from `at` on λ ≥ 0 with Σ λ_j n_j = -y_T for the blocks before the first with three
    tangents: on an end of an interval, or on the two faces of a polygon whose normals enclose the slip y_T of y = M x +
    q.
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
