"""How far the forces of an answer are from those that solve its laws exactly: an estimate from the answer itself.

The laws are rows F(x) = 0, y = M x + q (Alart & Curnier 1991, as in `kernels.contact`), ρ > 0 a scale for each contact:

    free F = y     pair F = ρ y (it touches) or x (it is open)     stick F = ρ y_T     slide F = x_T - μ x_N e

with e = (x_T - ρ y_T) / |x_T - ρ y_T|. In a piece, a choice for every contact, F is smooth with derivative J. Then

    |Δx| ≤ |J⁻¹ F| + |J⁻¹| δ

to first order: Newton's step, and what rounding can have done to F in making M, q and y, entry by entry (Higham,
Accuracy and Stability of Numerical Algorithms, 2002, section 7.2). Where J is singular, something is not determined:
its pseudoinverse leaves that out, so that any member of the family counts as exact.

A contact so near the border between two choices that this very bound covers it may be on either side: every choice of
these contacts is a piece of its own, and the largest bound counts.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.answer.make_solution import candidate_of
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.contact_form import GraspContact
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact_rows import row_scales
from handlcp.tolerances import ACTIVE, RANK

__all__ = ["force_error"]

_EPS = float(np.finfo(float).eps)
_ROUNDING = 4.0 * _EPS  # of a sum, over the sum of its terms' sizes: data, product and sum
_MOST_DOUBTFUL = 5  # contacts on a border whose 2^k choices are all looked at; of more, each alone and all at once
_REGULAR = 1e-9  # 1 / condition above which J is inverted; below, its rank is looked at


class _Problem(NamedTuple):
    """M (n, n), role (n,), blocks (k, 4), limits (k,) of a contact problem on the cone, and x (n,)."""

    M: Array
    role: Ints
    blocks: Ints
    limits: Array
    x: Array


class _Look(NamedTuple):
    """What the rows are at x: y = M x + q (n,), what rounding can have done to it (n,), ρ (n,); which pairs touch (n,),
    which blocks stick (k,); of x_T - ρ y_T the length (k,) and direction (k, 2), and the limit μ x_N (k,).
    """

    y: Array
    noise: Array
    rho: Array
    touch: Bools
    stick: Bools
    size: Array
    along: Array
    radius: Array


def force_error(problem: GraspContact, solution: GraspSolution) -> float:
    """The largest error of a contact force, over the largest contact force, that the answer to `problem` may have.

    Where no finger pushes (to the share `ACTIVE` of load and squeeze) it is over the natural unit of force instead.

    problem : with the cone or the planar interval as its section, without soft contacts. solution : certified for it.
    """
    scene, at = problem.scene, problem.system.at
    x = problem.natural(candidate_of(scene, solution))
    p = _Problem(problem.M, problem.role, problem.blocks, problem.limits, x)
    look = _look(p, problem.q, _reach(problem), at["u"].start, scene.dof)
    bound = _bound(p, look, look.touch, look.stick)
    pairs, blocks = _doubtful(p, look, bound)
    if pairs.any() or blocks.any():
        for flip, turn in _choices(pairs, blocks):
            bound = np.maximum(bound, _bound(p, look, look.touch ^ flip, look.stick ^ turn))
    off = np.zeros(3 * scene.n)
    for name, index in (("r_N", scene.kind.normal_index), ("r_T", scene.kind.tangent_index)):
        if name in at:
            off[index] = bound[at[name]]
    size = float(np.sqrt((solution.forces**2).sum(axis=1)).max()) / scene.units.force
    most = float(np.sqrt((off.reshape(-1, 3) ** 2).sum(axis=1)).max()) + _EPS * size  # the way to newtons rounds, too
    if size <= ACTIVE:
        return most
    # Relative to exact forces that may be smaller by as much
    return most / (size - most) if most < size else np.inf


@kernel
def _look(p: _Problem, q: Array, reach: Array, u: int, dof: int) -> _Look:
    """Reach (2,): sizes, in natural units, of what levers and the load's moment are differences of; u: where the
    object's motion begins, of dof unknowns.
    """
    n, k = len(p.x), len(p.blocks)
    turns, end = u + (3 if dof == 6 else 2), u + dof
    y, noise, rho = np.empty(n), np.empty(n), row_scales(p.M, p.blocks)
    touch, stick = np.zeros(n, np.bool_), np.zeros(k, np.bool_)
    for i in range(n):
        total, terms = q[i], abs(q[i])
        for j in range(n):
            total += p.M[i, j] * p.x[j]
            terms += abs(p.M[i, j] * p.x[j])
            if (turns <= i < end) != (turns <= j < end):
                terms += reach[0] * abs(p.x[j])
        if turns <= i < end:
            terms += reach[1]
        y[i], noise[i] = total, _ROUNDING * terms
        touch[i] = p.role[i] == 1 and p.x[i] > rho[i] * total
    size, along, radius = np.empty(k), np.zeros((k, 2)), np.empty(k)
    for b in range(k):
        for a in range(2):
            t = p.blocks[b, a + 1]
            if t >= 0:
                along[b, a] = p.x[t] - rho[t] * y[t]
        size[b] = np.hypot(along[b, 0], along[b, 1])
        if size[b] > 0.0:
            along[b] /= size[b]
        radius[b] = p.limits[b] * max(p.x[p.blocks[b, 0]], 0.0)
        stick[b] = size[b] <= radius[b]
    return _Look(y, noise, rho, touch, stick, size, along, radius)


def _bound(p: _Problem, look: _Look, touch: Bools, stick: Bools) -> Array:
    """(n,) largest error of every unknown in the piece where these pairs touch and these blocks stick."""
    J, F, off = _piece(p, look, touch, stick)
    return _step(_inverse(J), F, off)


@kernel
def _piece(p: _Problem, look: _Look, touch: Bools, stick: Bools) -> tuple[Array, Array, Array]:
    """J (n, n), F (n,) and the rounding of F (n,), each row over the largest entry of its row of J."""
    n, x = len(p.x), p.x
    J, F, off = p.M.copy(), look.y.copy(), look.noise.copy()
    for i in range(n):
        if p.role[i] == 1 and not touch[i]:
            J[i] = 0.0
            J[i, i], F[i], off[i] = 1.0, x[i], 0.0
    for b in range(len(p.blocks)):
        if stick[b]:
            continue
        N, r, radius, along = p.blocks[b, 0], look.rho[p.blocks[b, 1]], look.radius[b], look.along[b]
        # F = x_T - μ x_N e(x_T - ρ y_T): the projection's derivative, `across`, turns e by what lies across it
        share = radius / max(look.size[b], radius) if radius > 0.0 else 0.0
        for a in range(2):
            t = p.blocks[b, a + 1]
            if t < 0:
                continue
            J[t] = 0.0
            off[t] = _ROUNDING * abs(x[t])
            for c in range(2):
                s = p.blocks[b, c + 1]
                if s < 0:
                    continue
                across = share * ((1.0 if a == c else 0.0) - along[a] * along[c])
                if p.blocks[b, 2] < 0:
                    across = 0.0  # nothing lies across in a plane
                for j in range(n):
                    J[t, j] += across * r * p.M[s, j]
                J[t, s] += (1.0 if a == c else 0.0) - across
                off[t] += abs(across) * r * look.noise[s]
            J[t, N] -= p.limits[b] * along[a]
            F[t] = x[t] - p.limits[b] * x[N] * along[a]
    for i in range(n):
        largest = np.max(np.abs(J[i]))
        if largest > 0.0:
            J[i] /= largest
            F[i] /= largest
            off[i] /= largest
    return J, F, off


@kernel
def _step(inverse: Array, F: Array, off: Array) -> Array:
    """|J⁻¹ F| + |J⁻¹| off."""
    n = len(F)
    bound = np.empty(n)
    for i in range(n):
        step, spread = 0.0, 0.0
        for j in range(n):
            step += inverse[i, j] * F[j]
            spread += abs(inverse[i, j]) * off[j]
        bound[i] = abs(step) + spread
    return bound


@kernel
def _doubtful(p: _Problem, look: _Look, bound: Array) -> tuple[Bools, Bools]:
    """Pairs (n,) and blocks (k,) that may be on the other side of their border, for all the bound (n,) says."""
    n, k = len(p.x), len(p.blocks)
    moved = np.empty(n)
    pairs, sides = np.zeros(n, np.bool_), np.zeros(k, np.bool_)
    for i in range(n):
        total = look.noise[i]
        for j in range(n):
            total += abs(p.M[i, j]) * bound[j]
        moved[i] = bound[i] + look.rho[i] * total
        pairs[i] = p.role[i] == 1 and abs(p.x[i] - look.rho[i] * look.y[i]) <= moved[i]
    for b in range(k):
        t, o = p.blocks[b, 1], p.blocks[b, 2]
        slack = np.hypot(moved[t], moved[o] if o >= 0 else 0.0) + p.limits[b] * bound[p.blocks[b, 0]]
        sides[b] = abs(look.size[b] - look.radius[b]) <= slack
    return pairs, sides


def _reach(problem: GraspContact) -> Array:
    """(2,) see `_look`: levers are differences of positions, moments those of the load's about the origin."""
    scene = problem.scene
    far = float(abs(scene.positions).max()) / scene.units.length
    return np.array([far, far * float(abs(scene.natural.w).max())])


