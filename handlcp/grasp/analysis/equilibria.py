"""`equilibria`: all the equilibria of a grasp, as far as they can be found: with Coulomb friction there may be several.

Without friction there are no others (`Uniqueness`). On a pyramid, and in a plane, every choice of contact modes, and of
limits that give way, is solved or proven to have no answer, where that is affordable. The exact cone has a continuum of
modes: there, and beyond what is affordable, Newton's method starts from all equilibria of coarser pyramids and from
other seeds, which proves nothing.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from handlcp import words
from handlcp.check import Array, check_method_calls
from handlcp.contact.friction import Pyramid, Section
from handlcp.grasp.assembly.problem import (
    GraspContactProblem,
    SolverCandidate,
    asked_effects_with_rows,
    solution_candidate,
)
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solution.solution import GraspSolution, contact_data
from handlcp.grasp.solution.verdict import solution_motions
from handlcp.grasp.solve.equilibrium_search import (
    WORK_PER_SECOND,
    ContactModeSearch,
    first_certified,
    has_only_limits,
    is_certified,
)
from handlcp.grasp.solve.solve_spec import CheckedCandidate, make_solution, solve_spec
from handlcp.grasp.verify.certifier import certify_candidate
from handlcp.grasp.verify.load_capacity import prove_overload
from handlcp.lcp import NSNGRK, Auto, Status, proposals
from handlcp.lcp.contact_problem import MultiplierLCP
from handlcp.lcp.lemke import eliminate_free, pivot_lemke
from handlcp.record import Record, make_data_frame
from handlcp.tolerances import ACTIVE_TOLERANCE, PIVOT_TOLERANCE
from handlcp.words import wrap_text

# ----------------------------------------------------------------
# Where a search for equilibria starts from: answers of coarser pyramids, other seeds, other methods.

_COARSE_FACES = (6, 8, 12, 5, 4, 3)  # faces of pyramids whose equilibria are good places to start from
OTHER_SEEDS = 8  # other seeds and starts

T = TypeVar("T")


def iterate_starts(problem: GraspContactProblem, end: float) -> Iterator[SolverCandidate]:
    """Answers of coarser pyramids, as many as the time allows, then of other seeds and starts."""
    several = has_only_limits(problem) and problem.faces != 2
    for k, faces in enumerate([m for m in _COARSE_FACES if m != problem.faces] if several else ()):
        left = end - time.monotonic()
        coarse = GraspContactProblem(problem.scene, Pyramid(faces), problem.requested_effects)
        seconds = 0.5 * (left if k else max(left, 1.0))  # the first whatever the time
        near = ContactModeSearch(coarse).each_choice(WORK_PER_SECOND * seconds)
        yield from take_until(end, near) if k else near
    yield from take_until(end, seeded_candidates(problem, OTHER_SEEDS))


def take_until(end: float, candidates: Iterator[T]) -> Iterator[T]:
    """The first ones, up to a time of `time.monotonic()`; one at least."""
    for candidate in candidates:
        yield candidate
        if time.monotonic() > end:
            return


def seeded_candidates(problem: GraspContactProblem, runs: int = 4, seed: int = 1) -> Iterator[SolverCandidate]:
    """Candidates of NSNGRK from other starts with other seeds, and of Lemke's method with other covering vectors (on
    the pyramid, or an 8-face one for the exact cone, from which Newton's method goes on).
    """
    rng, method = np.random.default_rng(seed), NSNGRK(max_iterations=16 * problem.n)
    lcp = MultiplierLCP(problem, problem.flat(8) if problem.flat and not problem.faces else None)
    r = eliminate_free(lcp.scaled)
    for k in range(runs):
        start = rng.exponential(size=problem.n) * rng.choice([-1.0, 0.0, 1.0], problem.n)
        start[problem.role == 1] = abs(start[problem.role == 1])
        yield problem.candidate(replace(method, seed=seed + k).propose_contact(problem, start).z)
        _, _, v = pivot_lemke(r.M, r.q, 10.0 ** rng.uniform(-1, 1, len(r.q)), 50 + 20 * len(r.q), PIVOT_TOLERANCE)
        yield problem.candidate(method.propose_contact(problem, lcp.back(r.restore(v))).z)


# ----------------------------------------------------------------

_COLUMNS = ("equilibrium", "contact", "state", "normal_N", "friction_N", "friction_used", "slip_m", "gap_m")
_EQUAL_FORCE_SHARE = 1e-6  # of the largest force, or of the scene's: forces that differ by less are the same


@check_method_calls
@dataclass(frozen=True, slots=True)
class Equilibria(Record):
    """The equilibria of a grasp, every one certified: `for solution in equilibria`, `len(equilibria)`.

    found : smallest forces first; their `uniqueness.others` says whether others exist. Members of one family of
        undetermined forces count as one, which gives its smallest.
    complete : whether it is proven that there are no others.
    why : what proves it, or why that is open.
    seconds : wall time.
    """

    entries = ("complete", "why", "seconds", "found")

    found: tuple[GraspSolution, ...]
    complete: bool
    why: str
    seconds: float

    def __len__(self) -> int:
        """How many were found."""
        return len(self.found)

    def __iter__(self) -> Iterator[GraspSolution]:
        """Run through the equilibria, that with the smallest forces first."""
        return iter(self.found)

    def to_frame(self) -> Any:
        """A pandas table with a row for each contact of each equilibrium: "equilibrium", from 1 on, "contact", "state",
        normal_N, friction_N, friction_used, slip_m, gap_m. Raises Unsupported without pandas.
        """
        each = [
            contact_data(s) | {"equilibrium": [k] * len(s.names), "contact": s.names}
            for k, s in enumerate(self.found, 1)
        ]
        return make_data_frame({name: [x for one in each for x in one[name]] for name in _COLUMNS})

    def __str__(self) -> str:
        k = len(self.found)
        if not k:
            return wrap_text(f"no equilibrium {'exists' if self.complete else 'was found'}: {self.why}", "  ")
        proof = f"{'proven' if self.complete else 'not proven'}: {self.why}"
        if k == 1:
            head = "one equilibrium and no other" if self.complete else "one equilibrium found; others may exist"
            return f"{wrap_text(f'{head} ({proof})', '  ')}\n{wrap_text(_line(self.found[0]), '    ', '  ')}"
        head = f"{k} equilibria{' and no more' if self.complete else ' found; more may exist'} ({proof})"
        lines = [
            wrap_text(head, "  "),
            *(wrap_text(_line(s), "     ", f"  {i}. ") for i, s in enumerate(self.found, 1)),
        ]
        return "\n".join([*lines, *(wrap_text(line, "    ", "  ") for line in self._which())])

    def _which(self) -> Iterator[str]:
        """Which of several are to be reckoned with."""
        within = [str(i) for i, s in enumerate(self.found, 1) if not solution_motions(s).too_large]
        if len(within) < len(self.found):
            which = "none of them" if not within else f"number {within[0]} alone"
            if len(within) > 1:
                which = f"numbers {words.list_names(within)}"
            yield f"the equations of small motions describe {which}"
        if len(within) > 1:
            yield "in which of them the hand ends up depends on how it gets there: friction remembers the way"


def _line(s: GraspSolution) -> str:
    noise = ACTIVE_TOLERANCE * s.residuals.force_scale  # below this a contact is said not to push
    values = [0.0 if abs(f) <= noise else f for f in s.normal_force.tolist()]
    forces = ", ".join(words.format_column(values) if any(values) else ["0"] * len(values))
    return f"normal forces ({forces}) N, {replace(s, uniqueness=None).diagnosis}"


def equilibria(spec: GraspSpec, section: Section, seconds: float) -> Equilibria:
    """All equilibria that `seconds` are enough for, certified, and whether it is proven that there are no more."""
    run = _EquilibriumListing(spec, section, time.monotonic())
    first = solve_spec(spec, section, Auto(search_seconds=0.0), scene=run.scene)
    if first.status is Status.NOT_HOLDABLE:
        return run.result(True, "no forces within friction balance the load")
    if first.held:
        run.found.append(first)
    elif prove_overload(run.scene, section, spec.effects) is not None:
        return run.result(True, "no forces within friction and limits balance the load")
    if run.scene.soft:
        for seed in range(1, OTHER_SEEDS + 1):
            if time.monotonic() > run.start + seconds:
                break
            ended = (run.problem.candidate(p.z) for _, p in proposals(run.problem, Auto(seed=seed)))
            run.add_new(c for c in ended if is_certified(run.problem, c))
        return run.result(False, "contact modes know no moments about normals")
    if first.held and not len(run.problem.blocks):
        return run.result(True, "without friction the laws are monotone")
    modes = ContactModeSearch(run.problem) if has_only_limits(run.problem) and run.problem.faces else None
    complete, end = False, run.start + seconds
    why = "the exact cone has a continuum of slip directions"
    if not has_only_limits(run.problem):
        why = "an effect moves the contacts, so their modes do not describe them"
    if modes is not None:
        candidates = list(modes.each_choice(WORK_PER_SECOND * seconds))
        end = time.monotonic() + seconds  # whatever was compiled before
        tried = [first_certified(run.problem, [c]) for c in take_until(end, iter(candidates))]
        late, known = time.monotonic() > end, [c for c in tried if c is not None]
        run.add_new(known)
        complete, why = run.assess_search(modes, known, len(tried), late)
    if not complete:
        run.add_new(
            c for start in iterate_starts(run.problem, end) if (c := first_certified(run.problem, [start])) is not None
        )
    return run.result(complete, why)


class _EquilibriumListing:
    """Equilibria of one grasp, as they are found."""

    def __init__(self, spec: GraspSpec, section: Section, start: float) -> None:
        self.spec, self.start, self.scene = spec, start, build_scene(spec)
        self.problem = GraspContactProblem(self.scene, section, asked_effects_with_rows(spec.effects))
        self.found: list[GraspSolution] = []
        self.noise = _EQUAL_FORCE_SHARE * self.scene.units.force_unit

    def assess_search(
        self, modes: ContactModeSearch, known: list[SolverCandidate], tried: int, late: bool
    ) -> tuple[bool, str]:
        """(complete, why) after a search over contact modes; known : what was certified of those tried."""
        if not modes.search.exhausted:
            return False, f"{modes.search.choice_count:.2g} choices of contact modes are too many for the time"
        if late:
            return False, "the time was too short"
        if not all(map(_has_determined_forces, self.found)):
            return False, "forces of rigid fingers are not determined where they stick"
        # The answer that was known before must be among them
        missed = [s for s in self.found[:1] if not any(self._close(self._forces(c), s.forces) for c in known)]
        if len(known) < tried or missed:
            return False, "some are degenerate"
        return True, f"all {modes.search.choice_count:,.0f} choices of contact modes were solved"

    def add_new(self, candidates: Iterable[SolverCandidate]) -> None:
        """Append what is no member of a family already found: its smallest member is that one's, or halfway to that one
        there is an equilibrium as well (what one choice of modes allows is convex).
        """
        scene, section, effects = self.scene, self.problem.section, self.problem.effects
        for c in candidates:
            if any(self._close(self._forces(c), s.forces) for s in self.found):
                continue
            checked = CheckedCandidate(c, certify_candidate(scene, effects, section, c), 0)
            made = make_solution(self.spec, scene, section, effects, checked, ("another equilibrium",))
            if not any(self._close(made.forces, s.forces) or self._one_family(made, s) for s in self.found):
                self.found.append(made)

    def result(self, complete: bool, why: str) -> Equilibria:
        """Smallest forces first, each told whether there are others."""
        others = len(self.found) > 1 or (False if complete else None)
        known = [replace(s, uniqueness=replace(s.uniqueness, others=others)) for s in self.found if s.uniqueness]
        known.sort(key=lambda s: float((s.forces**2).sum()))
        return Equilibria(tuple(known), complete, why, time.monotonic() - self.start)

    def _forces(self, c: SolverCandidate) -> Array:
        """The forces (n, 3) of a candidate in contact axes [N]."""
        return self.scene.forces_to_contact_axes(c.components)[: 3 * self.scene.n].reshape(-1, 3)

    def _close(self, a: Array, b: Array) -> bool:
        """Within the noise, too: where no force is needed, what rounding leaves of it differs by all of its size."""
        return float(abs(a - b).max()) <= max(
            _EQUAL_FORCE_SHARE * max(float(abs(a).max()), float(abs(b).max())), self.noise
        )

    def _one_family(self, a: GraspSolution, b: GraspSolution) -> bool:
        if _has_determined_forces(a) and _has_determined_forces(b):
            return False
        one, other = solution_candidate(self.scene, a), solution_candidate(self.scene, b)
        extra = {name: 0.5 * (a.extra[name] + b.extra[name]) for name in a.extra}
        middle = 0.5 * (one.components + other.components), 0.5 * (one.twist + other.twist)
        return is_certified(self.problem, SolverCandidate(*middle, extra, one.soft))


def _has_determined_forces(s: GraspSolution) -> bool:
    return s.uniqueness is None or s.uniqueness.forces_determined
