"""The certifier: every claim of a solver recomputed from M, q and z; and the vector that proves that there is no z."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.projection import product, recompute, recompute_contact, recompute_natural
from handlcp.lcp.problem import LCP, Status
from handlcp.tolerances import CERTIFY, GROWTH

# ----------------------------------------------------------------
# The certifier: recomputes residuals from M, q and z alone. It imports no solver, and NaN never passes.


def natural_residual(problem: LCP, z: Array) -> tuple[Array, float]:
    """(w, residual): w = M z + q (n,) and the worst of |min(z_i, w_i)|, or |w_i| where free, each in natural units.

    Both are divided by the size of z in natural units, clipped to [1, 1000]: rounding grows with the numbers, but huge
    cancelling multipliers must not excuse a wrong answer. Not finite anywhere: infinite.
    """
    units = problem.scaled.units
    return recompute(problem.M, problem.q, problem.free, units.z, units.w, z, GROWTH)


def certify(problem: LCP, z: Array, tolerance: float = CERTIFY) -> tuple[Status, Array, float]:
    """(status, w, residual) of a candidate z (n,) in the user's units: SOLVED or UNDECIDED."""
    w, residual = natural_residual(problem, z)
    return (Status.SOLVED if residual <= tolerance else Status.UNDECIDED), w, residual


def certify_contact(problem: ContactProblem, x: Array, tolerance: float = CERTIFY) -> tuple[Status, Array, float]:
    """(status, y, residual) of a candidate x (n,) in natural units; y in the user's units.

    residual: the worst of |y_i| (free), |min(x_i, y_i)| (pairs) and, in each friction block, the excess over the limit
    and the distance of x_T from the projection of x_T - y_T, over the size of x clipped to [1, 1000].
    """
    p, s = problem, problem.sets
    y, worst, size = recompute_contact(p.M, p.q, p.role, p.blocks, s.limits, s.faces, s.normals, x)
    residual = worst / min(size, GROWTH)
    return (Status.SOLVED if residual <= tolerance else Status.UNDECIDED), y * problem.units.w, residual


def certified(problem: LCP | ContactProblem, x: Array) -> tuple[Array, Status, Array, float]:
    """(z, status, w, residual) of a candidate x (n,) in natural units; z and w in the user's units."""
    if isinstance(problem, ContactProblem):
        status, y, residual = certify_contact(problem, x)
        solved = status is Status.SOLVED  # what is no answer may overflow
        return (x * problem.units.z if solved else product(x, problem.units.z)), status, y, residual
    units = problem.scaled.units
    z, w, residual = recompute_natural(problem.M, problem.q, problem.free, units.z, units.w, x, GROWTH)
    return z, (Status.SOLVED if residual <= CERTIFY else Status.UNDECIDED), w, residual


def is_farkas(problem: LCP, y: Array, tolerance: float = CERTIFY) -> bool:
    """Whether y (n,) proves that no z ≥ 0 (free: any) has w ≥ 0 (free: = 0): y_i ≥ 0, Mᵀy ≤ 0 (free: = 0), qᵀy < 0.

    Then 0 ≤ yᵀw = (Mᵀy)ᵀz + qᵀy ≤ qᵀy < 0 for every such z, a contradiction. Signs are exact for y and relative to
    the size of the summed terms for Mᵀy and qᵀy.
    """
    s, y = problem.scaled, y * problem.scaled.units.w
    if not np.isfinite(y).all() or (y[~s.free] < 0).any():
        return False
    slack, size = s.M.T @ y, abs(s.M).T @ abs(y)
    gain, gain_size = float(s.q @ y), float(abs(s.q) @ abs(y))
    excess = np.where(s.free, abs(slack), slack)
    return bool((excess <= 1e-3 * tolerance * size).all()) and gain < -tolerance * gain_size


# ----------------------------------------------------------------
# Farkas' proof that a complementarity problem has not even a feasible point.


def farkas_vector(problem: LCP) -> Array | None:
    """Y (n,) with y ≥ 0 (free rows: any sign), Mᵀy ≤ 0 (free: = 0) and qᵀy < 0, certified; None when there is none.

    A linear program over the box |y| ≤ 1 minimises qᵀy; its sign pattern is what counts, not its status.
    """
    from scipy.optimize import linprog  # half a second of import that only a failed solve should pay

    s = problem.scaled
    signed, equal = s.M.T[~s.free], s.M.T[s.free]
    bounds = np.column_stack([np.where(s.free, -1.0, 0.0), np.ones(problem.n)])
    lp = linprog(s.q, signed, np.zeros(len(signed)), equal, np.zeros(len(equal)), bounds, method="highs")
    if lp.x is None:
        return None
    y = np.where(s.free, lp.x, np.maximum(lp.x, 0.0)) / s.units.w
    return read_only(y) if is_farkas(problem, y) else None
