"""Farkas' proof that a complementarity problem has not even a feasible point."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.lcp.certify import is_farkas
from handlcp.lcp.problem import LCP


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
