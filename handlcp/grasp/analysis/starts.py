"""Where a search for equilibria starts from: answers of coarser pyramids, other seeds, other methods."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np

from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.search.mode_table import coarse
from handlcp.grasp.search.nearby import only_limits_move
from handlcp.lcp import NSNGRK
from handlcp.lcp.kernels.lemke import lemke
from handlcp.lcp.multipliers import WithMultipliers
from handlcp.lcp.reduce import reduce
from handlcp.tolerances import PIVOT

_COARSER = (6, 8, 12, 5, 4, 3)  # faces of pyramids whose equilibria are good places to start from
RUNS = 8  # other seeds and starts

T = TypeVar("T")


def starts(problem: GraspContactProblem, end: float) -> Iterator[Candidate]:
    """Answers of coarser pyramids, as many as the time allows, then of other seeds and starts."""
    several = only_limits_move(problem) and problem.faces != 2
    for k, faces in enumerate([m for m in _COARSER if m != problem.faces] if several else ()):
        left = end - time.monotonic()
        near = coarse(problem, faces, 0.5 * (left if k else max(left, 1.0)))  # the first whatever the time
        yield from (c for c in (until(end, near) if k else near) if c is not None)
    yield from until(end, seeded(problem, RUNS))


def until(end: float, candidates: Iterator[T]) -> Iterator[T]:
    """The first ones, up to a time of `time.monotonic()`; one at least."""
    for candidate in candidates:
        yield candidate
        if time.monotonic() > end:
            return


def seeded(problem: GraspContactProblem, runs: int = 4, seed: int = 1) -> Iterator[Candidate]:
    """Candidates of NSNGRK from other starts with other seeds, and of Lemke's method with other covering vectors (on
    the pyramid, or an 8-face one for the exact cone, from which Newton's method goes on).
    """
    rng, method = np.random.default_rng(seed), NSNGRK(max_iterations=16 * problem.n)
    lcp = WithMultipliers(problem, problem.flat(8) if problem.flat and not problem.faces else None)
    r = reduce(lcp.scaled)
    for k in range(runs):
        start = rng.exponential(size=problem.n) * rng.choice([-1.0, 0.0, 1.0], problem.n)
        start[problem.role == 1] = abs(start[problem.role == 1])
        yield problem.candidate(replace(method, seed=seed + k).propose_contact(problem, start).z)
        _, _, v = lemke(r.M, r.q, 10.0 ** rng.uniform(-1, 1, len(r.q)), 50 + 20 * len(r.q), PIVOT)
        yield problem.candidate(method.propose_contact(problem, lcp.back(r.restore(v))).z)
