"""All active sets at once: a mixed-integer program that finds a solution of a complementarity problem, or proves that
none exists within stated bounds.

    w = M z + q,  0 ≤ z ≤ Z b,  0 ≤ w ≤ W (1 - b),  b ∈ {0, 1}ⁿ        (free rows: w = 0, z unrestricted)

One binary a pair, in natural units; Z and W are the bounds. HiGHS branches and bounds. Its tolerances only widen what
counts as a solution, so "none" stands, but a point it finds is believed only when its active set, solved exactly,
passes the certifier; otherwise that choice is cut off and the search goes on. "None" speaks of the box, not beyond it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from handlcp.check import Array, Bools, array, number, read_only
from handlcp.errors import InputError
from handlcp.lcp.certify import certify
from handlcp.lcp.kernels.newton import active_set
from handlcp.lcp.problem import LCP, Scaled
from handlcp.lcp.status import Status
from handlcp.tolerances import RANK, SOLVE

__all__ = ["Outcome", "SearchResult", "search"]

Outcome: TypeAlias = Literal["solution", "none", "unknown"]

_NARROW, _WIDE = 10.0, 1e3  # default boxes, times 1 + max|q̂|: the first finds quickly, the second proves
_CUTS = 20  # choices cut off before the search gives up


@dataclass(frozen=True, slots=True)
class SearchResult:
    """What a search established.

    outcome : "solution" (certified), "none" (proved infeasible within the bounds) or "unknown" (time or cuts spent:
        nothing is claimed).
    z : (n,) the solution in natural units, or None.
    bound_z, bound_w : (n,) the box of the last search, natural units; infinite z, zero w on free rows.
    seconds : wall time. pairs : binaries. cuts : choices that the certifier refused.
    """

    outcome: Outcome
    z: Array | None
    bound_z: Array
    bound_w: Array
    seconds: float
    pairs: int
    cuts: int = 0

    @property
    def none_exists(self) -> bool:
        """Whether it is proved that the box holds no solution."""
        return self.outcome == "none"


def search(
    problem: LCP,
    bound_z: Any = None,
    bound_w: Any = None,
    seconds: float = 10.0,
    accept: Callable[[Array], bool] | None = None,
) -> SearchResult:
    """Search with 0 ≤ z ≤ bound_z and 0 ≤ w ≤ bound_w, each a number or (n,), natural units (ignored on free rows).

    Where a bound is None: 10 (1 + max|q̂|) first, then 1000 (1 + max|q̂|), and only the second can end in "none".
    seconds : time limit of it all. accept : certifier of a candidate z (n,) in natural units; `certify` when None.

    Raises InputError for bounds that are not positive.
    """
    s, start = problem.scaled, time.monotonic()
    limit = number("seconds", seconds, above=0.0)
    size = 1.0 + float(abs(s.q).max(initial=0.0))
    ok = accept or (lambda z: certify(problem, z * s.units.z)[0] is Status.SOLVED)
    boxes = [_WIDE] if bound_z is not None and bound_w is not None else [_NARROW, _WIDE]
    result: SearchResult | None = None
    cuts = 0
    for k, factor in enumerate(boxes):
        Z = _bound("bound_z", bound_z, factor * size, s.free, np.inf)
        W = _bound("bound_w", bound_w, factor * size, s.free, 0.0)
        end = start + limit * (k + 1) / len(boxes)
        outcome, z, refused = _search(s, Z, W, end, ok)
        cuts += refused
        result = SearchResult(outcome, z, Z, W, time.monotonic() - start, int((~s.free).sum()), cuts)
        if outcome == "solution":
            break
    assert result is not None
    return result


def _bound(name: str, value: Any, default: float, free: Bools, elsewhere: float) -> Array:
    n = len(free)
    out = np.full(n, default) if value is None else np.zeros(n) + array(name, value, (), (n,))
    if not (out > 0).all():
        raise InputError(name, "positive bounds", f"a smallest of {out.min():.3g}")
    out[free] = elsewhere
    return read_only(out)


def _search(
    s: Scaled, Z: Array, W: Array, end: float, accept: Callable[[Array], bool]
) -> tuple[Outcome, Array | None, int]:
    """One box: (outcome, z, cuts)."""
    from scipy.optimize import Bounds, LinearConstraint, milp  # half a second of import that few solves should pay

    n, own = len(s.q), ~s.free
    pairs = np.flatnonzero(own)
    k = len(pairs)
    Zb, Wb = np.zeros((n, k)), np.zeros((n, k))
    Zb[pairs, np.arange(k)], Wb[pairs, np.arange(k)] = Z[pairs], W[pairs]
    constraints = [
        LinearConstraint(np.hstack([s.M, np.zeros((n, k))]), -s.q, np.where(own, np.inf, -s.q)),
        LinearConstraint(np.hstack([np.eye(n), -Zb])[own], -np.inf, 0.0),
        LinearConstraint(np.hstack([s.M, Wb])[own], -np.inf, (W - s.q)[own]),
    ]
    bounds = Bounds(np.append(np.where(own, 0.0, -np.inf), np.zeros(k)), np.append(Z, np.ones(k)))
    for cuts in range(_CUTS + 1):
        left = end - time.monotonic()
        if left <= 0:
            return "unknown", None, cuts
        r = milp(
            np.zeros(n + k),
            constraints=constraints,
            bounds=bounds,
            integrality=np.append(np.zeros(n), np.ones(k)),
            options={"time_limit": left},
        )
        if r.x is None:
            return ("none" if r.status == 2 and cuts == 0 else "unknown"), None, cuts
        chosen = r.x[n:] > 0.5
        on = s.free.copy()
        on[pairs] = chosen
        for z in _members(s, on, Z):
            if accept(z):
                return "solution", read_only(z), cuts
        sign = np.where(chosen, -1.0, 1.0)  # at least one pair has to choose otherwise
        cut = np.append(np.zeros(n), sign)
        constraints.append(LinearConstraint(cut[None], 1.0 - chosen.sum(), np.inf))
    return "unknown", None, _CUTS


def _members(s: Scaled, on: Bools, Z: Array) -> Iterator[Array]:
    """Exact candidates of the active set `on` (n,): by a linear solve; by a linear program where that is not enough
    (singular: a continuum, of which the solve sees one member), the program's point polished, then as it is.
    """
    yield _polish(s, on)
    from scipy.optimize import linprog

    lp = linprog(
        np.where(on & ~s.free, 1.0, 0.0),
        A_eq=s.M[on] if on.any() else None,
        b_eq=-s.q[on] if on.any() else None,
        A_ub=-s.M[~on] if (~on).any() else None,
        b_ub=s.q[~on] if (~on).any() else None,
        bounds=np.column_stack([np.where(s.free, -np.inf, 0.0), np.where(on, Z, 0.0)]),
        method="highs",
        options={"primal_feasibility_tolerance": 1e-10},
    )
    if lp.x is not None:
        yield _polish(s, s.free | (lp.x > 0.0))
        yield np.where(on, lp.x, 0.0)


def _polish(s: Scaled, on: Bools) -> Array:
    """M_AA z_A = -q_A for the active set A = on, and a few Newton steps from there should its signs be wrong."""
    z, w = np.where(on, 1.0, 0.0), np.where(on, 0.0, 1.0)
    active_set(s.M, s.q, s.free, z, w, 4, SOLVE * 1e-3, RANK)
    return z
