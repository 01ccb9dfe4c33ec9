"""All active sets at once: a mixed-integer program that finds a solution of a complementarity problem, or proves that
none exists within stated bounds.

    w = M z + q,  0 ≤ z ≤ Z b,  0 ≤ w ≤ W (1 - b),  b ∈ {0, 1}ⁿ        (free rows: w = 0, z unrestricted)

One binary a pair; Z and W are the bounds. HiGHS branches and bounds: its tolerances only widen what counts as a
solution, so "none" stands. "None" is a statement about the box, not beyond it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, array
from handlcp.errors import InputError
from handlcp.lcp import LCP

__all__ = ["SearchResult", "search"]


@dataclass(frozen=True, slots=True)
class SearchResult:
    """z (n,) in the user's units or None; `none_exists`: proved within the bounds; pairs: binaries searched."""

    z: Array | None
    none_exists: bool
    pairs: int
    message: str


def search(problem: LCP, z_max: Array, w_max: Array, time_limit: float = 30.0) -> SearchResult:
    """Search with 0 ≤ z ≤ z_max and 0 ≤ w ≤ w_max, (n,) each in the user's units (ignored on free rows).

    Raises InputError for bounds that are not positive.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp

    s, n = problem.scaled, problem.n
    for name, value in (("z_max", z_max), ("w_max", w_max)):
        if not (array(name, value, (n,)) > 0).all():
            raise InputError(name, "positive bounds", f"a smallest of {np.min(value):.3g}")
    Z, W = np.diag(z_max / s.units.z), np.diag(w_max / s.units.w)
    own, eye, zero = ~s.free, np.eye(n), np.zeros((n, n))
    top = np.where(own, np.inf, -s.q)  # free rows: M z = -q
    constraints = [
        LinearConstraint(np.hstack([s.M, zero]), -s.q, top),
        LinearConstraint(np.hstack([eye, -Z])[own], -np.inf, 0.0),
        LinearConstraint(np.hstack([s.M, W])[own], -np.inf, (np.diag(W) - s.q)[own]),
    ]
    low = np.concatenate([np.where(own, 0.0, -np.inf), np.zeros(n)])
    high = np.concatenate([np.where(own, np.diag(Z), np.inf), own.astype(float)])
    r = milp(
        np.zeros(2 * n),
        constraints=constraints,
        bounds=Bounds(low, high),
        integrality=np.concatenate([np.zeros(n), own.astype(float)]),
        options={"time_limit": time_limit},
    )
    z = None if r.x is None else r.x[:n] * s.units.z
    return SearchResult(z, r.status == 2, int(own.sum()), str(r.message))
