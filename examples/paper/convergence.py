"""How fast NSNGRK converges, beside the conditioning that predicts it: units, seeds, greedy and uniform sampling.

Near a solution the rows of Φ are linear, Φ(z) ≈ J (z - z*), and a step projects the error e on a row of J. With σ the
smallest singular value of J that is not zero (of J with rows of length one for uniform sampling), n rows g_i:

    greedy    E‖e'‖² ≤ (1 - ½ (‖J‖²_F / (‖J‖²_F - min_i |g_i|²) + 1) σ² / ‖J‖²_F) ‖e‖²
    uniform   E‖e'‖² ≤ (1 - σ² / n) ‖e‖²

The greedy bound is Z.-Z. Bai & W.-T. Wu's, SIAM J. Sci. Comput. 40 (2018), A592-A606. It holds from the second step on
and allows for the worst e: measured rates are 4 to 19 times as large. The uniform bound is nearly sharp: in mean square
the rate lies between once and twice the bound, as the mean error shrinks by 1 - σ² / n in its slowest part. A rate here
is the decrease of ln ‖Φ‖ per step: ln 10 / rate steps gain a digit.

Run it: `python examples/paper/convergence.py`, two minutes. It writes two pictures into examples/ and needs matplotlib:
`pip install '.[plot]'`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import handlcp as hl
from handlcp.studies import paper

FOLDER = Path(__file__).parents[1]
RES, STEPS = 1e-5, 20_000  # where the paper stops: ‖Φ‖₂ < RES, or after so many steps
TOL, MOST = 1e-9, 200_000  # of runs in natural units
KINDS = (("natural", "greedy"), ("natural", "uniform"), ("equilibrated", "greedy"), ("given", "greedy"))
LOOKS, HISTORY = 60, 400  # values that are recorded of a run, evenly over the logarithm of steps; points of ‖Φ‖
CORNER = 1.0 / np.sqrt(2.0) - 1.0  # of the subgradient where both of a pair vanish


# ---------------------------------------------------------------- Rates: bounds from conditioning, and measured ones.


def generalized_jacobian(problem: Any, z: np.ndarray) -> np.ndarray:
    """(n, n) an element of the generalized Jacobian of Φ at z (n,), equation (19): rows a e_i + b M_i."""
    w = problem.M @ z + problem.q
    rho = np.hypot(z, w)
    some = np.where(rho > 0.0, rho, 1.0)
    a = np.where(problem.free, 0.0, np.where(rho > 0.0, z / some - 1.0, CORNER))
    b = np.where(problem.free, 1.0, np.where(rho > 0.0, w / some - 1.0, CORNER))
    return np.diag(a) + b[:, None] * problem.M


def smallest(A: np.ndarray) -> float:
    """The smallest singular value above rounding."""
    s = np.linalg.svd(A, compute_uv=False)
    return float(s[s > len(s) * np.finfo(float).eps * s[0]][-1])


def greedy_bound(J: np.ndarray) -> float:
    """The least rate per step of greedy sampling, in mean square, on the rows of J (n, n)."""
    g2 = (J * J).sum(axis=1)
    others = g2.sum() - g2.min()
    gain = 0.5 * (g2.sum() / others + 1.0) * smallest(J) ** 2 / g2.sum()
    return float(-0.5 * np.log1p(-gain))


def uniform_bound(J: np.ndarray) -> float:
    """The least rate per step of uniform sampling, in mean square; the rate is at most double."""
    length = np.sqrt((J * J).sum(axis=1))
    return float(-0.5 * np.log1p(-(smallest(J / np.where(length > 0.0, length, 1.0)[:, None]) ** 2) / len(J)))


def measured_rate(history: np.ndarray) -> float:
    """Rate per step: least squares on ln ‖Φ‖ over the second half of the steps. history : (k, 2) step and ‖Φ‖."""
    steps, norms = history[history[:, 0] >= 0.5 * history[-1, 0]].T
    x = steps - steps.mean()
    return float(-(x @ np.log(norms)) / (x @ x))


# ---------------------------------------------------------------- Runs.


@dataclass(frozen=True)
class Run:
    """One seed in one set of units.

    history (k, 2) : step and ‖Φ‖₂ in those units. looks (m,), values (m, n) : steps, and the normal forces there [N].
    stop : the step in which ‖Φ‖ first meets the paper's rule; None: never. rate, bound : decrease of ln ‖Φ‖ per step,
    measured, and the least by conditioning at the run's end.
    """

    units: str
    sampling: str
    seed: int
    history: np.ndarray
    looks: np.ndarray
    values: np.ndarray
    stop: int | None
    converged: bool
    rate: float
    bound: float

    @property
    def stopped(self) -> np.ndarray:
        """(n,) N normal forces where the paper's rule ends the run, or at its own end."""
        return self.values[-1 if self.stop is None else int(np.searchsorted(self.looks, self.stop))]


