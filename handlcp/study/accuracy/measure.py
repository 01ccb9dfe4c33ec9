"""One setting of one method: timed, judged by the certifier, compared with the exact answer."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp import Grasp, GraspSolution, Pyramid
from handlcp.grasp.assemble import GraspContact
from handlcp.grasp.candidate import Candidate, of_solution
from handlcp.grasp.certify import judge
from handlcp.grasp.changed import changed
from handlcp.grasp.pyramid import as_section
from handlcp.hand import HandGrasp
from handlcp.lcp import Auto, SemismoothNewton
from handlcp.study.accuracy.methods import Method
from handlcp.study.accuracy.result import CERTIFIED, FAILED, LOOSE, OTHER, SPENT, Row

__all__ = ["Bench", "Errors", "Setting", "timed"]

_SHORT, _MANY = 1e-2, 50  # runs that are over at once are repeated for so long [s], but no more often
_AMPLIFIED = 1e3  # forces may be off by so many times a residual before another equilibrium is suspected
_SAME = 1e-6  # two equilibria whose forces differ by no more, relative, are one


@dataclass(frozen=True, slots=True)
class Setting:
    """A cell of the study. faces, inscribed : None where friction is exact. tolerance : None: the method has none."""

    method: Method
    faces: int | None
    inscribed: bool | None
    tolerance: float | None

    @property
    def section(self) -> str:
        """In rows."""
        return "exact" if self.inscribed is None else "inscribed" if self.inscribed else "circumscribed"

    @property
    def asked(self) -> int | str | Pyramid:
        """What the grasp is assembled or solved with, as `faces`. A plain LCP of an exact scene ignores its number."""
        if self.faces is not None:
            return Pyramid(self.faces, inscribed=bool(self.inscribed))
        return 8 if self.method.form in ("LCP", "SI") else "cone"

    def row(self, status: str, **found: Any) -> Row:
        """Its row."""
        return Row(self.method.name, self.section, self.faces, self.tolerance, status, **found)


class Errors:
    """How far forces, slips and torques are from those of the reference."""

    def __init__(self, grasp: Grasp, reference: GraspSolution) -> None:
        self.grasp, self.forces, self.slip = grasp, reference.forces, reference.slip
        self.torques = self.torques_of(grasp, reference.forces)
        self.motion_scale = reference.residuals.motion_scale

    def __call__(self, forces: Array, slip: Array, grasp: Grasp | None = None) -> dict[str, float | None]:
        """force_error, slip_error, torque_error. grasp : whose torques; None: the reference's."""
        torques = self.torques_of(grasp or self.grasp, forces)
        off = None if torques is None or self.torques is None else _share(torques - self.torques, self.torques)
        return {
            "force_error": _share(np.linalg.norm(forces - self.forces, axis=1), np.linalg.norm(self.forces, axis=1)),
            "slip_error": _share(np.linalg.norm(slip - self.slip, axis=1), np.array([self.motion_scale])),
            "torque_error": off,
        }

    @staticmethod
    def torques_of(grasp: Grasp, forces: Array) -> Array | None:
        """(nv,) Jᵀ f, and the fingers' own weight where it was asked for; None without a hand."""
        if not isinstance(grasp, HandGrasp):
            return None
        return np.asarray(forces.reshape(-1) @ grasp.jacobian + grasp.gravity_torque)


