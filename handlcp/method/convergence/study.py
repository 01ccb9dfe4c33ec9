"""Runs of one problem: natural units against others, greedy against uniform sampling, seed beside seed; their rates."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from handlcp.check import Array, Ints, integer, number, read_only
from handlcp.errors import InputError
from handlcp.grasp import Grasp, GraspProblem, Pyramid
from handlcp.lcp import LCP, NSNGRK, Proposal, solve_lcp
from handlcp.lcp.compiler.when import at_once
from handlcp.lcp.problem import Scaled
from handlcp.method.nsngrk import RES, SEEDS, STEPS, UniformRows, UnitsOf, in_units
from handlcp.record import Record, columns_of, data_frame
from handlcp.words import distinct

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


# ----------------------------------------------------------------

_KINDS: tuple[tuple[UnitsOf, Sampling], ...] = (
    ("natural", "greedy"),
    ("natural", "uniform"),
    ("equilibrated", "greedy"),
    ("given", "greedy"),
)


@dataclass(frozen=True, slots=True)
class Convergence(Record):
    """NSNGRK's runs on one problem, none of them ended by Newton's method; `select` finds those of a kind.

    names : (p,) of the recorded values: fingers, or "z[0]", "z[1]", … quantity : "normal force [N]", or "z".
    answer : (p,) the certified values.
    stop : the stop rule on ‖Φ‖ that runs in given units are judged by, the paper's 1e-5.
    """

    names: tuple[str, ...]
    quantity: str
    answer: Array
    stop: float
    runs: tuple[Run, ...]

    def select(self, units: UnitsOf = "natural", sampling: Sampling = "greedy") -> tuple[Run, ...]:
        """The runs of one kind, seed by seed. Raises InputError for a kind that was not run."""
        found = tuple(r for r in self.runs if (r.units, r.sampling) == (units, sampling))
        if not found:
            kinds = " or ".join(sorted({f"{r.units}, {r.sampling}" for r in self.runs}))
            raise InputError("units, sampling", kinds, f"{units}, {sampling}")
        return found

    def rate(self, units: UnitsOf = "natural", sampling: Sampling = "greedy") -> float:
        """Median measured rate: the decrease of ln ‖Φ‖ per step."""
        return float(np.median([r.rate for r in self.select(units, sampling)]))

    def bound(self, units: UnitsOf = "natural", sampling: Sampling = "greedy") -> float:
        """Median of the rates that conditioning guarantees, per step; see `rates`."""
        return float(np.median([r.bound for r in self.select(units, sampling)]))

    @property
    def gain(self) -> float:
        """How many uniform steps a greedy one is worth, in natural units."""
        return self.rate() / self.rate(sampling="uniform")

    @property
    def disputed(self) -> int:
        """Index of the value that seeds disagree on most at the stop rule in given units, among those not almost zero.

        The first of those that differ by less than a thousandth, such as fingers that mirror each other.
        """
        values = np.array([r.stopped for r in self.select("given")])
        size = abs(self.answer)
        share = np.ptp(values, axis=0) / np.where(size > 0.01 * size.max(), size, np.inf)
        return int(np.argmax(share >= 0.999 * share.max()))

    def spread(self, units: UnitsOf) -> float:
        """How far seeds disagree on it, as a share of the answer: at the stop rule in given units, else at the end."""
        i = self.disputed
        values = [r.stopped[i] if units == "given" else r.values[-1, i] for r in self.select(units)]
        return float(np.ptp(values) / abs(self.answer[i]))

    def to_frame(self) -> Any:
        """A pandas table with a row for each look at each run: "units", "sampling", "seed", "step", and the recorded
        values by their names. Raises Unsupported without pandas.
        """
        looks = [r for r in self.runs for _ in r.looks]
        values = zip(distinct(self.names), np.concatenate([r.values for r in self.runs]).T, strict=True)
        steps = {"step": np.concatenate([r.looks for r in self.runs])} | dict(values)
        return data_frame(columns_of(looks, "units", "sampling", "seed") | steps)

    def error(self, run: Run) -> Array:
        """(m,) worst error at each of the run's looks, as a share of the largest value."""
        return np.asarray(abs(run.values - self.answer).max(1) / abs(self.answer).max())


@at_once()
def convergence(
    problem: Grasp | LCP,
    faces: int | Pyramid = 8,
    *,
    seeds: Iterable[int] = SEEDS,
    tol: float = 1e-9,
    max_iterations: int = 200_000,
    stop: float = RES,
) -> Convergence:
    """Run NSNGRK on a grasp, or on any LCP, in several units, with both samplings and with each of `seeds`.

    faces : of the friction pyramids, for a grasp. tol : of every run, ‖Φ‖₂ in its own units. max_iterations : of runs
        in natural units; the others, which mostly make no progress, get the paper's 20 000 at most.
    stop : a rule ‖Φ‖₂ ≤ stop, such as the paper's; what it does to runs in given units is recorded.

    Raises InputError for a problem that is neither, for no seeds and for settings that are not as described;
    NoSolutionFound when there is no certified answer to compare with.
    """
    if not isinstance(problem, (Grasp, LCP)):
        raise InputError("problem", "a Grasp, or an LCP", type(problem).__name__)
    lcp = problem.problem(faces) if isinstance(problem, Grasp) else problem
    if not isinstance(lcp, LCP):
        raise InputError("faces", "an integer ≥ 3, or a Pyramid: the cone makes no plain LCP", repr(faces))
    try:
        chosen = [integer("seeds", seed, 0) for seed in seeds]
    except TypeError:
        raise InputError("seeds", "integers ≥ 0", repr(seeds)) from None
    if not chosen:
        raise InputError("seeds", "at least one", "none")
    limit, most = number("tol", tol, above=0.0), integer("max_iterations", max_iterations, 1)
    rule = number("stop", stop, above=0.0)
    quantity, names, read = watch(problem, lcp)
    answer = read(solve_lcp(lcp).z / lcp.scaled.units.z)
    if not answer.any():
        raise InputError("problem", "one whose answer isn't zero, where every run starts", "one whose answer is zero")
    runs = tuple(
        follow(lcp, read, units, sampling, seed, limit, most if units == "natural" else min(most, STEPS), rule)
        for units, sampling in _KINDS
        for seed in chosen
    )
    return Convergence(names, quantity, answer, rule, runs)
