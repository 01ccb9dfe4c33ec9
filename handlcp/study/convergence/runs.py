"""One run of NSNGRK without its exact ending, observed along the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp import Grasp, GraspProblem
from handlcp.lcp import LCP, NSNGRK, Proposal
from handlcp.study.convergence.rates import generalized_jacobian, greedy_bound, measured_rate, uniform_bound
from handlcp.study.nsngrk import UniformRows, UnitsOf, in_units

Sampling = Literal["greedy", "uniform"]

Read = Callable[[Array], Array]  # from an iterate in natural units

_HISTORY, _LOOKS = 400, 60  # points of a history; steps at which values are recorded, evenly over their logarithm


@dataclass(frozen=True, slots=True)
class Run:
    """One seed in one set of units.

    units : as in `in_units`. sampling, seed : of the rows.
    history : (k, 2) step and ‖Φ‖₂, in those units.
    looks : (m,) steps at which `values` (m, p) were recorded: normal forces [N] of a grasp, z of any other problem in
        the user's units.
    stop : the first step with ‖Φ‖ ≤ the stop rule, one of `looks`; None where it was never met.
    converged : whether it reached its tolerance.
    rate : measured decrease of ln ‖Φ‖ per step. bound : the least rate, from the conditioning at the run's end.
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
    """What to record of an iterate of `lcp`: the quantity, the names of its values, and how to compute them."""
    if isinstance(lcp, GraspProblem):
        fingers = range(1, lcp.scene.n + 1)
        names = problem.names if isinstance(problem, Grasp) else tuple(f"finger {i}" for i in fingers)
        return "normal force [N]", names, lambda z: np.asarray(lcp.candidate(z).forces[:, 2])
    return "z", tuple(f"z[{i}]" for i in range(lcp.n)), lambda z: np.asarray(z * lcp.scaled.units.z)


def follow(
    problem: LCP, read: Read, units: UnitsOf, sampling: Sampling, seed: int, tol: float, most: int, stop: float
) -> Run:
    """Run to ‖Φ‖ ≤ tol or `most` steps. Values at an earlier step come from the same run, repeated and ended there."""
    scaled, size = in_units(problem, units)

    def run(most: int, until: float = tol, stride: int = 0) -> Proposal:
        if sampling == "uniform":
            return UniformRows(until, most, seed, stride).propose(scaled)
        return NSNGRK(until, most, seed, polish=False, stride=stride).propose(scaled)

    end = run(most)
    steps = max(end.iterations, 1)
    history = run(steps, stride=max(1, steps // _HISTORY)).history
    assert history is not None
    early = run(steps, until=max(stop, tol))
    stopped = early.iterations if early.outcome == "converged" else None
    looks = np.unique([*np.geomspace(1, steps, _LOOKS).astype(int), *([] if stopped is None else [stopped])])
    values = np.array([read(run(int(k)).z / size) for k in looks])
    J = generalized_jacobian(scaled, end.z)
    bound = greedy_bound(J) if sampling == "greedy" else uniform_bound(J)
    rate, there = measured_rate(history), end.outcome == "converged"
    return Run(units, sampling, seed, read_only(history), looks, read_only(values), stopped, there, rate, bound)