@dataclass(frozen=True)
class Convergence:
    """All runs on one grasp, none of them ended by Newton's method. answer (n,) : the certified normal forces [N]."""

    names: tuple[str, ...]
    answer: np.ndarray
    runs: tuple[Run, ...]

    def select(self, units: str = "natural", sampling: str = "greedy") -> list[Run]:
        """The runs of one kind, seed by seed."""
        return [run for run in self.runs if (run.units, run.sampling) == (units, sampling)]

    def rate(self, sampling: str = "greedy") -> float:
        """The median rate in natural units."""
        return float(np.median([run.rate for run in self.select(sampling=sampling)]))

    @property
    def disputed(self) -> int:
        """The contact that seeds disagree on most where the paper's rule stops them, among those that bear a load."""
        values = np.array([run.stopped for run in self.select("given")])
        size = abs(self.answer)
        share = np.ptp(values, axis=0) / np.where(size > 0.01 * size.max(), size, np.inf)
        return int(np.argmax(share >= 0.999 * share.max()))

    def spread(self, units: str) -> float:
        """How far seeds disagree on it, as a share of the answer: at the stop rule in given units, else at the end."""
        i, runs = self.disputed, self.select(units)
        values = [run.stopped[i] if units == "given" else run.values[-1, i] for run in runs]
        return float(np.ptp(values) / abs(self.answer[i]))

    def error(self, run: Run) -> float:
        """The worst error at a run's end, as a share of the largest force."""
        return float(abs(run.values[-1] - self.answer).max() / abs(self.answer).max())


def greedy(problem: Any, seed: int, tol: float, steps: int, stride: int) -> tuple[np.ndarray, int, np.ndarray | None]:
    """(z, steps taken, history) of NSNGRK without its exact ending."""
    found = hl.NSNGRK(tol, steps, seed, polish=False, stride=stride).propose(problem)
    return found.z, found.iterations, found.history


def uniform(problem: Any, seed: int, tol: float, steps: int, stride: int) -> tuple[np.ndarray, int, np.ndarray | None]:
    """The same with rows that are all equally likely, among those with a residual."""
    M, q, free, rng = problem.M, problem.q, problem.free, np.random.default_rng(seed)
    z, out = np.zeros(len(q)), []
    w = q.copy()
    for taken in range(steps + 1):
        if taken % (4 * len(q)) == 0:  # it drifts by rounding
            w = M @ z + q
        rho = np.hypot(z, w)
        phi = np.where(free, w, rho - z - w)
        norm = float(np.sqrt(phi @ phi))
        if stride and taken % stride == 0:
            out.append((taken, norm))
        rows = np.flatnonzero(phi)
        if norm <= tol or taken == steps or not len(rows):
            break
        i = rows[int(rng.random() * len(rows))]
        a, b = (0.0, 1.0) if free[i] else (z[i] / rho[i] - 1.0, w[i] / rho[i] - 1.0) if rho[i] > 0 else (CORNER, CORNER)
        g = b * M[i]
        g[i] += a
        move = -phi[i] / (g @ g) * g
        z += move
        w += M @ move
    return z, taken, np.array(out) if stride else None


def in_units(problem: hl.LCP, units: str) -> Any:
    """The problem in its own natural units, in metres and newtons, or equilibrated from M and q alone (Ruiz)."""
    if units == "natural":
        return problem.scaled
    return problem.unscaled().scaled if units == "given" else hl.LCP(problem.M, problem.q, problem.free).scaled


