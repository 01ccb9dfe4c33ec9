"""The paper's algorithm as printed, seed by seed, beside the same algorithm in natural units.

As printed: metres and newtons taken as they are, stop at RES = ‖Φ(z)‖₂ < 1e-5 or after 20 000 steps, start at zero. The
complementarity problem mixes slips (1e-5 m) with forces (1 N), so the rule stops before it can see any compliance:
which of the many balanced force sets comes out depends on the seed. Nothing else is wrong with the algorithm: in
natural units it converges to the one answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from handlcp.check import Array
from handlcp.grasp import GraspProblem
from handlcp.lcp import NSNGRK
from handlcp.study.paper.examples import example

__all__ = ["CASES", "RES", "SEEDS", "STEPS", "Case", "Run", "run_case"]

RES, STEPS = 1e-5, 20_000  # the paper, section 5
SEEDS = tuple(range(6))
CASES = ((1, 8), (2, 4), (2, 16), (3, 8), (3, 16), (5, 6))  # example, faces (ignored by the planar Example 1)
_NATURAL_RES, _NATURAL_STEPS = 1e-9, 500_000


@dataclass(frozen=True, slots=True)
class Run:
    """One seed: steps taken, ‖Φ‖₂ reached (in the units it ran in), normal forces (n,) N."""

    seed: int
    steps: int
    res: float
    normal: Array


@dataclass(frozen=True, slots=True)
class Case:
    """All seeds of one example.

    printed : runs as printed. natural : runs in natural units. ours : (n,) N certified normal forces. steps : of our
        default solver.
    """

    example: int
    faces: int
    printed: tuple[Run, ...]
    natural: tuple[Run, ...]
    ours: Array
    steps: int

    @property
    def finger(self) -> int:
        """The contact (from 0) on which the printed runs disagree most, among those that carry something."""
        carrying = np.flatnonzero(self.ours > 0.01 * self.ours.max())
        return int(carrying[np.argmax([_spread(self.printed, self.ours, i) for i in carrying.tolist()])])

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest normal force of that contact over the printed runs [N]."""
        column = _forces(self.printed)[:, self.finger]
        return float(column.min()), float(column.max())

    @property
    def spread(self) -> float:
        """How far printed runs with different seeds disagree, as a share of the answer."""
        return _spread(self.printed, self.ours, self.finger)

    @property
    def natural_spread(self) -> float:
        """The same for the runs in natural units, worst of all contacts."""
        return max(_spread(self.natural, self.ours, i) for i in range(len(self.ours)))

    @property
    def off(self) -> float:
        """Worst deviation of a printed run from the certified answer, as a share of the largest force."""
        return float(abs(_forces(self.printed) - self.ours).max() / self.ours.max())

    @property
    def natural_off(self) -> float:
        """The same for the runs in natural units."""
        return float(abs(_forces(self.natural) - self.ours).max() / self.ours.max())


def run_case(number: int, faces: int, seeds: Sequence[int] = SEEDS) -> Case:
    """Run all seeds of Example `number`."""
    grasp = example(number).grasp
    problem = grasp.problem(faces)
    solution = grasp.solve(faces)
    return Case(
        number,
        faces,
        tuple(_run(problem, seed, False) for seed in seeds),
        tuple(_run(problem, seed, True) for seed in seeds),
        solution.normal_force,
        solution.iterations,
    )


def _run(problem: GraspProblem, seed: int, natural: bool) -> Run:
    scaled = problem.scaled if natural else problem.unscaled().scaled
    solver = NSNGRK(
        tol=_NATURAL_RES if natural else RES,
        max_iterations=_NATURAL_STEPS if natural else STEPS,
        seed=seed,
        polish=False,
    )
    proposal = solver.propose(scaled)
    z = proposal.z if natural else proposal.z / problem.scaled.units.z
    return Run(
        seed, proposal.iterations, _norm(scaled.M, scaled.q, scaled.free, proposal.z), problem.candidate(z).forces[:, 2]
    )


def _norm(M: Array, q: Array, free: npt.NDArray[np.bool_], z: Array) -> float:
    w = M @ z + q
    return float(np.linalg.norm(np.where(free, w, np.hypot(z, w) - z - w)))


def _forces(runs: tuple[Run, ...]) -> Array:
    return np.array([r.normal for r in runs])


def _spread(runs: tuple[Run, ...], ours: Array, contact: int) -> float:
    column = _forces(runs)[:, contact]
    return float((column.max() - column.min()) / max(abs(ours[contact]), 1e-3 * abs(ours).max()))
