"""`Bench`: one setting of one method: timed, judged by the certifier, compared with the exact answer."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.contact.friction import as_section
from handlcp.grasp import Grasp, GraspSolution
from handlcp.grasp.assembly.problem import GraspContactProblem, SolverCandidate, solution_candidate
from handlcp.grasp.verify.certifier import certify_candidate
from handlcp.hand import HandGrasp
from handlcp.lcp import Auto, SemismoothNewton
from handlcp.studies.accuracy.as_printed import in_units
from handlcp.studies.accuracy.methods import Setting
from handlcp.studies.accuracy.result import CERTIFIED, FAILED, LOOSE, OTHER, SPENT, Row

_SHORT, _MANY = 1e-2, 50  # short runs are repeated for _SHORT seconds, at most _MANY times
_AMPLIFIED = 1e3  # a force error beyond so many times the residual suggests another equilibrium
_SAME = 1e-6  # relative difference of forces up to which two answers are the same equilibrium


class Bench:
    """Runs settings on one grasp, and compares answers with the reference."""

    def __init__(self, grasp: Grasp, reference: GraspSolution, repeats: int, seed: int) -> None:
        self.grasp, self.reference, self.repeats, self.seed = grasp, reference, repeats, seed
        self.torques = _torques(grasp, reference.forces)
        self._problems: dict[Any, Any] = {}

    def errors(self, forces: Array, slip: Array, grasp: Grasp | None = None) -> dict[str, float | None]:
        """How far forces and slip are from those of the reference: force_error, slip_error, torque_error.

        grasp : the one whose torques count; None: the reference's.
        """
        exact, torques = self.reference, _torques(grasp or self.grasp, forces)
        off = None if torques is None or self.torques is None else _share(torques - self.torques, self.torques)
        return {
            "force_error": _share(np.linalg.norm(forces - exact.forces, axis=1), np.linalg.norm(exact.forces, axis=1)),
            "slip_error": _share(np.linalg.norm(slip - exact.slip, axis=1), np.array([exact.residuals.motion_scale])),
            "torque_error": off,
        }

    def unknowns(self, s: Setting) -> int:
        """Number of unknowns of the problem that the method gets."""
        return int(self._problem(s).n)

    def run(self, s: Setting, seconds: float, most: int) -> Row:
        """The row of a setting: one run of at most `most` steps, then as many repeats as fit into `seconds`."""
        if s.method.form == "grasp":
            return self._whole(s, seconds)
        problem, solver = self._problem(s), s.method.configure(s.tolerance or 1.0, most, self.seed)
        if s.method.form == "cone":
            subject, units, run = problem, np.ones(1), solver.propose_contact
        else:
            subject, units = in_units(problem, "natural" if s.method.form == "LCP" else "given")
            run = solver.propose
        proposal, times = time_runs(lambda: subject, run, self.repeats, seconds)
        scene, candidate = self.grasp.scene, problem.candidate(proposal.z / units)
        section, outcome = as_section(s.faces_asked, scene.plane is not None), proposal.outcome
        verdict = certify_candidate(scene, problem.effects, section, candidate)
        worst, said = verdict.residuals.worst, CERTIFIED
        slip = np.where(scene.force_unknown_mask[:, None], verdict.motion.reshape(-1, 3)[:, :2], 0.0)
        if worst > 0 and not verdict.residuals.passes:  # the certifier refuses it: why, by the method's own words
            met = outcome.startswith(("converged", "complementary basis"))
            said = SPENT if "spent" in outcome else LOOSE if met else FAILED
        found = _times(times) | {"iterations": proposal.iterations, "outcome": outcome}
        return self._row(s, said, worst, candidate, slip, found)

    def _whole(self, s: Setting, seconds: float) -> Row:
        """The row of `grasp.solve`. Each run gets a new grasp, which keeps nothing from an earlier solve."""
        chain, again = Auto(seed=self.seed), partial(type(self.grasp), self.grasp.spec)
        solution, times = time_runs(again, lambda g: g.solve(s.faces_asked, chain, throw=False), self.repeats, seconds)
        assert solution.scene is not None
        candidate = solution_candidate(solution.scene, solution)
        said = CERTIFIED if solution.held else solution.status.name.lower().replace("_", " ")
        found = _times(times) | {"iterations": solution.iterations, "outcome": solution.trace[-1]}
        return self._row(s, said, solution.residuals.worst, candidate, solution.slip, found)

    def _row(
        self, s: Setting, said: str, worst: float, candidate: SolverCandidate, slip: Array, found: dict[str, Any]
    ) -> Row:
        """The row of one setting, with its errors.

        said : status, unless the candidate belongs to another equilibrium.
        found : further fields.
        """
        errors = self.errors(candidate.forces, slip)
        off = errors["force_error"]
        # Friction on a pyramid may point up to π/m away from the slip: forces may be off by about this share
        explained = (0.0 if s.faces is None else np.pi / s.faces) + _AMPLIFIED * worst + _SAME
        if off is not None and off > explained and self._leads_elsewhere(candidate):
            said = OTHER
        found |= errors | {"unknowns": self.unknowns(s), "residual": worst if np.isfinite(worst) else None}
        return Row(s.method.name, s.section, s.faces, s.tolerance, said, **found)

    def _leads_elsewhere(self, candidate: SolverCandidate) -> bool:
        """Whether Newton's method on the exact cone leads from here to another certified equilibrium."""
        scene, problem = self.grasp.scene, self.grasp.problem("cone")
        assert isinstance(problem, GraspContactProblem)  # soft fingers are refused where the study begins
        there = problem.candidate(SemismoothNewton().propose_contact(problem, problem.natural(candidate)).z)
        verdict = certify_candidate(scene, problem.effects, as_section("cone", scene.plane is not None), there)
        off = self.errors(there.forces, self.reference.slip)["force_error"]
        return verdict.residuals.passes and off is not None and off > _SAME

    def _problem(self, s: Setting) -> Any:
        """The assembled problem that a setting's method works on.

        "cone" and "grasp" work on friction as a set, the others on multipliers.
        """
        multipliers = s.method.form in ("LCP", "SI")
        key = (s.faces_asked, multipliers)
        if key not in self._problems:
            problem = self.grasp.problem(s.faces_asked)
            self._problems[key] = problem if multipliers else getattr(problem, "contact", problem)
        return self._problems[key]


