"""Contact problems as Newton's method likes them: units, neighbours, and places to start from."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.dense import solve_ranked
from handlcp.lcp.result import Proposal
from handlcp.tolerances import RANK, SOLVE

__all__ = ["FINE", "converged", "held", "in_units_of_limits", "varied"]


FINE = SOLVE * 1e-2  # friction limits of 1e-6 ask more of a residual than the rest does


def converged(proposal: Proposal) -> bool:
    """Whether `run_contact` reached the residual that it was asked for."""
    return proposal.outcome.startswith("converged")


def varied(problem: ContactProblem, q: Array, limits: Array) -> ContactProblem:
    """Another problem with the same M."""
    return ContactProblem(
        problem.M, q, problem.free, problem.blocks, limits, problem.faces, problem.units, problem.pyramid
    )


def held(problem: ContactProblem, apart: Bools, slippery: Bools) -> Array:
    """(n,) solution of the linear problem in which pairs stay at x_i = 0 where `apart` (n,), blocks carry no tangential
    force where `slippery` (k,), and every other contact sticks.
    """
    x = np.empty(problem.n)
    _held(problem.M, problem.q, problem.role, problem.blocks, apart, slippery, x, RANK)
    return x


def in_units_of_limits(problem: ContactProblem) -> tuple[ContactProblem, Array]:
    """The same problem with each tangential force measured by its limit, and s (n,): x = s x' leads back.

    x = S x', y' = S y and M' = S M S, S diagonal: one on all but tangents, and one factor a block, so that the disc or
    polygon keeps its shape and y' the direction of y. Where friction is weak a tangential force is a small part of a
    normal one; unless its equations count as much, Newton's line search does not see them.
    """
    s = np.ones(problem.n)
    size = np.clip(problem.limits, _LEAST_LIMIT, 1.0)
    for axis in (1, 2):
        there = problem.blocks[:, axis] >= 0
        s[problem.blocks[there, axis]] = size[there]
    M = problem.M * s[:, None] * s
    return ContactProblem(
        M, problem.q * s, problem.free, problem.blocks, problem.limits / size, problem.faces, problem.units
    ), s


_LEAST_LIMIT = 1e-9  # a weaker limit would put its rows beyond the rank tolerance


@kernel
def _held(
    M: Array, q: Array, role: Ints, blocks: Ints, apart: Bools, slippery: Bools, x: Array, rank_tolerance: float
) -> None:
    n = len(x)
    A, b, col = M.copy(), -q, np.empty(n, np.int64)
    for i in range(n):
        if role[i] == 1 and apart[i]:
            A[i], A[i, i], b[i] = 0.0, 1.0, 0.0
    for k in range(len(blocks)):
        if apart[blocks[k, 0]] or slippery[k]:
            for a in range(1, 3):
                i = blocks[k, a]
                if i >= 0:
                    A[i], A[i, i], b[i] = 0.0, 1.0, 0.0
    solve_ranked(A, b, x, col, rank_tolerance)
