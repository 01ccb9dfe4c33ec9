"""Grasps that ask for more than the solver's first stage, spread over processes: most of that work is Python's."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

import numpy as np

from handlcp.grasp.grasp import Grasp
from handlcp.grasp.pyramid import Section
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.solving import solve
from handlcp.lcp import Auto, ContactSolver, Solver

__all__ = ["one_by_one"]

_ALONE = 2.0  # seconds of work that are done here, before other processes are worth waking [s]
_BATCH = 4  # grasps that travel together: they share the hand that they are of


def one_by_one(
    grasps: Sequence[Grasp],
    sections: Sequence[Section],
    solver: Solver | ContactSolver | Auto | None,
    workers: int,
) -> Iterator[GraspSolution]:
    """The solution of each, in order, through all stages of the solver; `workers` processes for long lists."""
    begun, k = time.perf_counter(), 0
    while k < len(grasps) and (workers == 1 or time.perf_counter() - begun < _ALONE):
        yield solve(grasps[k], sections[k], solver, throw=False)
        k += 1
    if k == len(grasps):
        return
    from joblib import Parallel, delayed  # a tenth of a second that short lists should not pay

    batches = [slice(at, at + _BATCH) for at in range(k, len(grasps), _BATCH)]
    run = Parallel(n_jobs=workers, return_as="generator", batch_size=1)
    for batch, answers in zip(
        batches, run(delayed(_batch)(grasps[b], sections[b], solver) for b in batches), strict=True
    ):
        for grasp, solution in zip(grasps[batch], answers, strict=True):
            yield replace(_read_only(solution), scene=grasp.scene)


def _batch(
    grasps: Sequence[Grasp], sections: Sequence[Section], solver: Solver | ContactSolver | Auto | None
) -> list[GraspSolution]:
    """In another process; scenes stay at home."""
    return [replace(solve(g, s, solver, throw=False), scene=None) for g, s in zip(grasps, sections, strict=True)]


def _read_only(solution: GraspSolution) -> GraspSolution:
    """Arrays that have travelled can be written to."""
    for f in fields(solution):
        value = getattr(solution, f.name)
        for array in value.values() if isinstance(value, dict) else (value,):
            if isinstance(array, np.ndarray):
                array.flags.writeable = False
    return solution