def time_runs(
    prepare: Callable[[], Any], run: Callable[[Any], Any], repeats: int, seconds: float
) -> tuple[Any, list[float]]:
    """(result of the first run, times [s]) of `repeats` runs; `prepare` makes the argument of each, untimed.

    There are fewer runs where they do not fit into `seconds`, and more where they are short. The time of the first run,
    which fills the caches, counts only where there is no other. The garbage collector is off meanwhile.
    """

    def run_once() -> tuple[Any, float]:
        subject = prepare()
        start = time.perf_counter()
        result = run(subject)
        return result, time.perf_counter() - start

    begun, collects = time.perf_counter(), gc.isenabled()
    gc.disable()
    try:
        result, first = run_once()
        times: list[float] = []
        wanted = max(repeats, min(_MANY, int(_SHORT / max(first, 1e-9))))
        while len(times) < wanted and time.perf_counter() - begun + first < seconds:
            times.append(run_once()[1])
    finally:
        if collects:
            gc.enable()
    return result, times or [first]


def forces_determined(solution: GraspSolution) -> bool:
    """Whether the scene determines the forces, as far as is known."""
    return solution.uniqueness is None or solution.uniqueness.forces_determined


def _torques(grasp: Grasp, forces: Array) -> Array | None:
    """(nv,) Jᵀ f, with the fingers' own weight where it was asked for; None without a hand."""
    if not isinstance(grasp, HandGrasp):
        return None
    return np.asarray(forces.reshape(-1) @ grasp.jacobian + grasp.gravity_torque)


def _times(times: list[float]) -> dict[str, Any]:
    low, median, high = np.percentile(times, [25, 50, 75]).tolist()
    return {"seconds": median, "seconds_low": low, "seconds_high": high, "runs": len(times)}


def _share(difference: Array, size: Array) -> float | None:
    """Largest difference over the largest size; None where that is not a finite number."""
    largest = float(abs(size).max(initial=0.0))
    error = float(abs(difference).max(initial=0.0))
    return error / largest if largest > 0.0 and np.isfinite(error / largest) else None
