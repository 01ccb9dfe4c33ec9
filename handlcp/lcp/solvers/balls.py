"""The chain of stages on a `BallProblem`: Newton's method from where contacts stick, then from pivoted answers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.balls import BallProblem
from handlcp.lcp.kernels.balls import ball_held, ball_newton
from handlcp.lcp.kernels.contact import row_scales
from handlcp.lcp.result import Proposal
from handlcp.lcp.solvers.lemke import Lemke
from handlcp.tolerances import RANK, SOLVE

__all__ = ["ball_plan", "ball_stages"]

_SCALES = (1.0, 0.1, 10.0, 0.01)  # of ρ: which contacts Newton's next step takes for sticking depends on it
_STEPS = 40
_FACES = (8, 12)  # of the polyhedra that Lemke's method pivots on
_STARTS = 30
_MANY = 16  # faces beyond which pivoting costs more than the other methods
_FIRST, _OTHERS, _LAST = "Newton", "Newton from other starts", "more friction first"


def ball_plan(problem: BallProblem) -> tuple[str, ...]:
    """The names of the stages, in order; where Lemke's method has no answer, nothing starts from it."""
    names = [_FIRST]
    for m in _pivoted(problem):
        names += ["Lemke"] * (m == problem.own) + [_from(m)]
    return (*names, _OTHERS, _LAST)


def ball_stages(problem: BallProblem, seed: int, start: Array | None = None) -> Iterator[tuple[str, Proposal]]:
    """(name, candidate) one after the other, each computed when asked for; start (n,) natural units."""
    run = _Runs(problem)
    if start is not None:
        yield _FIRST, run.newton(start)
    yield _FIRST, run.newton(run.held())
    for m in _pivoted(problem):
        lcp, back = problem.pyramid(m)
        p = Lemke(seed=seed).propose(lcp.scaled)
        if np.isfinite(p.z).all():
            if m == problem.own:
                yield "Lemke", replace(p, z=back(p.z))
            yield _from(m), run.newton(back(p.z))
    yield _OTHERS, run.from_other_starts(seed)
    yield _LAST, run.continued()


def _pivoted(problem: BallProblem) -> tuple[int, ...]:
    """Faces of the polyhedra that Lemke's method pivots on."""
    return tuple(dict.fromkeys((problem.own, *_FACES))) if 0 < problem.own <= _MANY else _FACES


def _from(faces: int) -> str:
    return f"Newton from Lemke, {faces} faces"


class _Runs:
    """Newton's method on one problem."""

    def __init__(self, problem: BallProblem) -> None:
        self.problem, self.rho = problem, row_scales(problem.M, problem.balls)
        self.role: Ints = np.where(problem.free, 0, 1).astype(np.int64)
        tangents = problem.balls[:, 1:]
        self.role[tangents[tangents >= 0]] = 2

    def held(self, apart: Bools | None = None, slippery: Bools | None = None) -> Array:
        """(n,) where contacts stick that start without a gap, or as `ball_held` is told."""
        p, x = self.problem, np.empty(self.problem.n)
        gone = (self.role == 1) & (p.q > 0.0) if apart is None else apart
        smooth = np.zeros(len(p.balls), bool) if slippery is None else slippery
        ball_held(p.M, p.q, p.free | (self.role == 2), p.balls, gone, smooth, x, RANK)
        return x

    def newton(self, start: Array, limits: Array | None = None) -> Proposal:
        """The best of Newton's method with several scales of ρ."""
        p, best, best_r, taken = self.problem, start, np.inf, 0
        for scale in _SCALES:
            x = start.copy()
            steps, r = ball_newton(
                p.M, p.q, self.role, p.balls, p.limits if limits is None else limits, *p.faces, self.rho * scale, x,
                _STEPS, SOLVE, RANK,
            )  # fmt: skip
            taken += steps
            if r < best_r:
                best, best_r = x, r
            if r <= SOLVE:
                break
        outcome = "converged" if best_r <= SOLVE else "budget spent"
        return Proposal(best, taken, f"{outcome}, {taken} Newton steps")

    def from_other_starts(self, seed: int) -> Proposal:
        """The first that converges from where other subsets of the contacts stick or stay apart; else the last."""
        rng, p, found = np.random.default_rng(seed), self.problem, Proposal(np.zeros(self.problem.n), 0, "not begun")
        for k in range(_STARTS):
            apart = rng.random(p.n) < rng.random()
            slippery = rng.random(len(p.balls)) < (k % 2) * rng.random()
            found = self.newton(self.held(apart, slippery))
            if found.outcome.startswith("converged"):
                break
        return found

    def continued(self) -> Proposal:
        """From ten times the friction down to what there is, each answer the next start."""
        p, x, taken = self.problem, self.held(), 0
        for factor in np.geomspace(10.0, 1.0, 9):
            found = self.newton(x, p.limits * factor)
            x, taken = found.z, taken + found.iterations
        return Proposal(found.z, taken, found.outcome)
