"""The search of `handlcp.lcp.search` with bounds and answer in the user's units."""

from __future__ import annotations

from dataclasses import replace

from handlcp.check import Array, array
from handlcp.errors import InputError
from handlcp.lcp import LCP
from handlcp.lcp import search as generic
from handlcp.lcp.search import SearchResult

__all__ = ["SearchResult", "search"]


def search(problem: LCP, z_max: Array, w_max: Array, time_limit: float = 30.0) -> SearchResult:
    """With 0 ≤ z ≤ z_max and 0 ≤ w ≤ w_max, (n,) each, and z in the user's units (ignored on free rows)."""
    u = problem.scaled.units
    for name, value in (("z_max", z_max), ("w_max", w_max)):
        if not (array(name, value, (problem.n,)) > 0).all():
            raise InputError(name, "positive bounds", f"a smallest of {value.min():.3g}")
    found = generic.search(problem, z_max / u.z, w_max / u.w, time_limit)
    return replace(found, z=None if found.z is None else found.z * u.z)
