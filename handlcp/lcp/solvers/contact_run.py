"""NSNGRK on contact problems: Newton's method from where every contact sticks, rescued by Kaczmarz steps."""

from __future__ import annotations

from typing import cast

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.arrow import Arrow
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact import Contacts
from handlcp.lcp.kernels.contact_kaczmarz import contact_kaczmarz
from handlcp.lcp.kernels.contact_newton import contact_newton, stick
from handlcp.lcp.kernels.kaczmarz import multiply_add
from handlcp.lcp.result import Proposal
from handlcp.tolerances import RANK, SOLVE

__all__ = ["run", "run_contact"]

_ON_DISC = 1e-2  # how well the disc's answer has to be known to name a polygon's faces
# int64, no literals: kernels are compiled for each literal anew
_DISC_STEPS, _STEPS = cast(int, np.int64(8)), cast(int, np.int64(12))  # Newton runs that end well take half as many
# Which contacts Newton's next step takes for sticking depends on ρ: where it fails with the stiffness of each contact,
# other scales lead elsewhere, from there and from where Kaczmarz steps have come
_SCALES = (0.03, 0.3, 1.0)


def run_contact(
    problem: ContactProblem, seed: int, most: int, polish: bool, tolerance: float, start: Array | None = None
) -> Proposal:
    """Solve from `start` (n,), natural units; None: the solution of the linear problem in which every
    contact sticks that starts without a gap.

    seed : of the row sampling. most : Kaczmarz steps at most; 0: Newton's alone, whose steps are then what counts as
    iterations. polish : Newton's method before and between them.
    """
    x = np.zeros(problem.n) if start is None else np.array(start, dtype=float)
    steps, newton, r = run(
        problem.M, *problem.prepared, problem.limits, problem.faces,
        x, start is None, seed, most, polish, min(tolerance, SOLVE) * 1e-2 if polish else tolerance, RANK,
    )  # fmt: skip
    outcome = "converged" if r <= tolerance else "budget spent"
    return Proposal(x, steps if most else newton, f"{outcome}, {newton} Newton steps" if polish else outcome)


@kernel
def _newton(p: Contacts, scale: float, x: Array, tolerance: float, rank_tolerance: float) -> tuple[int, float]:
    """Newton's method in place, with ρ times `scale`. A polygon is met from the answer with a disc in its place, which
    names the faces: from there it takes two or three steps, whatever their number.
    """
    p = Contacts(p.M, p.q, p.role, p.rho * scale, p.blocks, p.limits, p.faces)
    before = 0
    if p.faces > 2:
        disc = Contacts(p.M, p.q, p.role, p.rho, p.blocks, p.limits, 0)
        before, _ = contact_newton(disc, x, _DISC_STEPS, _ON_DISC, rank_tolerance)
    steps, r = contact_newton(p, x, _STEPS, tolerance, rank_tolerance)
    return before + steps, r


@kernel
def run(
    M: Array, order: Ints, starts: Ints, own: Array, side: Array, below: Array, q: Array, role: Ints, rho: Array,
    blocks: Ints, limits: Array, faces: int,
    start: Array, from_stick: bool, seed: int, most: int, polish: bool, tolerance: float, rank_tolerance: float,
) -> tuple[int, int, float]:  # fmt: skip
    """(Kaczmarz steps, Newton steps, residual); `start` is overwritten with the answer."""
    p = Contacts(Arrow(own, side, below, starts), q, role, rho, blocks, limits, faces)
    x = start[order]
    if from_stick:
        stick(p, x, rank_tolerance)
    taken, newton, r, best = 0, 0, np.inf, x
    if polish:
        best, newton, r = _polish(p, x, from_stick, tolerance, rank_tolerance)
    if not polish or (r > tolerance and most > 0):
        full = np.empty(M.shape)
        for s in range(len(x)):
            for t in range(len(x)):
                full[s, t] = M[order[s], order[t]]
        taken, more, r = _steps(p, full, x, best, r, seed, most, polish, tolerance, rank_tolerance)
        newton, best = newton + more, x
    for s in range(len(x)):
        start[order[s]] = best[s]
    return taken, newton, r


@kernel
def _polish(
    p: Contacts, x: Array, from_stick: bool, tolerance: float, rank_tolerance: float
) -> tuple[Array, int, float]:
    """(answer, steps, residual) of Newton's method from x, which is left alone."""
    best, before, r = x.copy(), 0, np.inf
    if not from_stick and p.faces > 2:  # a good start lies on the right faces already
        before, r = contact_newton(p, best, _STEPS, tolerance, rank_tolerance)
        if r <= tolerance:
            return best, before, r
        best[:] = x
    steps, r = _newton(p, 1.0, best, tolerance, rank_tolerance)
    return best, before + steps, r


@kernel
def _steps(
    p: Contacts, M: Array, x: Array, best: Array, best_r: float,
    seed: int, most: int, polish: bool, tolerance: float, rank_tolerance: float,
) -> tuple[int, int, float]:  # fmt: skip
    """Kaczmarz steps and Newton's method in turn, in place, until Newton's converges; else the best of it all."""
    n, newton, taken, k = len(x), 0, 0, 0
    MT, MMT = np.ascontiguousarray(M.T), np.dot(M, np.ascontiguousarray(M.T))
    state, y = np.full(1, seed, np.uint64), np.empty(n)
    multiply_add(M, x, p.q, y)
    batch = 2 * n if polish else most
    while taken < most:
        done, r = contact_kaczmarz(p, M, MT, MMT, x, y, state, min(batch, most - taken), tolerance)
        taken += done
        if not polish:
            return taken, 0, r
        trial = x.copy()
        steps, r = _newton(p, _SCALES[k % len(_SCALES)], trial, tolerance, rank_tolerance)
        newton += steps
        k += 1
        if r < best_r:
            best, best_r = trial, r
        if r <= tolerance or done < batch:  # solved, or stalled where no row moves any more
            break
        batch *= 2
    x[:] = best
    return taken, newton, best_r
