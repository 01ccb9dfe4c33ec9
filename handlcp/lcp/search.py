"""All active sets of a linear complementarity problem at once: a solution, or proof of none within stated bounds.

By the mixed-integer program of `mode_program`, in natural units. "None" stands, but a point that the program finds is
believed only when its active set, solved exactly, passes the certifier; otherwise that choice is cut off and the search
goes on. "None" speaks of the box, not beyond it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from handlcp.check import Array, Bools, array, number, read_only
from handlcp.errors import InputError
from handlcp.lcp.certify import certify
from handlcp.lcp.contact import ContactProblem, FrictionSets, Pattern
from handlcp.lcp.kernels.newton import active_set
from handlcp.lcp.mode_program import ModeProgram
from handlcp.lcp.problem import LCP, Scaled
from handlcp.lcp.status import Status
from handlcp.tolerances import SOLVE

__all__ = ["Outcome", "SearchResult", "search"]

Outcome: TypeAlias = Literal["solution", "none", "unknown"]
Accept: TypeAlias = Callable[[Array], bool]

_NARROW, _WIDE = 10.0, 1e3  # default boxes, times 1 + max|q̂|: the first finds quickly, the second proves
_CUTS = 20  # choices cut off before the search gives up
_NO_BLOCKS, _NO_LIMITS = np.zeros((0, 4), np.int64), np.zeros(0)


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
    problem: LCP, bound_z: Any = None, bound_w: Any = None, seconds: float = 10.0, accept: Accept | None = None
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
    pairs, cuts = ContactProblem(s.M, s.q, Pattern.of(s.free, _NO_BLOCKS), FrictionSets(_NO_LIMITS, 0), s.units), 0
    for k, factor in enumerate(boxes, 1):
        Z = _bound("bound_z", bound_z, factor * size, s.free, np.inf)
        W = _bound("bound_w", bound_w, factor * size, s.free, 0.0)
        program, before, z = ModeProgram(pairs, Z, W), cuts, None
        for points in program.visit(start + limit * k / len(boxes), _CUTS):
            near = (c for x in points for c in (_polish(s, s.free | (x > 0.0)), x))
            if (z := next(filter(ok, near), None)) is not None:
                break
            cuts += 1
        if z is not None:
            break
    none = program.exhausted and cuts == before
    outcome: Outcome = "solution" if z is not None else "none" if none else "unknown"
    z = z if z is None else read_only(z)
    return SearchResult(outcome, z, Z, W, time.monotonic() - start, int((~s.free).sum()), cuts)


def _bound(name: str, value: Any, default: float, free: Bools, elsewhere: float) -> Array:
    n = len(free)
    out = np.full(n, default) if value is None else np.zeros(n) + array(name, value, (), (n,))
    if not (out > 0).all():
        raise InputError(name, "positive bounds", f"a smallest of {out.min():.3g}")
    out[free] = elsewhere
    return read_only(out)


def _polish(s: Scaled, on: Bools) -> Array:
    """M_AA z_A = -q_A for the active set A = on, and a few Newton steps from there should its signs be wrong."""
    z, w = np.where(on, 1.0, 0.0), np.where(on, 0.0, 1.0)
    active_set(s.M, s.q, s.free, z, w, 4, SOLVE * 1e-3)
    return z
