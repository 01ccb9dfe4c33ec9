"""NSNGRK as printed: the paper's Algorithm 2 with nothing improved, and why its seeds disagree.

The algorithm solves w = M z + q, 0 ≤ z ⟂ w ≥ 0 as Φ(z) = 0 with the Fischer-Burmeister function of each pair,

    φ_i(z) = √(z_i² + w_i²) - z_i - w_i

A step takes the whole subgradient matrix by forward differences, equation (19), J_ij = (φ_i(z + h e_j) - φ_i(z)) / h
with h = 1e-6. Of the rows of the greedy set (20), φ_i² ≥ ε ‖Φ‖² |J_i|², one is drawn with a chance in proportion to
φ_i² (21), and z is projected on it (22):

    ε = ½ (max_i φ_i² / |J_i|² / ‖Φ‖² + 1 / ‖J‖²_F),      z ← z - φ_i / |J_i|² J_i

It stops at ‖Φ‖ < 1e-5 or after 20 000 steps. In metres and newtons every displacement is about 1e-5 m. The rule thus
ends a run before compliance matters, and the seed decides which of the many balanced sets of forces comes out. In
natural units the same algorithm finds one answer.

Run it: `python examples/paper/nsngrk_as_printed.py`, a minute.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

import handlcp as hl
from handlcp.studies import paper

RES, STEPS = 1e-5, 20_000  # where the paper stops: ‖Φ‖₂ < RES, or after so many steps (section 5)
NATURAL_RES, NATURAL_STEPS = 1e-9, 500_000  # of runs in natural units
H = 1e-6  # of the forward differences: Algorithm 2, line 6
SEEDS = range(6)
CASES = ((1, 8), (2, 4), (2, 16), (3, 8), (3, 16), (5, 6))  # example, faces (the planar Example 1 ignores them)


def phi(z: np.ndarray, w: np.ndarray, free: np.ndarray) -> np.ndarray:
    """(n,) φ, in the order in which it is printed; w for a free row, which the paper has none of."""
    return np.where(free, w, np.sqrt(z * z + w * w) - z - w)


def subgradients(M: np.ndarray, z: np.ndarray, w: np.ndarray, free: np.ndarray) -> np.ndarray:
    """(n, n) the matrix (19), by forward differences: w_i(z + h e_j) = w_i + h M_ij."""
    before = phi(z, w, free)[:, None]
    moved = z[:, None] + H * np.eye(len(z))
    return (phi(moved, w[:, None] + H * M, free[:, None]) - before) / H


def greedy_rows(f: np.ndarray, J: np.ndarray) -> np.ndarray:
    """(n,) chances of the rows: those of the greedy set (20), each in proportion to φ² (21)."""
    g2 = (J * J).sum(axis=1)
    share = np.divide(f * f, g2, out=np.zeros_like(f), where=g2 > 0.0)
    epsilon = 0.5 * (share.max() / (f @ f) + 1.0 / g2.sum())
    chances = np.where(f * f >= epsilon * (f @ f) * g2, f * f, 0.0)
    return chances / chances.sum()


def step(problem: Any, z: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
    """The next iterate (n,), equation (22); None where no row moves."""
    w = problem.M @ z + problem.q
    f, J = phi(z, w, problem.free), subgradients(problem.M, z, w, problem.free)
    if not (f[(J * J).sum(axis=1) > 0.0]).any():
        return None
    i = rng.choice(len(f), p=greedy_rows(f, J))
    return z - f[i] / (J[i] @ J[i]) * J[i]


@dataclass(frozen=True)
class Run:
    """One seed: steps taken, ‖Φ‖₂ reached, and z (n,), all in the units that it ran in."""

    seed: int
    steps: int
    residual: float
    z: np.ndarray


def algorithm_2(problem: Any, seed: int, res: float = RES, steps: int = STEPS) -> Run:
    """All of it from zero. problem : with M (n, n), q (n,) and free (n,) in the units to run in."""
    z, rng = np.zeros(len(problem.q)), np.random.default_rng(seed)
    for taken in range(steps + 1):
        norm = float(np.linalg.norm(phi(z, problem.M @ z + problem.q, problem.free)))
        after = None if norm < res or taken == steps else step(problem, z, rng)
        if after is None:
            return Run(seed, taken, norm, z)
        z = after
    raise AssertionError("the last step returns")


# ---------------------------------------------------------------- Seed by seed, as printed and in natural units.


@dataclass(frozen=True)
class Case:
    """One example with so many faces. printed, natural : (seeds, n) normal forces [N], as printed in metres and
    newtons, and in natural units. steps, residuals : of the printed runs. ours (n,) : the certified answer [N].
    """

    example: int
    faces: int
    printed: np.ndarray
    natural: np.ndarray
    steps: tuple[int, ...]
    residuals: tuple[float, ...]
    ours: np.ndarray

    @property
    def finger(self) -> int:
        """The contact on which printed runs disagree most, among those that carry a load."""
        return int(np.argmax(np.where(self.ours > 0.01 * self.ours.max(), self._apart(self.printed), -1.0)))

    @property
    def spread(self) -> float:
        """How far printed runs disagree on it, as a share of the answer."""
        return float(self._apart(self.printed)[self.finger])

    @property
    def natural_spread(self) -> float:
        """How far runs in natural units disagree, the worst of all contacts."""
        return float(self._apart(self.natural).max())

    @property
    def off(self) -> float:
        """The worst deviation of a printed run from the answer, as a share of the largest force."""
        return float(abs(self.printed - self.ours).max() / self.ours.max())

    def _apart(self, forces: np.ndarray) -> np.ndarray:
        size = abs(self.ours)
        return np.ptp(forces, axis=0) / np.maximum(size, 1e-3 * size.max())


def run_case(number: int, faces: int, seeds: Iterable[int] = SEEDS) -> Case:
    """All seeds of an example: the algorithm as printed, and the same method in natural units."""
    grasp = paper.example(number).grasp
    problem = grasp.problem(faces)
    given, natural = problem.unscaled().scaled, problem.scaled

    def normal(z: np.ndarray, sizes: np.ndarray) -> np.ndarray:
        return problem.candidate(z * sizes / natural.units.z).forces[:, 2]

    printed = [algorithm_2(given, seed) for seed in seeds]
    alike = [hl.NSNGRK(NATURAL_RES, NATURAL_STEPS, seed, polish=False).propose(natural).z for seed in seeds]
    return Case(
        number, faces,
        np.array([normal(run.z, given.units.z) for run in printed]),
        np.array([normal(z, natural.units.z) for z in alike]),
        tuple([run.steps for run in printed]), tuple([run.residual for run in printed]),
        grasp.solve(faces).normal_force,
    )  # fmt: skip


def show(cases: Iterable[Case], out: Console) -> None:
    """A line for each example."""
    heads = "example, faces", "", "printed from [N]", "to [N]", "spread", "off by", "steps", "natural [N]", "spread"
    table = Table(*heads, box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for case in cases:
        i, wrong = case.finger, "red" if case.off > 1e-3 else "green"
        ends = case.printed[:, i].min(), case.printed[:, i].max()
        table.add_row(
            f"{case.example}, {'planar' if case.example == 1 else case.faces}", f"r_N{i + 1}",
            *[Text(f"{end:.5f}", wrong) for end in ends], f"{case.spread:.1%}", Text(f"{case.off:.1%}", wrong),
            str(max(case.steps)), f"{case.natural[0, i]:.5f}", f"{case.natural_spread:.0e}",
        )  # fmt: skip
    out.print("NSNGRK as printed, in metres and newtons, beside natural units", style="bold")
    out.print(table)
    out.print("spread: largest minus smallest over the seeds; off by: the worst force error over the largest force")


def main(out: Console | None = None) -> None:
    """All cases; each printed run met the paper's stop rule, and natural units give one answer."""
    cases = [run_case(number, faces) for number, faces in CASES]
    assert all(residual < RES for case in cases for residual in case.residuals)
    assert all(case.natural_spread < 1e-6 for case in cases)
    show(cases, out or Console(width=100))


if __name__ == "__main__":
    main()
