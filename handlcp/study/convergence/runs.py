"""One run of NSNGRK without its exact ending, watched along the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp import Grasp, GraspProblem
from handlcp.lcp import LCP, NSNGRK, Proposal
from handlcp.lcp.problem import Scaled
from handlcp.study.convergence.rates import generalized_jacobian, greedy_bound, measured_rate, uniform_bound

__all__ = ["Read", "Run", "Sampling", "UnitsOf", "follow", "watch"]

Sampling = Literal["greedy", "uniform"]
UnitsOf = Literal["natural", "equilibrated", "given"]

Read = Callable[[Array], Array]  # from an iterate in natural units

_HISTORY, _LOOKS = 400, 60  # points of a history; looks at what is watched, evenly over the logarithm of the steps


@dataclass(frozen=True, slots=True)
class Run:
    """One seed in one set of units.

    units : "natural", "equilibrated" (Ruiz's, which sees M and q only) or "given" (the user's, the paper's way).
    sampling, seed : of the rows.
    history : (k, 2) step and ‖Φ‖₂, in those units.
    looks : (m,) steps at which `values` (m, p) were read off: normal forces [N] of a grasp, z of any other problem in
        the user's units.
    stop : the first step with ‖Φ‖ ≤ the stop rule, one of `looks`; None where it was never met.
    converged : whether it got to its tolerance.
    rate : measured, the decrease of ln ‖Φ‖ per step. bound : the least that conditioning at the run's end promises.
    """

    units: UnitsOf
    sampling: Sampling
    seed: int
    history: Array
    looks: Ints
    values: Array
    stop: int | None
    converged: bool
    rate: float
    bound: float

    @property
    def stopped(self) -> Array:
        """(p,) values where the stop rule ends the run, or at its own end."""
        k = -1 if self.stop is None else int(np.searchsorted(self.looks, self.stop))
        return np.asarray(self.values[k])


def watch(problem: Grasp | LCP, lcp: LCP) -> tuple[str, tuple[str, ...], Read]:
    """What to read off an iterate of `lcp`: the quantity, its names, and how."""
    if isinstance(lcp, GraspProblem):
        fingers = range(1, lcp.scene.n + 1)
        names = problem.names if isinstance(problem, Grasp) else tuple(f"finger {i}" for i in fingers)
        return "normal force [N]", names, lambda z: np.asarray(lcp.candidate(z).forces[:, 2])
    return "z", tuple(f"z[{i}]" for i in range(lcp.n)), lambda z: np.asarray(z * lcp.scaled.units.z)


def follow(
    problem: LCP, read: Read, units: UnitsOf, sampling: Sampling, seed: int, tol: float, most: int, stop: float | None
) -> Run:
    """Run to ‖Φ‖ ≤ tol or `most` steps. Equal seeds give equal runs, so a look is the same run, ended earlier."""
    scaled = _in(problem, units)

    def run(most: int, until: float = tol, stride: int = 0) -> Proposal:
        return NSNGRK(until, most, seed, polish=False, stride=stride, sampling=sampling).propose(scaled)

    end = run(most)
    steps = max(end.iterations, 1)
    history = run(steps, stride=max(1, steps // _HISTORY)).history
    assert history is not None
    early = None if stop is None else run(steps, until=max(stop, tol))
    stopped = early.iterations if early is not None and early.outcome == "converged" else None
    looks = np.unique([*np.geomspace(1, steps, _LOOKS).astype(int), *([] if stopped is None else [stopped])])
    into = scaled.units.z / problem.scaled.units.z
    values = np.array([read(run(int(k)).z * into) for k in looks])
    J = generalized_jacobian(scaled, end.z)
    bound = greedy_bound(J) if sampling == "greedy" else uniform_bound(J)
    rate, there = measured_rate(history), end.outcome == "converged"
    return Run(units, sampling, seed, read_only(history), looks, read_only(values), stopped, there, rate, bound)


def _in(problem: LCP, units: UnitsOf) -> Scaled:
    if units == "natural":
        return problem.scaled
    return (problem.unscaled() if units == "given" else LCP(problem.M, problem.q, problem.free)).scaled
