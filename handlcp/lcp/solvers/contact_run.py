"""NSNGRK on contact problems: Newton's method from where every contact sticks, rescued by Kaczmarz steps."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact import contact_kaczmarz, contact_newton
from handlcp.lcp.kernels.dense import solve_ranked
from handlcp.lcp.kernels.kaczmarz import multiply_add
from handlcp.lcp.result import Proposal
from handlcp.tolerances import RANK, SOLVE

__all__ = ["run_contact"]


def run_contact(
    problem: ContactProblem, seed: int, most: int, polish: bool, tolerance: float, start: Array | None = None
) -> Proposal:
    """Solve from `start` (n,), natural units; None: the solution of the linear problem in which every
    contact sticks that starts without a gap.

    seed : of the row sampling. most : Kaczmarz steps at most. polish : Newton's method before and between them.
    """
    x = np.zeros(problem.n) if start is None else np.array(start, dtype=float)
    steps, newton, r = _run(
        problem.M, problem.q, problem.role, problem.rho, problem.blocks, problem.limits, problem.faces,
        x, start is None, seed, most, polish, min(tolerance, SOLVE) * 1e-2 if polish else tolerance, RANK,
    )  # fmt: skip
    outcome = "converged" if r <= tolerance else "budget spent"
    return Proposal(x, steps, f"{outcome}, {newton} Newton steps" if polish else outcome)


@kernel
def _through_cone(
    M: Array,
    q: Array,
    role: Ints,
    rho: Array,
    blocks: Ints,
    limits: Array,
    faces: int,
    x: Array,
    tolerance: float,
    rank_tolerance: float,
) -> tuple[int, float]:
    """Newton's method in place. A polygon is met from the answer with a disc in its place, which names the faces: from
    there it takes about two steps, whatever their number.
    """
    before = 0
    if faces > 2:
        before, _ = contact_newton(M, q, role, rho, blocks, limits, 0, x, 12, 1e-6, rank_tolerance)
    steps, r = contact_newton(M, q, role, rho, blocks, limits, faces, x, 20, tolerance, rank_tolerance)
    return before + steps, r


@kernel
def _run(
    M: Array, q: Array, role: Ints, rho: Array, blocks: Ints, limits: Array, faces: int,
    x: Array, stick: bool, seed: int, most: int, polish: bool, tolerance: float, rank_tolerance: float,
) -> tuple[int, int, float]:  # fmt: skip
    """(Kaczmarz steps, Newton steps, residual); x in place."""
    n = len(x)
    if stick:
        A, b, col = M.copy(), -q, np.empty(n, np.int64)
        for i in range(n):
            if role[i] == 1 and q[i] > 0.0:
                A[i], A[i, i], b[i] = 0.0, 1.0, 0.0
        for k in range(len(blocks)):
            if q[blocks[k, 0]] > 0.0:
                for a in range(1, 3):
                    i = blocks[k, a]
                    if i >= 0:
                        A[i], A[i, i], b[i] = 0.0, 1.0, 0.0
        solve_ranked(A, b, x, col, rank_tolerance)
    newton, r = 0, np.inf
    best, best_r = x.copy(), np.inf
    if polish:
        trial = x.copy()
        newton, r = _through_cone(M, q, role, rho, blocks, limits, faces, trial, tolerance, rank_tolerance)
        if r <= tolerance or most == 0:
            x[:] = trial
            return 0, newton, r
        best[:], best_r = trial, r
    MT, MMT = np.ascontiguousarray(M.T), np.dot(M, np.ascontiguousarray(M.T))
    state, y = np.full(1, seed, np.uint64), np.empty(n)
    multiply_add(M, x, q, y)
    taken, batch = 0, 2 * n if polish else most
    while taken < most:
        done, r = contact_kaczmarz(
            M, MT, MMT, q, role, rho, blocks, limits, faces, x, y, state, min(batch, most - taken), tolerance
        )
        taken += done
        if not polish:
            return taken, 0, r
        trial = x.copy()
        steps, r = _through_cone(M, q, role, rho, blocks, limits, faces, trial, tolerance, rank_tolerance)
        newton += steps
        if r < best_r:
            best[:], best_r = trial, r
        if r <= tolerance or done < batch:  # solved, or stalled where no row moves any more
            break
        batch *= 2
    x[:] = best
    return taken, newton, best_r
