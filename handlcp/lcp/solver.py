"""`Solver`: the protocol that solvers share, one run of the compiled method, and where it starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol, runtime_checkable

import numpy as np

from handlcp.check import Array, check_init_call, check_integer, check_number
from handlcp.errors import InputError
from handlcp.lcp.contact_problem import ContactProblem
from handlcp.lcp.kernels.contact_newton import solve_contacts, solve_sticking
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.lcp.kernels.kaczmarz import PlainRows, Seeds, run_kaczmarz
from handlcp.lcp.kernels.newton import polish_active_set, run_active_set, run_damped_newton, unknown_size
from handlcp.lcp.problem import Proposal, ScaledLCP
from handlcp.tolerances import FINE_SOLVE_TOLERANCE, SOLVE_TOLERANCE

# ---------------------------------------------------------------- What every solver is.


@runtime_checkable
class Solver(Protocol):
    """A method with its settings. It proposes; the certifier decides."""

    def propose(self, problem: ScaledLCP, start: Array | None = None) -> Proposal:
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


def solve_compiled(
    problem: ContactProblem, seed: int, most: int, polish: bool, tolerance: float, start: Array | None = None
) -> Proposal:
    """The candidate of a solve from `start` (n,), natural units; None: from the linear solution in which
    contacts with a gap are open and all others stick.

    seed : of the row sampling. most : Kaczmarz steps at most; 0: Newton's alone, whose steps are then what counts as
    iterations. polish : Newton's method before and between them.
    """
    order, x = problem.pattern.order, np.empty(problem.n)
    y = np.zeros(problem.n) if start is None else np.asarray(start, dtype=float)[order]
    aim = min(tolerance, SOLVE_TOLERANCE) * 1e-2 if polish else tolerance
    steps, newton, r = solve_contacts(problem.arrays, y, start is None, seed, most, polish, aim)
    x[order] = y
    return Proposal(x, steps if most else newton, describe_outcome(r <= tolerance, steps, newton))


def describe_outcome(solved: bool, kaczmarz: int, newton: int) -> str:
    """Which part of the method worked, in words."""
    taken = f"{newton} Newton steps" if newton else ""
    if kaczmarz:
        taken = f"{kaczmarz} Kaczmarz steps{' and ' if taken else ''}{taken}"
    return f"{'converged' if solved else 'budget spent'} after {taken or 'no step'}"


def has_converged(proposal: Proposal) -> bool:
    """Whether `solve_compiled` reached the residual that it was asked for."""
    return proposal.outcome.startswith("converged")


def scale_by_limits(problem: ContactProblem) -> tuple[ContactProblem, Array]:
    """The same problem with each tangential force measured by its limit, and s (n,): x = s x' leads back.

    x = S x', y' = S y and M' = S M S, S diagonal: one on all but tangents, and one factor a block, so that sets keep
    their shapes and y' the direction of y. Where friction is weak a tangential force is a small part of a normal one;
    unless its equations count as much, Newton's line search does not see them.
    """
    s, size = np.ones(problem.n), np.clip(problem.limits, _LEAST_LIMIT, 1.0)
    for tangent in problem.blocks[:, 1:].T:
        there = tangent >= 0
        s[tangent[there]] = size[there]
    return problem.with_numbers(problem.M * s[:, None] * s, problem.q * s, problem.limits / size), s


# ----------------------------------------------------------------
# The semismooth Newton method alone: few steps where it converges, from a start that is near enough.


@check_init_call()
@dataclass(frozen=True, slots=True)
class SemismoothNewton:
    """Damped semismooth Newton on the Fischer–Burmeister equations (De Luca, Facchinei & Kanzow 1996), compiled; on
    contact problems, with cones or faces, on the projection equations of Alart & Curnier (1991).

    tol : stop at a natural residual ≤ tol in natural units.
    max_iterations : Newton steps at most; a contact problem gets no more than 32.

    It descends on ½‖Φ‖², whose local minima may not solve the problem: friction makes it non-monotone.
    """

    tol: float = SOLVE_TOLERANCE
    max_iterations: int = 100

    def __post_init__(self) -> None:
        object.__setattr__(self, "tol", check_number("tol", self.tol, above=0.0))
        object.__setattr__(self, "max_iterations", check_integer("max_iterations", self.max_iterations, 1))

    def propose(self, problem: ScaledLCP, start: Array | None = None) -> Proposal:
        """Run from `start` (n,), zero when None; an exact active-set solve takes the last digits."""
        M, q, free = problem.M, problem.q, problem.free
        z = np.zeros(len(q)) if start is None else np.array(start, dtype=float)
        steps, _ = run_damped_newton(M, q, free, z, np.empty(len(q)), self.max_iterations, self.tol)
        z, r = polish_active_set(M, q, free, z, self.tol * 1e-3)
        return Proposal(z, steps, "converged" if r <= self.tol else f"stalled after {steps} Newton steps")

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """Run from `start` (n,); None: from where every contact sticks that starts without a gap."""
        return solve_compiled(problem, 0, 0, True, self.tol, start)


# ----------------------------------------------------------------
# NSNGRK, the core: greedy randomized Kaczmarz steps, ended by exact Newton steps once the active set settles.


@check_init_call()
@dataclass(frozen=True, slots=True)
class NSNGRK:
    """Newton–subgradient non-smooth greedy randomized Kaczmarz (paper, Algorithm 2), compiled.

    tol : stop at ‖Φ(z)‖₂ ≤ tol in natural units (polished: natural residual ≤ tol).
    max_iterations : Kaczmarz steps at most.
    seed : of the row sampling; equal seeds give equal runs.
    polish : end with exact active-set and semismooth Newton steps, and go back to more Kaczmarz steps, twice as many
        each time, when they don't help. On contact problems Newton's method comes first. False: the paper's method
        alone.
    stride : record (step, ‖Φ‖) every so many steps in the result's `history`; 0: not at all. Plain problems only.

    The paper's analytic subgradient is used instead of forward differences (n times cheaper, and exact).
    """

    tol: float = SOLVE_TOLERANCE
    max_iterations: int = 20_000
    seed: int = 0
    polish: bool = True
    stride: int = 0

    def __post_init__(self) -> None:
        # One number type each: another would be compiled anew
        object.__setattr__(self, "tol", check_number("tol", self.tol, above=0.0))
        for name in ("max_iterations", "seed", "stride"):
            object.__setattr__(self, name, check_integer(name, getattr(self, name), 0))
        if not isinstance(self.polish, bool):
            raise InputError("polish", "True or False", repr(self.polish))

    def propose(self, problem: ScaledLCP, start: Array | None = None) -> Proposal:
        """Run from `start` (n,), zero when None."""
        M, n = problem.M, len(problem.q)
        z = np.zeros(n) if start is None else np.array(start, dtype=float)
        history = np.empty((1 + self.max_iterations // self.stride if self.stride else 0, 2))
        rows = PlainRows(M, np.ascontiguousarray(M.T), M @ M.T, problem.q, problem.free)
        state, most = np.full(1, self.seed, np.uint64), self.max_iterations
        if self.polish:
            steps, solved, written = _run_polished(rows, z, state, most, self.tol, self.stride, history)
        else:
            w = np.empty(n)
            multiply_add(M, z, problem.q, w)
            steps, norm, written = run_kaczmarz(rows, z, w, state, most, self.tol, self.stride, history)
            solved = norm <= self.tol
        words = "converged" if solved else f"{steps} Kaczmarz steps spent"
        return Proposal(z, steps, words, history[:written] if self.stride else None)

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """The same method on the rows of a contact problem, from `start` (n,); None: where every contact sticks."""
        return solve_compiled(problem, self.seed, self.max_iterations, self.polish, self.tol, start)


@kernel
def _run_polished(
    p: PlainRows, z: Array, state: Seeds, most: int, tolerance: float, stride: int, history: Array
) -> tuple[int, bool, int]:
    """Kaczmarz steps in place, with Newton's in between. (steps, converged, history rows)."""
    n = len(z)
    w = np.empty(n)
    multiply_add(p.M, z, p.q, w)
    taken, written, batch = 0, 0, n
    zt, wt = np.empty(n), np.empty(n)
    best, best_z = np.inf, z.copy()
    while True:
        done, _norm, rows = run_kaczmarz(p, z, w, state, min(batch, most - taken), tolerance, stride, history[written:])
        for k in range(written, written + rows):
            history[k, 0] += taken
        taken, written = taken + done, written + rows
        zt[:], wt[:] = z, w
        _, r = run_active_set(p.M, p.q, p.free, zt, wt, 16, tolerance)
        if batch > n and not r <= tolerance * unknown_size(zt):
            zt[:], wt[:] = z, w
            _, r = run_damped_newton(p.M, p.q, p.free, zt, wt, 30, tolerance)
            if r > tolerance:
                _, r = run_active_set(p.M, p.q, p.free, zt, wt, 4, tolerance)
        if r < best:
            best = r
            best_z[:] = zt
        if r <= tolerance * unknown_size(zt):
            z[:] = zt
            return taken, True, written
        if taken >= most or done < batch:  # spent, or stalled where no row moves any more
            z[:] = best_z
            return taken, False, written
        batch *= 2


