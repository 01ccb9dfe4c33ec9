"""The paper, reproduced: everything the command `handlcp paper` shows, as data."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp import GraspProblem, GraspSolution
from handlcp.lcp import NSNGRK
from handlcp.lcp.compiler.when import at_once
from handlcp.method.nsngrk import RES, SEEDS, STEPS, UnitsOf, in_units
from handlcp.method.paper.data import example, raw
from handlcp.method.paper.misses import FORCE_BOUND, MOTION_BOUND, Miss, NoEquilibrium, no_equilibrium
from handlcp.method.paper.tables import Comparison, Row, compare_all
from handlcp.record import Record, pick, plain

# ----------------------------------------------------------------
# The paper's algorithm as printed, seed by seed, beside the same algorithm in natural units.
#
# As printed: metres and newtons taken as they are, stop at RES = ‖Φ(z)‖₂ < 1e-5 or after 20 000 steps, start at zero.
# The complementarity problem mixes slips (1e-5 m) with forces (1 N), so the rule stops the run before compliance
# matters: which of the many balanced sets of forces comes out depends on the seed. Nothing else is wrong with the
# algorithm: in natural units it converges to the one answer.

CASES = ((1, 8), (2, 4), (2, 16), (3, 8), (3, 16), (5, 6))  # example, faces (ignored by the planar Example 1)


@dataclass(frozen=True, slots=True)
class Run(Record):
    """One seed: steps taken, ‖Φ‖₂ reached (in the units it ran in), normal forces (n,) N."""

    entries = ("seed", "steps", "res", "normal_force (n,) = normal")

    seed: int
    steps: int
    res: float
    normal: Array


@dataclass(frozen=True, slots=True)
class Case(Record):
    """All seeds of one example, run as printed and in natural units.

    ours : (n,) N certified normal forces. steps : of our default solver.
    """

    entries = (
        "example", "faces", "ours (n,)", "ours_steps = steps", "spread_as_printed = spread",
        "spread_natural_units = natural_spread", "res", "max_steps", "as_printed = printed", "natural_units = natural",
        "finger = number",
    )  # fmt: skip
    res, max_steps = RES, STEPS  # where printed runs stop

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
    def number(self) -> int:
        """The same from 1 on."""
        return self.finger + 1

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


# ----------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PaperReport(Record):
    """Ours beside Tables 1 to 10, Example 4 without an equilibrium, NSNGRK as printed; computed in so many seconds."""

    tables: tuple[Comparison, ...]
    example_4: NoEquilibrium
    nsngrk: tuple[Case, ...]
    seconds: float

    @property
    def ok(self) -> bool:
        """Whether every golden number is reproduced: Tables 1 and 2, the forces of Tables 3, 6 and 8."""
        return all(c.ok for c in self.tables)

    def to_dict(self) -> dict[str, Any]:
        """Everything, SI units, printed numbers as text; None for what is not a number."""
        tables = {c.table.number: _table(c) for c in self.tables}
        found = {"source": raw()["source"], **pick(self, "ok", "seconds"), "tables": tables}
        found |= {"example_4": _example_4(self.example_4), "nsngrk_as_printed": self.nsngrk}
        return dict(plain(found))


@at_once()
def run() -> PaperReport:
    """Compute the whole report; takes a few seconds."""
    start = time.perf_counter()
    tables = compare_all()
    cases = tuple(run_case(number, faces) for number, faces in CASES)
    return PaperReport(tables, no_equilibrium(), cases, time.perf_counter() - start)


def _table(c: Comparison) -> dict[str, Any]:
    misses = () if c.evidence is None else c.evidence.misses
    return pick(c, "golden", "ok", "level", "verdict", "remarks", "title = table.title") | {
        "ours": _solution(c.solution) | {"what": c.ours},
        "rows": [_row(r) for r in c.rows],
        "printed_forces_signed": None if c.evidence is None else c.evidence.signed.forces,
        "misses": [_miss(m) for m in misses],
    }


def _row(r: Row) -> dict[str, Any]:
    found = pick(r, "column", "place", "ours", "difference", "relative", "printed = printed.text")
    return found | {"mark": r.mark.name.lower()}


def _miss(m: Miss) -> dict[str, Any]:
    found = pick(m, "equation", "amount", "holds", "comment", "share_of_largest_elastic_displacement = share")
    unit, numbers = "N" if m.elastic is None else "m", "forces" if m.forces else "displacements"
    return found | {"unit": unit, "decided_by": numbers}


def _solution(s: GraspSolution) -> dict[str, Any]:
    return pick(
        s, "forces", "slip", "gap", "object_displacement", "states = contact_state", "status",
        "worst_residual = residuals.worst", "loose_motions = uniqueness.loose_motions",
    )  # fmt: skip


def _example_4(e: NoEquilibrium) -> dict[str, Any]:
    return {
        "without_preload": e.unloaded.status.name,
        "proved": e.proved,
        "force_bound": FORCE_BOUND,
        "motion_bound": MOTION_BOUND,
        "with_preload": _solution(e.preloaded),
        "control_normal_force": e.control_normal,
        "searches": [{"faces": f, "E_T": E} | pick(r, "pairs", "none_exists") for f, E, r in e.searches],
    }
