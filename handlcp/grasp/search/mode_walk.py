"""Every choice of contact modes, one after the other, compiled: all isolated equilibria of a pyramid at once.

A mode of contact i, with forces x_i = (r_N, r_T) and motions y_i = (v_N, v_T), has p unknowns s and p conditions:

    y_i = B s,  A x_i = 0        open: A = B = I; stuck: p = 0; against face j: A = (-μ, n_j), B = (0, -n_j);
                                 at the edge between two faces: both rows, both columns

With x = c + P y (`mode_table`) s = -(A P_ii B)⁻¹ A (c_i + P_i· y) eliminates contact i from the contacts after it, and
a depth-first walk through the tree of choices costs one small elimination a node, tens of nanoseconds a choice. What
satisfies the signs of its modes is an equilibrium. A node whose A P_ii B is singular (say, all but two fingers open:
the object spins about the line between them) is not eliminated; the choices below it are solved whole, and those that
leave something free are handed back.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.search import mode_steps as step
from handlcp.grasp.search.mode_steps import SIGNS, Modes, Walk
from handlcp.grasp.verify.judge import judge
from handlcp.lcp import SemismoothNewton
from handlcp.lcp.kernels.dense import kernel, solve_ranked
from handlcp.lcp.solvers.auto import in_units_of_limits
from handlcp.tolerances import CERTIFY, FINE, RANK

# ----------------------------------------------------------------
# From a candidate that a search found, not exact to the last digit, to one that the certifier passes.

_NEWTON = SemismoothNewton(tol=FINE)
_ALMOST = 100.0  # of what the certifier allows


def first_certified(problem: GraspContactProblem, candidates: Iterable[Candidate]) -> Candidate | None:
    """The first that the certifier passes, as it is or after Newton's method from there."""
    for candidate in candidates:
        if passes(problem, candidate):
            return candidate
        near = _NEWTON.propose_contact(problem, problem.natural(candidate)).z
        refined = problem.candidate(near)
        worst = _worst(problem, refined)
        if CERTIFY < worst <= _ALMOST * CERTIFY:  # stiff fingers: rounding may be less in other units
            refined = problem.candidate(in_units_of_limits(_NEWTON, problem, near).z)
            worst = _worst(problem, refined)
        if worst <= CERTIFY:
            return refined
    return None


def passes(problem: GraspContactProblem, candidate: Candidate) -> bool:
    """Whether the certifier calls it an answer."""
    return _worst(problem, candidate) <= CERTIFY


def _worst(problem: GraspContactProblem, candidate: Candidate) -> float:
    return judge(problem.scene, problem.effects, problem.section, candidate).residuals.worst


def only_limits_move(problem: GraspContactProblem) -> bool:
    """Whether contact modes describe the scene: no effect moves the contacts but by limits that give way."""
    return all(e.only_limits for e in problem.effects)


# ----------------------------------------------------------------


@kernel
def visit(P: Array, c: Array, m: Modes, most: int, most_whole: int) -> tuple[Array, Ints, bool]:
    """(motions (k, N) of what satisfies all signs, forces distinct; modes (f, n) of choices that leave something free;
    whether all choices were visited, with at most `most` of each kind and `most_whole` solved whole).

    P (N, N), c (N,), N = 3n: components that a contact lacks are zero.
    """
    n, N, w = len(m.choices), len(c), step.new_walk(P, c)
    mode = np.full(n, -1, np.int64)
    x, y = np.zeros(N), np.zeros(N)
    found, forces, frees = np.zeros((most, N)), np.zeros((most, N)), np.zeros((most, n), np.int64)
    many, free, solved, i, singular = 0, 0, 0, 0, n
    while i >= 0:
        mode[i] += 1
        k = mode[i]
        if k == m.choices[i]:
            mode[i] = -1
            i -= 1
            continue
        if singular >= i:  # the contacts before this one were eliminated; now this one, if it can be
            singular = n
            what = step.solve_contact(w, i, k, m)
            if what == step.CONTRADICTS:
                continue
            if what != step.REGULAR:
                singular = i
        if i < n - 1:
            if singular == n and not step.hand_on(w, i, k, m):
                singular = i
            i += 1
            continue
        if singular < n:
            ok, unique = whole(P, c, mode, m, y)
            solved += 1
            if ok and not unique:
                if free < most:
                    frees[free] = mode
                free += 1
            if solved > most_whole or free > most:
                return found[:many], frees[: min(free, most)], False
            if not (ok and unique):
                continue
        elif step.last(w, i, k, m, x, y):
            _others(w, mode, m, y)
        else:
            continue
        if step.fits(P, c, mode, m, x, y) and _fresh(forces[:many], x):
            if many == most:
                return found[:many], frees[:free], False
            found[many], forces[many] = y, x
            many += 1
    return found[:many], frees[:free], True


@kernel
def _others(w: Walk, mode: Ints, m: Modes, y: Array) -> None:
    """Motions of the contacts before the last, from the last's: back through the eliminations."""
    for j in range(len(mode) - 2, -1, -1):
        y[3 * j : 3 * j + 3] = 0.0
        for q in range(m.rank[j, mode[j]]):
            s = -w.h[j, q] - w.H[j, q, 3 * j + 3 :] @ y[3 * j + 3 :]
            for r in range(3 * j, 3 * j + 3):
                y[r] += m.B[j, mode[j], r - 3 * j, q] * s


@kernel
def _fresh(forces: Array, x: Array) -> bool:
    """Whether these forces (N,) differ from all that were found (k, N)."""
    near = 0.1 * SIGNS * max(1.0, np.max(np.abs(x)))
    for known in forces:  # noqa: SIM110  kernels know no all()
        if np.max(np.abs(known - x)) <= near:
            return False
    return True


@kernel
def whole(P: Array, c: Array, mode: Ints, m: Modes, y: Array) -> tuple[bool, bool]:
    """One choice of modes without the tree: (whether its conditions have a solution, one only); y (N,) is one."""
    N, p = len(c), 0
    A, B = np.zeros((N, N)), np.zeros((N, N))
    for i in range(len(mode)):
        for a in range(m.rank[i, mode[i]]):
            for d in range(3):
                A[p, 3 * i + d] = m.A[i, mode[i], a, d]
                B[3 * i + d, p] = m.B[i, mode[i], d, a]
            p += 1
    y[:] = 0.0
    if p == 0:
        return True, True
    S, b, s = np.zeros((p, p)), np.zeros(p), np.zeros(p)
    for r in range(p):
        for j in range(N):
            if A[r, j] != 0.0:
                b[r] -= A[r, j] * c[j]
                for q in range(N):
                    t = A[r, j] * P[j, q]
                    for col in range(p):
                        S[r, col] += t * B[q, col]
    unique = solve_ranked(S.copy(), b.copy(), s, np.zeros(p, np.int64), RANK) == p
    missed, size = 0.0, max(1.0, np.max(np.abs(s)))
    for r in range(p):
        t = -b[r]
        for col in range(p):
            t += S[r, col] * s[col]
        missed = max(missed, abs(t))
    for q in range(N):
        for col in range(p):
            y[q] += B[q, col] * s[col]
    return missed <= SIGNS * size, unique
