"""Runs of the solvers, and the rates at which they converge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp import Grasp, GraspProblem
from handlcp.lcp import LCP, NSNGRK, Proposal
from handlcp.lcp.problem import Scaled
from handlcp.method.nsngrk import UniformRows, UnitsOf, in_units

# ----------------------------------------------------------------
# Linear convergence rates of Kaczmarz methods: bounds from conditioning, and rates measured on a residual history.
#
# Near a solution the rows of Φ are linear, Φ(z) ≈ J (z - z*), and a step projects the error e on a row of J. With σ the
# smallest singular value of J that is not zero (of J with rows of length one for uniform sampling), n rows g_i:
#
# greedy    E‖e'‖² ≤ (1 - ½ (‖J‖²_F / (‖J‖²_F - min_i |g_i|²) + 1) σ² / ‖J‖²_F) ‖e‖²
# uniform   E‖e'‖² ≤ (1 - σ² / n) ‖e‖²
#
# The greedy bound is Z.-Z. Bai & W.-T. Wu's, SIAM J. Sci. Comput. 40 (2018), A592-A606. It holds from the second step
# on and allows for the worst e: measured rates are 4 to 19 times as large.
#
# The uniform bound follows from E‖e'‖² = ‖e‖² - Σ_i (g_i·e / |g_i|)² / n, and is nearly sharp. The mean error, E e' =
# (I - Jᵀ J / n) e with rows of length one, shrinks by 1 - σ² / n in its slowest part, and E‖e‖² no faster than the
# square of that. So the rate in mean square lies between once and twice the bound. A single run is often a little
# faster: 2.0 to 2.4 times the bound on grasps, up to 3.9 times with six rows.
#
# A rate here is the decrease of ln ‖e‖, or of ln ‖Φ‖, per step: ln 10 / rate steps gain a digit.

_CORNER = 1.0 / np.sqrt(2.0) - 1.0


def generalized_jacobian(problem: Scaled, z: Array) -> Array:
    """(n, n) element of the generalized Jacobian (19) at z (n,): rows a e_i + b M_i as in the kernel `kaczmarz`."""
    w = problem.M @ z + problem.q
    rho = np.hypot(z, w)
    some = np.where(rho > 0.0, rho, 1.0)
    a = np.where(problem.free, 0.0, np.where(rho > 0.0, z / some - 1.0, _CORNER))
    b = np.where(problem.free, 1.0, np.where(rho > 0.0, w / some - 1.0, _CORNER))
    return np.asarray(np.diag(a) + b[:, None] * problem.M)


def greedy_bound(J: Array) -> float:
    """Least rate per step of greedy sampling, in mean square, on the rows of J (n, n)."""
    g2 = (J * J).sum(1)
    frobenius = float(g2.sum())
    others = frobenius - float(g2.min())
    share = _smallest(J) ** 2 / frobenius
    return _rate(share * 0.5 * (frobenius / others + 1.0) if others > 0.0 else 1.0)


def uniform_bound(J: Array) -> float:
    """Least rate per step of uniform sampling, in mean square, on the rows of J (n, n); the rate is at most double."""
    length = np.sqrt((J * J).sum(1))
    return _rate(_smallest(J / np.where(length > 0.0, length, 1.0)[:, None]) ** 2 / len(J))


def measured_rate(history: Array) -> float:
    """Rate per step: least squares on ln ‖Φ‖ over the second half of the steps.

    history : (k, 2) step and ‖Φ‖. NaN for fewer than three points there, or once ‖Φ‖ is zero. A run without
    progress has a rate of zero, or a little less.
    """
    steps, norms = history[history[:, 0] >= 0.5 * history[-1, 0]].T
    if len(steps) < 3 or not (norms > 0.0).all():
        return float("nan")
    x = steps - steps.mean()
    return float(-(x @ np.log(norms)) / (x @ x))


def _smallest(A: Array) -> float:
    """The smallest singular value above rounding."""
    s = np.linalg.svd(A, compute_uv=False)
    return float(s[s > len(s) * np.finfo(float).eps * s[0]][-1])


def _rate(gain: float) -> float:
    """The rate that follows from E‖e'‖² ≤ (1 - gain) ‖e‖²."""
    return float(-0.5 * np.log1p(-gain)) if gain < 1.0 else float("inf")


# ----------------------------------------------------------------
# One run of NSNGRK without its exact ending, observed along the way.

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
