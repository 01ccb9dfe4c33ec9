"""The two calls that are timed, each on a new problem or grasp, so that nothing is left from the call before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import handlcp as hl
from tests.benchmarks.clock import Task
from tests.benchmarks.corpus import Faces

__all__ = ["assembled", "call_solve", "call_solve_lcp"]


def assembled(grasp: Callable[[], hl.Grasp], faces: Faces) -> Any:
    """The problem as `solve_lcp` gets it."""
    return grasp().problem(faces)


def call_solve(grasp: Callable[[], hl.Grasp], faces: Faces) -> Task:
    """`grasp.solve`; `grasp` makes a new one."""

    def task() -> Callable[[], Any]:
        g = grasp()
        return lambda: g.solve(faces, throw=False)

    return task


def call_solve_lcp(problem: Callable[[], Any]) -> Task:
    """`solve_lcp`, certificate included; `problem` makes a new one."""

    def task() -> Callable[[], Any]:
        p = problem()
        return lambda: hl.solve_lcp(p, throw=False)

    return task