def observe(problem: hl.GraspProblem, units: str, sampling: str, seed: int, most: int) -> Run:
    """One run, looked at along the way: it is taken again to each look, with the same seed."""
    scaled, take = in_units(problem, units), greedy if sampling == "greedy" else uniform
    end, steps, _ = take(scaled, seed, TOL, most, 0)
    _, _, history = take(scaled, seed, TOL, steps, max(1, steps // HISTORY))
    _, early, _ = take(scaled, seed, RES, steps, 0)
    stop = early if early < steps or history[-1, 1] <= RES else None
    many = LOOKS if sampling == "greedy" else 2  # a step in Python takes its time
    looks = np.unique([*np.geomspace(1, steps, many).astype(int), *([] if stop is None else [stop])])
    size = scaled.units.z / problem.scaled.units.z
    values = [problem.candidate(take(scaled, seed, TOL, int(k), 0)[0] * size).forces[:, 2] for k in looks]
    J = generalized_jacobian(scaled, end)
    w = scaled.M @ end + scaled.q
    left = np.linalg.norm(np.where(scaled.free, w, np.hypot(end, w) - end - w))
    bound = greedy_bound(J) if sampling == "greedy" else uniform_bound(J)
    rate = measured_rate(history)
    return Run(units, sampling, seed, history, looks, np.array(values), stop, bool(left <= TOL * 1.001), rate, bound)


def convergence(grasp: hl.Grasp, faces: int, seeds: Iterable[int] = range(6), most: int = MOST) -> Convergence:
    """All kinds of runs, seed by seed. most : steps in natural units; the others, without progress, get the paper's."""
    problem = grasp.problem(faces)
    runs = [
        observe(problem, units, sampling, seed, most if units == "natural" else min(most, STEPS))
        for units, sampling in KINDS
        for seed in seeds
    ]
    return Convergence(grasp.names, grasp.solve(faces).normal_force, tuple(runs))


# ---------------------------------------------------------------- The picture.

BLUE, ORANGE, RED = "#0072B2", "#B87800", "#D55E00"


def digit(rate: float) -> str:
    """Steps that gain a decimal digit, to two figures."""
    return f"{float(f'{np.log(10.0) / rate:.2g}'):,.0f}".replace(",", " ")


def draw(found: Convergence, path: Path, title: str, printed: tuple[str, float]) -> Path:
    """Left: ‖Φ‖ in natural units. Right: in metres and newtons, above ‖Φ‖, below the force that seeds disagree on.
    printed : a name and a force to mark.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.9), dpi=160, layout="constrained")
    left, right = figure.subfigures(1, 2)
    figure.suptitle(title, x=0.01, ha="left", weight="bold")
    rates, (above, below) = left.subplots(), right.subplots(2, 1, sharex=True)
    for sampling, colour in (("uniform", ORANGE), ("greedy", BLUE)):
        runs = found.select(sampling=sampling)
        bound = digit(float(np.median([run.bound for run in runs])))
        label = f"{sampling} rows: {digit(found.rate(sampling))} steps a digit, at most {bound} by conditioning"
        for k, run in enumerate(runs):
            rates.semilogy(*(run.history / (1e3, 1.0)).T, color=colour, lw=0.9, label=label if k == 0 else None)
    rates.set(title="Natural units", xlabel="steps, in thousands", ylabel="‖Φ‖")
    rates.legend(fontsize=8, loc="upper right")
    i, given = found.disputed, found.select("given")
    last = 3.0 * float(np.median([run.stop or run.looks[-1] for run in given]))
    for runs, colour, label in ((found.select(), BLUE, "natural units"), (given, RED, "metres and newtons")):
        for k, run in enumerate(runs):
            below.plot(run.looks, run.values[:, i], color=colour, lw=0.9, label=label if k == 0 else None)
    for run in given:
        above.semilogy(*run.history[run.history[:, 0] <= last].T, color=RED, lw=0.9)
        if run.stop is not None:
            below.plot(run.stop, run.stopped[i], "o", color=RED, ms=4.5, mec="white", zorder=6)
    below.plot(last, printed[1], "D", color="black", ms=5, clip_on=False, label=f"{printed[0]}: {printed[1]:.3g} N")
    above.axhline(RES, color="black", ls="--", lw=1, label="the paper's stop rule")
    above.set(title="In metres and newtons it stops …", ylabel="‖Φ‖", xlim=(0, last))
    ends = [*(run.stopped[i] for run in given), found.answer[i], printed[1]]
    room = 0.3 * (max(ends) - min(ends))
    below.set(title=f"… but where? {found.names[i]}", xlabel="steps", ylabel="normal force [N]")
    below.set_ylim(min(ends) - room, max(ends) + room)
    for ax in (above, below):
        ax.legend(fontsize=8)
    figure.savefig(path)
    return path


def main(folder: Path = FOLDER, seeds: Iterable[int] = range(6)) -> list[Path]:
    """Examples 3 and 5: in natural units each seed finds what the paper's exact method found, as printed none does."""
    seeds, paths = list(seeds), []
    for number, faces, printed, name in ((3, 8, 7, "convergence"), (5, 6, 10, "convergence_table_10")):
        found = convergence(paper.example(number).grasp, faces, seeds)
        assert all(run.converged and found.error(run) < 1e-6 for run in found.select())
        assert all(run.stop is not None for run in found.select("given"))
        assert max(found.error(run) for run in found.select("given")) > 0.005
        force = float(paper.table(printed).forces(len(found.names))[found.disputed, 2])
        title = f"How NSNGRK converges: Example {number}, {faces} faces"
        paths.append(draw(found, folder / f"{name}.png", title, (f"Table {printed}", force)))
        print(
            f"{title}: in metres and newtons seeds disagree about {found.names[found.disputed]} by "
            f"{found.spread('given'):.0%}, in natural units by {found.spread('natural'):.0e}; a greedy step gains as "
            f"much as {found.rate() / found.rate('uniform'):.1f} uniform ones. Written: {paths[-1]}"
        )
    return paths


if __name__ == "__main__":
    main()
