"""Small conic programs that share their cones: linear rows and second-order cones, solved by Clarabel.

    min cᵀx    A_k x = b_k,    G x + s = h_k,    s ∈ K = R₊^l × Q_3 × … × Q_4 × …,    Q_d = {(t, u) : t ≥ |u|}

An end, a ray along which the cost falls for ever, and a proof that nothing fits are what Clarabel proposes; each is
measured here, by what it misses of its equations and by the gap between the cost and what the multipliers prove.
Source: Goulart & Chen, Clarabel: an interior-point solver for conic programs with quadratic objectives (2024).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lazy import lazy

STOPPED, ENDED, UNBOUNDED, NOTHING_FITS = 0, 1, 2, 3
_GAP = 1e-12  # relative: what is asked for; where rounding allows no more, Clarabel stops with what it has
_ENOUGH = 1e-5  # a gap up to this is an end
_PROOF = 1e-9  # how far a ray or a proof may miss its equations


class Cones:
    """The cones of m rows: `linear` half-lines, then so many second-order cones of each dimension, in order."""

    def __init__(self, linear: int, more: tuple[tuple[int, int], ...]) -> None:
        """More : (dimension, count) of second-order cones."""
        self.linear, self.more = linear, tuple([(d, count) for d, count in more if count])
        self.rows = linear + sum(d * count for d, count in self.more)

    @lazy
    def unit(self) -> Array:
        """(m,) e: 1 on half-lines, (1, 0, …) on cones."""
        cones = [np.tile(np.append(1.0, np.zeros(d - 1)), count) for d, count in self.more]
        return np.concatenate([np.ones(self.linear), *cones])


class Conic(NamedTuple):
    """p programs of v unknowns, e equations and m rows: c (v,), A (p, e, v), b (p, e), G (m, v), h (p, m)."""

    c: Array
    A: Array
    b: Array
    G: Array
    h: Array
    cones: Cones


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """Where p programs ended. status (p,) : one of the words above. x (p, v), z (p, m) multipliers of the rows; of a
    ray where the status is UNBOUNDED. gap (p,) : what separates the cost from a lower bound on it, or what equations
    are missed by, relative to the larger of one and the cost.
    """

    status: Ints
    x: Array
    z: Array
    gap: Array


def solve_conic(programs: Conic) -> Ends:
    """All of them; where a program stops short of its end, the status says so and the gap how far."""
    p, _, v = programs.A.shape
    m = len(programs.G)
    ends = Ends(np.zeros(p, dtype=np.int64), np.full((p, v), np.nan), np.full((p, m), np.nan), np.full(p, np.inf))
    for k, x, y, z, s in _proposals(programs):
        if not all(np.isfinite(a).all() for a in (x, y, z, s)):
            continue
        status, gap, size = judged(programs, k, x, y, z, s)
        ends.status[k], ends.gap[k], ends.x[k], ends.z[k] = status, gap, x / size, z / size
    return ends


def _proposals(programs: Conic) -> Iterator[tuple[int, Array, Array, Array, Array]]:
    """(k, x, y, z, s) of every program, as Clarabel leaves them."""
    import clarabel  # a tenth of a second, with sparse matrices, that only bounds should pay
    from scipy import sparse

    e, m, cones = programs.A.shape[1], len(programs.G), programs.cones
    kinds: list[Any] = [clarabel.ZeroConeT(e)] if e else []
    kinds += [clarabel.NonnegativeConeT(cones.linear)] if cones.linear else []
    kinds += [clarabel.SecondOrderConeT(d) for d, count in cones.more for _ in range(count)]
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.max_threads = False, 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = _GAP
    settings.tol_infeas_abs = settings.tol_infeas_rel = 1e-3 * _PROOF  # its measure is another one
    none = sparse.csc_matrix((len(programs.c), len(programs.c)))
    for k in range(len(programs.A)):
        rows = sparse.csc_matrix(np.concatenate([programs.A[k], programs.G]))
        right = np.concatenate([programs.b[k], programs.h[k]])
        found = clarabel.DefaultSolver(none, programs.c, rows, right, kinds, settings).solve()
        x, z, s = (np.asarray(a, dtype=np.float64) for a in (found.x, found.z, found.s))
        yield k, x, z[:e], z[e : e + m], s[e : e + m]


def judged(programs: Conic, k: int, x: Array, y: Array, z: Array, s: Array) -> tuple[int, float, float]:
    """(status, gap, what the numbers are to be divided by) of what was proposed for program k: x (v,), multipliers y
    (e,) of the equations and z (m,) of the rows, and room s (m,).
    """
    c, A, b, G, h, _ = programs
    A, b, h = A[k], b[k], h[k]
    pull = A.T @ y + G.T @ z
    cost, bound = float(c @ x), -float(b @ y + h @ z)
    size = max(1.0, abs(cost))
    primal = max(_norm(A @ x - b) / (1.0 + _norm(b)), _norm(G @ x + s - h) / (1.0 + _norm(h)))
    missed = max(primal / (1.0 + 1e-3 * _norm(x)), _norm(pull + c) / (1.0 + _norm(c)))
    gap = max(float(s @ z) / size, abs(cost - bound) / size, missed)
    if gap <= _ENOUGH:
        return ENDED, gap, 1.0
    if cost < 0.0 and max(_norm(A @ x), _norm(G @ x + s)) <= -_PROOF * cost:
        return UNBOUNDED, 0.0, -cost
    if bound > 0.0 and _norm(pull) <= _PROOF * bound:
        return NOTHING_FITS, 0.0, bound
    return STOPPED, gap, 1.0


def _norm(a: Array) -> float:
    return float(np.sqrt(a @ a))
