"""All active sets of a linear complementarity problem at once: a solution, or proof of none within stated bounds.

By the tree of `mode_search`, in natural units. "None" stands, but a point that the tree finds is believed only when its
active set, solved exactly, passes the certifier; otherwise nothing is claimed. "None" speaks of the box, not beyond it.
"""

from __future__ import annotations

import math
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
from handlcp.lcp.kernels.projection import product
from handlcp.lcp.modes.search import ModeSearch
from handlcp.lcp.problem import LCP, Scaled, Status
from handlcp.tolerances import SOLVE

Outcome: TypeAlias = Literal["solution", "none", "unknown"]
Accept: TypeAlias = Callable[[Array], bool]

_WIDE = 1e3  # of the default box, times 1 + max|q̂|
_NO_BLOCKS, _NO_LIMITS = np.zeros((0, 4), np.int64), np.zeros(0)


@dataclass(frozen=True, slots=True)
class SearchResult:
    """What a search established.

    outcome : "solution" (certified), "none" (proved infeasible within the bounds) or "unknown" (work spent, or points
        refused: nothing is claimed).
    z : (n,) the solution in natural units, or None.
    bound_z, bound_w : (n,) the box, natural units; infinite z, zero w on free rows.
    seconds : wall time. pairs : how many there are. cuts : choices that the certifier refused.
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
    problem: LCP, bound_z: Any = None, bound_w: Any = None, work: float = 5e8, accept: Accept | None = None,
    end: float = math.inf,
) -> SearchResult:  # fmt: skip
    """Search for a solution, or for the proof that there is none with 0 ≤ z ≤ bound_z and 0 ≤ w ≤ bound_w.

    bound_z, bound_w : each a number or (n,), natural units (ignored on free rows); None: 1000 (1 + max|q̂|).
    work : multiply-adds it may take; 5e8 are about a second. end : of `time.monotonic`, if earlier.
    accept : certifier of a candidate z (n,) in natural units; `certify` when None.

    Raises InputError for bounds that are not positive.
    """
    s, start = problem.scaled, time.monotonic()
    number("work", work, above=0.0)
    size = _WIDE * (1.0 + float(abs(s.q).max(initial=0.0)))
    Z, W = _bound("bound_z", bound_z, size, s.free, np.inf), _bound("bound_w", bound_w, size, s.free, 0.0)
    ok = accept or (lambda z: certify(problem, product(z, s.units.z))[0] is Status.SOLVED)
    pairs = ContactProblem(s.M, s.q, Pattern.of(s.free, _NO_BLOCKS), FrictionSets(_NO_LIMITS, 0), s.units)
    modes = ModeSearch(pairs, Z, W)
    near = (c for x in modes.candidates(work, end) for c in (_polish(s, s.free | (x > 0.0)), x))
    z = next(filter(ok, near), None)
    outcome: Outcome = "solution" if z is not None else "none" if modes.none else "unknown"
    z = z if z is None else read_only(z)
    return SearchResult(outcome, z, Z, W, time.monotonic() - start, int((~s.free).sum()), modes.refused)


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
