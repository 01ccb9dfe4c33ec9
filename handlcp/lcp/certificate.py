"""`certify`: every claim of a solver recomputed from M, q and z; and the vector that proves that there is no z."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from handlcp.check import Array, Bools, check_array, check_number, read_only
from handlcp.errors import InputError
from handlcp.lcp.contact_problem import ContactProblem, FrictionSets, Pattern
from handlcp.lcp.kernels.newton import run_active_set
from handlcp.lcp.kernels.projection import (
    multiply_entries,
    recompute_contact_residual,
    recompute_natural_residual,
    recompute_residual,
)
from handlcp.lcp.modes.mode_search import ModeSearch
from handlcp.lcp.problem import LCP, ScaledLCP, Status
from handlcp.tolerances import CERTIFY_TOLERANCE, MAX_RESIDUAL_GROWTH, SOLVE_TOLERANCE

# ----------------------------------------------------------------
# The certifier: recomputes residuals from M, q and z alone. It imports no solver, and NaN never passes.


def natural_residual(problem: LCP, z: Array) -> tuple[Array, float]:
    """Recompute w = M z + q (n,) and the residual of a solution: (w, residual).

    The residual is the worst of |min(z_i, w_i)|, or |w_i| where free, each in natural units.
    Both are divided by the size of z in natural units, clipped to [1, 1000]: rounding grows with the numbers, but huge
    cancelling multipliers must not excuse a wrong answer. Not finite anywhere: infinite.
    """
    units = problem.scaled.units
    return recompute_residual(problem.M, problem.q, problem.free, units.z, units.w, z, MAX_RESIDUAL_GROWTH)


def certify(problem: LCP, z: Array, tolerance: float = CERTIFY_TOLERANCE) -> tuple[Status, Array, float]:
    """(status, w, residual) of a candidate z (n,) in the user's units: SOLVED or UNDECIDED."""
    w, residual = natural_residual(problem, z)
    return (Status.SOLVED if residual <= tolerance else Status.UNDECIDED), w, residual


def certify_contact(
    problem: ContactProblem, x: Array, tolerance: float = CERTIFY_TOLERANCE
) -> tuple[Status, Array, float]:
    """(status, y, residual) of a candidate x (n,) in natural units; y in the user's units.

    residual: the worst of |y_i| (free), |min(x_i, y_i)| (pairs) and, in each friction block, the excess over the limit
    and the distance of x_T from the projection of x_T - y_T, over the size of x clipped to [1, 1000].
    """
    p, s = problem, problem.sets
    y, worst, size = recompute_contact_residual(p.M, p.q, p.role, p.blocks, s.limits, s.faces, s.normals, x)
    residual = worst / min(size, MAX_RESIDUAL_GROWTH)
    return (Status.SOLVED if residual <= tolerance else Status.UNDECIDED), y * problem.units.w, residual


def certify_scaled(problem: LCP | ContactProblem, x: Array) -> tuple[Array, Status, Array, float]:
    """(z, status, w, residual) of a candidate x (n,) in natural units; z and w in the user's units."""
    if isinstance(problem, ContactProblem):
        status, y, residual = certify_contact(problem, x)
        solved = status is Status.SOLVED  # what is no answer may overflow
        return (x * problem.units.z if solved else multiply_entries(x, problem.units.z)), status, y, residual
    units = problem.scaled.units
    z, w, residual = recompute_natural_residual(
        problem.M, problem.q, problem.free, units.z, units.w, x, MAX_RESIDUAL_GROWTH
    )
    return z, (Status.SOLVED if residual <= CERTIFY_TOLERANCE else Status.UNDECIDED), w, residual


