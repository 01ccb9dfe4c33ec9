"""What solvers share: their protocol, and of contact problems one run of the compiled method and where it starts."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.contact_packed import hold_packed, solve_packed
from handlcp.lcp.problem import Proposal, Scaled
from handlcp.tolerances import SOLVE

# ---------------------------------------------------------------- What every solver is.


@runtime_checkable
class Solver(Protocol):
    """A method with its settings. It proposes; the certifier decides."""

    def propose(self, problem: Scaled, start: Array | None = None) -> Proposal:
        """A candidate for the problem in natural units, from `start` (n,) natural units, zero when None."""
        ...


@runtime_checkable
class ContactSolver(Protocol):
    """A method that knows friction as a set, the exact cone included. Most are a `Solver` as well."""

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """A candidate x (n,) in natural units, from `start` (n,) or, when None, from where the method sees fit."""
        ...


# ----------------------------------------------------------------
# What solvers of contact problems share: one run of the compiled method, places to start from, and other units.

_LEAST_LIMIT = 1e-9  # a weaker limit would put its rows beyond the rank tolerance


def run_contact(
    problem: ContactProblem, seed: int, most: int, polish: bool, tolerance: float, start: Array | None = None
) -> Proposal:
    """The candidate of `found_by`."""
    return Proposal(*found_by(problem, seed, most, polish, tolerance, start))


def found_by(
    problem: ContactProblem, seed: int, most: int, polish: bool, tolerance: float, start: Array | None = None
) -> tuple[Array, int, str]:
    """(x, iterations, outcome) of a solve from `start` (n,), natural units; None: from the linear solution in which
    contacts with a gap are open and all others stick.

    seed : of the row sampling. most : Kaczmarz steps at most; 0: Newton's alone, whose steps are then what counts as
    iterations. polish : Newton's method before and between them.
    """
    numbers, whole = problem.prepared
    x = np.empty(problem.n) if start is None else np.array(start, dtype=float)
    aim = min(tolerance, SOLVE) * 1e-2 if polish else tolerance
    steps, newton, r = solve_packed(numbers, whole, x, start is None, seed, most, polish, aim)
    return x, steps if most else newton, outcome(r <= tolerance, steps, newton)


def outcome(solved: bool, kaczmarz: int, newton: int) -> str:
    """Which part of the method worked, in words."""
    taken = f"{newton} Newton steps" if newton else ""
    if kaczmarz:
        taken = f"{kaczmarz} Kaczmarz steps{' and ' if taken else ''}{taken}"
    return f"{'converged' if solved else 'budget spent'} after {taken or 'no step'}"


def converged(proposal: Proposal) -> bool:
    """Whether `run_contact` reached the residual that it was asked for."""
    return proposal.outcome.startswith("converged")


def held(problem: ContactProblem, apart: Bools, slippery: Bools) -> Array:
    """(n,) solution of the linear problem in which pairs stay at x_i = 0 where `apart` (n,), blocks carry no tangential
    force where `slippery` (k,), and every other contact sticks.
    """
    numbers, whole = problem.prepared
    x = np.empty(problem.n)
    hold_packed(numbers, whole, apart, slippery, x)
    return x


def measured_by_limits(problem: ContactProblem) -> tuple[ContactProblem, Array]:
    """The same problem with each tangential force measured by its limit, and s (n,): x = s x' leads back.

    x = S x', y' = S y and M' = S M S, S diagonal: one on all but tangents, and one factor a block, so that sets keep
    their shapes and y' the direction of y. Where friction is weak a tangential force is a small part of a normal one;
    unless its equations count as much, Newton's line search does not see them.
    """
    s, size = np.ones(problem.n), np.clip(problem.limits, _LEAST_LIMIT, 1.0)
    for tangent in problem.blocks[:, 1:].T:
        there = tangent >= 0
        s[tangent[there]] = size[there]
    return problem.varied(problem.M * s[:, None] * s, problem.q * s, problem.limits / size), s