class Bench:
    """Runs settings on one grasp."""

    def __init__(self, grasp: Grasp, reference: GraspSolution, repeats: int, seed: int) -> None:
        self.grasp, self.errors, self.repeats, self.seed = grasp, Errors(grasp, reference), repeats, seed
        self._problems: dict[Any, Any] = {}

    def unknowns(self, s: Setting) -> int:
        """What the method sees."""
        return int(self._problem(s).n)

    def run(self, s: Setting, seconds: float, most: int) -> Row:
        """Its row: one run of at most `most` steps, and then as many of the repeats as fit into `seconds`."""
        if s.method.form == "grasp":
            return self._whole(s, seconds)
        problem, section = self._problem(s), as_section(s.asked, self.grasp.scene.plane is not None)
        solver = s.method.make(s.tolerance or 1.0, most, self.seed)
        if s.method.form == "cone":
            proposal, times = timed(lambda: lambda: solver.propose_contact(problem), self.repeats, seconds)
            z = proposal.z
        else:
            natural = s.method.form == "LCP"
            scaled = problem.scaled if natural else problem.unscaled().scaled
            proposal, times = timed(lambda: lambda: solver.propose(scaled), self.repeats, seconds)
            z = proposal.z if natural else proposal.z / problem.scaled.units.z
        candidate = problem.candidate(z)
        verdict = judge(self.grasp.scene, problem.effects, section, candidate)
        found = _times(times) | {"unknowns": problem.n, "iterations": proposal.iterations, "outcome": proposal.outcome}
        worst = verdict.residuals.worst
        slip = np.where(self.grasp.scene.governed_mask[:, None], verdict.motion[:, :2], 0.0)
        said = _said(proposal.outcome) if worst > 0 and not verdict.residuals.passes else CERTIFIED
        return self._judged(s, said, worst, candidate, slip, found)

    def _whole(self, s: Setting, seconds: float) -> Row:
        chain = Auto(seed=self.seed)

        def task() -> Callable[[], GraspSolution]:
            # Nothing of an earlier solve is left in a new grasp
            grasp = changed(self.grasp)
            return lambda: grasp.solve(s.asked, chain, throw=False)

        solution, times = timed(task, self.repeats, seconds)
        found = _times(times) | {"iterations": solution.iterations, "outcome": solution.trace[-1]}
        found["unknowns"] = self.unknowns(s)
        said = CERTIFIED if solution.held else solution.status.name.lower().replace("_", " ")
        return self._judged(s, said, solution.residuals.worst, _candidate(solution), solution.slip, found)

    def _judged(
        self, s: Setting, said: str, worst: float, candidate: Candidate, slip: Array, found: dict[str, Any]
    ) -> Row:
        errors = self.errors(candidate.forces, slip)
        found["residual"] = worst if np.isfinite(worst) else None
        off = errors["force_error"]
        # A face lets friction point up to π/m away from the slip: forces may be off by about this share
        explained = (0.0 if s.faces is None else np.pi / s.faces) + _AMPLIFIED * worst + _SAME
        if off is not None and off > explained and self._leads_elsewhere(candidate):
            said = OTHER
        return s.row(said, **found, **errors)

    def _leads_elsewhere(self, candidate: Candidate) -> bool:
        """Whether Newton's method on the exact cone leads from here to a certified equilibrium that is another one."""
        scene, problem = self.grasp.scene, self.grasp.problem("cone")
        assert isinstance(problem, GraspContact)  # soft fingers are refused where the study begins
        there = problem.candidate(SemismoothNewton().propose_contact(problem, problem.natural(candidate)).z)
        verdict = judge(scene, problem.effects, as_section("cone", scene.plane is not None), there)
        off = self.errors(there.forces, self.errors.slip)["force_error"]
        return verdict.residuals.passes and off is not None and off > _SAME

    def _problem(self, s: Setting) -> Any:
        """The assembled problem; friction as a set is what the whole of `solve` works on."""
        multipliers = s.method.form in ("LCP", "SI")
        key = (s.asked, multipliers)
        if key not in self._problems:
            problem = self.grasp.problem(s.asked)
            self._problems[key] = problem if multipliers else getattr(problem, "contact", problem)
        return self._problems[key]


def timed(task: Callable[[], Callable[[], Any]], repeats: int, seconds: float) -> tuple[Any, list[float]]:
    """(what a run returned, times [s]) of `repeats` runs, or as many as fit into `seconds`, and of more short ones.

    task : makes one run ready, untimed. The first run warms the caches; only where there is no time for another does
    its own count. The garbage collector is off meanwhile.
    """
    clock, begun = time.perf_counter, time.perf_counter()
    on = gc.isenabled()
    gc.disable()
    try:
        run = task()
        start = clock()
        result = run()
        first = clock() - start
        times: list[float] = []
        wanted = max(repeats, min(_MANY, int(_SHORT / max(first, 1e-9))))
        while len(times) < wanted and clock() - begun + first < seconds:
            run = task()
            start = clock()
            run()
            times.append(clock() - start)
    finally:
        if on:
            gc.enable()
    return result, times or [first]


def _candidate(solution: GraspSolution) -> Candidate:
    """Forces and motion of a solution, as a solver would propose them."""
    assert solution.scene is not None
    return of_solution(solution.scene, solution)


def _times(times: list[float]) -> dict[str, Any]:
    low, median, high = np.percentile(times, [25, 50, 75]).tolist()
    return {"seconds": median, "seconds_low": low, "seconds_high": high, "runs": len(times)}


def _said(outcome: str) -> str:
    """What an answer that the certifier refuses is, by the method's own words."""
    if "spent" in outcome:
        return SPENT
    return LOOSE if outcome.startswith(("converged", "complementary basis")) else FAILED


def _share(difference: Array, size: Array) -> float | None:
    """Largest of one over the largest of the other; None where that is no number."""
    largest = float(abs(size).max(initial=0.0))
    error = float(abs(difference).max(initial=0.0))
    return error / largest if largest > 0.0 and np.isfinite(error / largest) else None