def is_farkas(problem: LCP, y: Array, tolerance: float = CERTIFY_TOLERANCE) -> bool:
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
    s = problem.scaled
    signed, equal = s.M.T[~s.free], s.M.T[s.free]
    bounds = np.column_stack([np.where(s.free, -1.0, 0.0), np.ones(problem.n)])
    lp = scipy.optimize.linprog(s.q, signed, np.zeros(len(signed)), equal, np.zeros(len(equal)), bounds, method="highs")
    if lp.x is None:
        return None
    y = np.where(s.free, lp.x, np.maximum(lp.x, 0.0)) / s.units.w
    return read_only(y) if is_farkas(problem, y) else None


# ----------------------------------------------------------------
# All active sets of a linear complementarity problem at once: a solution, or proof of none within stated bounds.
#
# By the tree of `mode_search`, in natural units. "None" stands, but a point that the tree finds is believed only when
# its active set, solved exactly, passes the certifier; otherwise nothing is claimed. "None" speaks of the box, not
# beyond it.


_DEFAULT_BOX = 1e3  # of the default box, times 1 + max|q̂|
_NO_BLOCKS, _NO_LIMITS = np.zeros((0, 4), np.int64), np.zeros(0)


@dataclass(frozen=True, slots=True)
class SearchResult:
    """What a search established.

    outcome : "solution" (certified), "none" (proved infeasible within the bounds) or "unknown" (work spent, or points
        refused: nothing is claimed).
    z : (n,) the solution in natural units, or None.
    bound_z : (n,) of the box, natural units; infinite on free rows. cuts : choices that the certifier refused.
    """

    outcome: str
    z: Array | None
    bound_z: Array
    cuts: int


def search_active_sets(
    problem: LCP,
    bound_z: Any = None,
    bound_w: Any = None,
    work: float = 5e8,
    accept: Callable[[Array], bool] | None = None,
    end: float = math.inf,
) -> SearchResult:
    """Search for a solution, or for the proof that there is none with 0 ≤ z ≤ bound_z and 0 ≤ w ≤ bound_w.

    bound_z, bound_w : each a number or (n,), natural units (ignored on free rows); None: 1000 (1 + max|q̂|).
    work : multiply-adds it may take; 5e8 are about a second. end : of `time.monotonic`, if earlier.
    accept : certifier of a candidate z (n,) in natural units; `certify` when None.

    Raises InputError for bounds that are not positive.
    """
    s = problem.scaled
    check_number("work", work, above=0.0)
    size = _DEFAULT_BOX * (1.0 + float(abs(s.q).max(initial=0.0)))
    Z, W = _box_bound("bound_z", bound_z, size, s.free, np.inf), _box_bound("bound_w", bound_w, size, s.free, 0.0)
    ok = accept or (lambda z: certify(problem, multiply_entries(z, s.units.z))[0] is Status.SOLVED)
    pairs = ContactProblem(s.M, s.q, Pattern.from_blocks(s.free, _NO_BLOCKS), FrictionSets(_NO_LIMITS, 0), s.units)
    modes = ModeSearch(pairs, Z, W)
    near = (c for x in modes.candidates(work, end) for c in (_solve_active_set(s, s.free | (x > 0.0)), x))
    z = next(filter(ok, near), None)
    outcome = "solution" if z is not None else "none" if modes.is_none_proven else "unknown"
    z = z if z is None else read_only(z)
    return SearchResult(outcome, z, Z, modes.refused_count)


def _box_bound(name: str, value: Any, default: float, free: Bools, elsewhere: float) -> Array:
    n = len(free)
    out = np.full(n, default) if value is None else np.zeros(n) + check_array(name, value, (), (n,))
    if not (out > 0).all():
        raise InputError(name, "positive bounds", f"a smallest of {out.min():.3g}")
    out[free] = elsewhere
    return read_only(out)


def _solve_active_set(s: ScaledLCP, on: Bools) -> Array:
    """M_AA z_A = -q_A for the active set A = on, and a few Newton steps from there should its signs be wrong."""
    z, w = np.where(on, 1.0, 0.0), np.where(on, 0.0, 1.0)
    run_active_set(s.M, s.q, s.free, z, w, 4, SOLVE_TOLERANCE * 1e-3)
    return z