# ----------------------------------------------------------------
# Newton's method from other places: a nearby answer, or where only some of the contacts (or pairs) hold.


_SHORT_NEWTON = SemismoothNewton(max_iterations=30)  # from each start of a plain problem


@dataclass(frozen=True, slots=True)
class OtherStarts:
    """Newton's method from where other subsets of the contacts stick, slip without friction, or stay apart; of a plain
    LCP from other active sets.

    tries : starts at most, what the result's `iterations` counts. seed : of the subsets.

    Newton's method converges from near enough or not at all, and soon: many short runs find more than a few long ones.
    """

    tries: int = 40
    seed: int = 0

    def __post_init__(self) -> None:
        check_integer("tries", self.tries, 1)
        check_integer("seed", self.seed, 0)

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """The first start that converges, else the last; a `start` (n,) is tried before all others."""
        rng, order = np.random.default_rng(self.seed), problem.pattern.order

        def held_by_some(k: int) -> Array:
            # Every share of contacts apart is as likely as any other; in every second start nothing slips
            apart = rng.random(problem.n) < rng.random()
            slippery = rng.random(len(problem.blocks)) < (k % 2) * rng.random()
            x, y = np.empty(problem.n), np.empty(problem.n)
            solve_sticking(problem.arrays, apart[order], slippery, y)
            x[order] = y
            return x

        newton = partial(solve_compiled, problem, 0, 0, True, FINE_SOLVE_TOLERANCE)
        return self._first_converged(newton, held_by_some, start)

    def propose(self, problem: ScaledLCP, start: Array | None = None) -> Proposal:
        """The same for a plain problem: the unknowns of a random active set start at 0.1 to 10, the others at 0."""
        rng, n = np.random.default_rng(self.seed), len(problem.q)

        def some_active(k: int) -> Array:
            return np.where(rng.random(n) < rng.random(), 10.0 ** rng.uniform(-1.0, 1.0, n), 0.0)

        return self._first_converged(partial(_SHORT_NEWTON.propose, problem), some_active, start)

    def _first_converged(
        self, newton: Callable[[Array], Proposal], place: Callable[[int], Array], start: Array | None
    ) -> Proposal:
        for k in range(self.tries):
            p = newton(start if k == 0 and start is not None else place(k))
            if has_converged(p):
                return replace(p, iterations=k + 1, outcome=f"converged from start {k + 1}")
        return replace(p, iterations=self.tries, outcome="all starts spent")
