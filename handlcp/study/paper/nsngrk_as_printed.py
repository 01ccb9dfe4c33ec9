"""The paper's algorithm as printed, seed by seed, beside the same algorithm in natural units.

As printed: metres and newtons taken as they are, stop at RES = ‖Φ(z)‖₂ < 1e-5 or after 20 000 steps, start at zero. The
complementarity problem mixes slips (1e-5 m) with forces (1 N), so the rule stops the run before compliance matters:
which of the many balanced sets of forces comes out depends on the seed. Nothing else is wrong with the algorithm: in
natural units it converges to the one answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp import GraspProblem
from handlcp.lcp import NSNGRK
from handlcp.lcp.compiler.when import at_once
from handlcp.study.nsngrk import RES, SEEDS, STEPS, UnitsOf, in_units
from handlcp.study.paper.examples import example

CASES = ((1, 8), (2, 4), (2, 16), (3, 8), (3, 16), (5, 6))  # example, faces (ignored by the planar Example 1)


@dataclass(frozen=True, slots=True)
class Run:
    """One seed: steps taken, ‖Φ‖₂ reached (in the units it ran in), normal forces (n,) N."""

    seed: int
    steps: int
    res: float
    normal: Array


@dataclass(frozen=True, slots=True)
class Case:
    """All seeds of one example, run as printed and in natural units.

    ours : (n,) N certified normal forces. steps : of our default solver.
    """

    example: int
    faces: int
    printed: tuple[Run, ...]
    natural: tuple[Run, ...]
    ours: Array
    steps: int

    @property
    def finger(self) -> int:
        """The contact (from 0) on which the printed runs disagree most, among those that carry a load."""
        return int(np.argmax(np.where(self.ours > 0.01 * self.ours.max(), self._spreads(self.printed), -1.0)))

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest normal force of that contact over the printed runs [N]."""
        found = [float(r.normal[self.finger]) for r in self.printed]
        return min(found), max(found)

    @property
    def spread(self) -> float:
        """How far printed runs with different seeds disagree on it, as a share of the answer."""
        return float(self._spreads(self.printed)[self.finger])

    @property
    def natural_spread(self) -> float:
        """The same for the runs in natural units, worst of all contacts."""
        return float(self._spreads(self.natural).max())

    @property
    def off(self) -> float:
        """Worst deviation of a printed run from the certified answer, as a share of the largest force."""
        return float(max(abs(r.normal - self.ours).max() for r in self.printed) / self.ours.max())

    def _spreads(self, runs: Sequence[Run]) -> Array:
        """(n,) largest minus smallest normal force over the seeds, as a share of the answer."""
        size = abs(self.ours)
        return np.asarray(np.ptp([r.normal for r in runs], axis=0) / np.maximum(size, 1e-3 * size.max()))


@at_once()
def run_case(number: int, faces: int, seeds: Sequence[int] = SEEDS) -> Case:
    """Run all seeds of Example `number`."""
    grasp = example(number).grasp
    problem, solution = grasp.problem(faces), grasp.solve(faces)
    printed = tuple(_run(problem, "given", seed, RES, STEPS) for seed in seeds)
    natural = tuple(_run(problem, "natural", seed, 1e-9, 500_000) for seed in seeds)
    return Case(number, faces, printed, natural, solution.normal_force, solution.iterations)


def _run(problem: GraspProblem, units: UnitsOf, seed: int, tol: float, most: int) -> Run:
    scaled, size = in_units(problem, units)
    proposal = NSNGRK(tol, most, seed, polish=False).propose(scaled)
    z = proposal.z
    w = scaled.M @ z + scaled.q
    res = float(np.linalg.norm(np.where(scaled.free, w, np.hypot(z, w) - z - w)))
    return Run(seed, proposal.iterations, res, problem.candidate(z / size).forces[:, 2])