def _inverse(A: Array) -> Array:
    """Inverse of a matrix of rows of size one, or what the rank tolerance leaves of it."""
    try:
        inverse: Array = np.asarray(np.linalg.inv(A), dtype=float)
        if _largest_sum(inverse) * _largest_sum(A) < 1.0 / _REGULAR:
            return inverse
    except np.linalg.LinAlgError:
        pass  # singular to the last bit
    return np.asarray(np.linalg.pinv(A, rcond=RANK), dtype=float)


@kernel
def _largest_sum(A: Array) -> float:
    """The norm that goes with the largest component, ‖A‖_∞; NaN where an entry is."""
    largest = 0.0
    for i in range(len(A)):
        total = np.sum(np.abs(A[i]))
        if not total <= largest:
            largest = total
    return largest


def _choices(pairs: Bools, blocks: Bools) -> list[tuple[Bools, Bools]]:
    """Which doubtful pairs and blocks to take on their other side, in every way but none at all."""
    doubt = np.flatnonzero(np.concatenate([pairs, blocks]))
    k = len(doubt)
    if k <= _MOST_DOUBTFUL:
        patterns = [p for p in itertools.product((False, True), repeat=k) if any(p)]
    else:
        patterns = [*map(tuple, np.eye(k, dtype=bool).tolist()), (True,) * k]
    out = []
    for pattern in patterns:
        flip = np.zeros(len(pairs) + len(blocks), dtype=bool)
        flip[doubt[list(pattern)]] = True
        out.append((flip[: len(pairs)], flip[len(pairs) :]))
    return out
