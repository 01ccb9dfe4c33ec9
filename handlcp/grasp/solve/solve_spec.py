"""`solve_spec`: the driver of every solve, from the compiled first stage to the certified solution in SI."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.assembly.problem import (
    AnyProblem,
    GraspContactProblem,
    SolverCandidate,
    asked_effects_with_rows,
    assemble,
)
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.effects import Effect
from handlcp.grasp.model.contact import MANY_CONTACTS, shift_twist
from handlcp.grasp.model.mechanism import hard_contact_torques
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.status import UNKNOWN, contact_words
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solution.uniqueness import Uniqueness, find_uniqueness, free_branches, minimum_norm_candidate
from handlcp.grasp.solve.compiled_answer import NO_START, CompiledAnswer, solve_scene, start_values
from handlcp.grasp.solve.equilibrium_search import EquilibriumSearch, EquilibriumSearchResult
from handlcp.grasp.verify.certifier import Certification, Residuals, certify_candidate, forces_in_world
from handlcp.grasp.verify.contact_state import classify_contacts
from handlcp.grasp.verify.load_capacity import build_capacity, escape_in_si, find_escape_twist
from handlcp.grasp.verify.static_load_bound import find_deepest_balance
from handlcp.lcp import (
    BRIEF_SEARCH_STAGE,
    FIRST_STAGE,
    LONG_SEARCH_STAGE,
    STAGES_BETWEEN_SEARCHES,
    STATIC_STAGE,
    Auto,
    Proposal,
    Status,
    as_chain,
    is_static,
    proposals,
    stage_line,
)
from handlcp.lcp.solve import AnySolver
from handlcp.tolerances import FIXED_POINT_TOLERANCE


class CheckedCandidate(NamedTuple):
    """A candidate, passed or failed, what the certifier says of it, and how many steps of the method it took."""

    candidate: SolverCandidate
    certification: Certification
    iterations: int


def make_solution(
    spec: GraspSpec,
    scene: Scene,
    section: Section,
    effects: tuple[Effect, ...],
    checked: CheckedCandidate,
    trace: tuple[str, ...],
    smallest: bool = True,
) -> GraspSolution:
    """The solution from a candidate that the certifier passes; effects : all that were stamped. smallest : where it
    leaves something free, the least forces and motion in place of the candidate's.
    """
    candidate, certified, arm = checked.candidate, checked.certification, spec.reference - scene.units.centre
    states = classify_contacts(scene, section, candidate, certified)
    if not all(e.only_limits for e in effects):
        return solution_from_candidate(spec, scene, section, checked, Status.SOLVED, states.kind, None, trace, arm)
    free, changes = free_branches(scene, effects, section, states, candidate), tuple[Array | None, ...]()
    if free and smallest:
        least, changes = minimum_norm_candidate(scene, effects, section, states, candidate, certified, free)
        if (again := certify_candidate(scene, effects, section, least)).residuals.passes:
            checked = CheckedCandidate(least, again, checked.iterations)
            states = classify_contacts(scene, section, least, again)

    def free_to() -> Uniqueness:
        return replace(find_uniqueness(scene, free, arm, changes), smallest=smallest)

    return solution_from_candidate(spec, scene, section, checked, Status.SOLVED, states.kind, free_to, trace, arm)


def solution_from_candidate(
    spec: GraspSpec,
    scene: Scene,
    section: Section,
    checked: CheckedCandidate,
    status: Status,
    states: Ints,
    uniqueness: Uniqueness | Callable[[], Uniqueness] | None,
    trace: tuple[str, ...],
    arm: Array,
) -> GraspSolution:
    """A solution with these numbers, and with what moves the fingers reads off it. arm (3,) [m] leads from the point
    that the candidate's twist refers to to the grasp's reference. states (n,) : of `ContactStatus`. uniqueness : it, or
    what finds it when it is first asked for.
    """
    candidate, n = checked.candidate, scene.n
    forces = scene.forces_to_contact_axes(candidate.components)
    motion = scene.motions_to_contact_axes(checked.certification.motion)
    points = motion[: 3 * n].reshape(-1, 3)
    if not all(scene.force_unknown):  # no law makes a finger under force control keep a gap or a slip
        points = np.where(scene.force_unknown_mask[:, None], points, 0.0)
    own = read_only(forces[: 3 * n].reshape(-1, 3))
    torsion, spin, read, solution_class = None, None, dict[str, Any](), GraspSolution
    if scene.soft:
        torsion, spin = scene.scatter_torsion(forces[3 * n :]), scene.scatter_torsion(motion[3 * n :])
    mechanism = spec.mechanism
    if mechanism is not None:
        solution_class = mechanism.solution_class
        read = mechanism.solution_fields(scene, spec.effects, own, torsion, candidate.extra)
    fields = dict[str, Any](
        status=status,
        names=spec.names,
        forces=own,
        forces_world=read_only(forces_in_world(scene.frames, candidate.components)),
        gap=read_only(points[:, 2]),
        slip=read_only(points[:, :2]),
        object_displacement=read_only(shift_twist(candidate.twist, arm)),
        contact_state=contact_words(states.tolist()),
        residuals=checked.certification.residuals,
        certificate=None,
        iterations=checked.iterations,
        trace=trace,
        extra=candidate.extra,
        yielding={},
        torsion=torsion,
        spin=spin,
        scene=scene,
        reference=spec.reference,
        spec=spec,
        section=section,
        **read,
    )
    if callable(uniqueness):
        return solution_class.with_deferred_fields(lambda _: {"uniqueness": uniqueness()}, **fields)
    return solution_class(uniqueness=uniqueness, **fields)


def as_not_holdable(made: GraspSolution, spec: GraspSpec, scene: Scene, twist: Array) -> GraspSolution:
    """The solution without numbers, with the proof that nothing holds: a motion (6,) about the contacts' centre."""
    return replace(made, status=Status.NOT_HOLDABLE, certificate=escape_certificate(spec, scene, twist))


def escape_certificate(spec: GraspSpec, scene: Scene, twist: Array) -> Array:
    """(6,) as a solution tells a motion about the contacts' centre: about the grasp's reference."""
    return read_only(shift_twist(twist, spec.reference - scene.units.centre))


def blank_solution(
    spec: GraspSpec, scene: Scene, section: Section, residuals: Residuals, iterations: int, trace: tuple[str, ...]
) -> GraspSolution:
    """UNDECIDED, without numbers that anybody could use."""
    nothing = np.full(scene.components, np.nan)
    checked = CheckedCandidate(
        SolverCandidate(nothing, np.full(6, np.nan), {}, len(scene.soft)), Certification(nothing, residuals), iterations
    )
    states = np.full(scene.n, UNKNOWN)
    return solution_from_candidate(spec, scene, section, checked, Status.UNDECIDED, states, None, trace, np.zeros(3))


# ----------------------------------------------------------------
# The solution that a row of numbers stands for, its fields made when they are asked for.


def lazy_solution(spec: GraspSpec, scene: Scene, section: Section, found: CompiledAnswer) -> GraspSolution:
    """SOLVED, from an answer that passes and leaves nothing free, of a scene without soft or anisotropic contacts."""
    solution_class: type[GraspSolution] = GraspSolution if spec.mechanism is None else spec.mechanism.solution_class
    return solution_class.with_deferred_fields(
        partial(_make_field, spec, scene, found),
        status=Status.SOLVED,
        certificate=None,
        extra={},
        yielding={},
        scene=scene,
        reference=spec.reference,
        spec=spec,
        section=section,
    )


def first_stage_trace(found: CompiledAnswer) -> tuple[str, ...]:
    """The one line of the one stage."""
    return (stage_line(FIRST_STAGE, found.outcome, found.iterations, found.residuals.worst),)


def _make_field(spec: GraspSpec, scene: Scene, found: CompiledAnswer, name: str) -> dict[str, Any]:
    """A field of the solution by name; what the mechanism adds comes all at once, but for torques, which are asked for
    most, and often alone.
    """
    if (make := _FIELD_MAKERS.get(name)) is not None:
        return {name: make(spec, scene, found)}
    forces, mechanism = found.components.reshape(-1, 3), spec.mechanism
    assert mechanism is not None  # only its solutions have more fields
    if name == "torques" and not spec.effects:
        return {name: hard_contact_torques(mechanism, scene, forces)}
    return mechanism.solution_fields(scene, spec.effects, forces, None, {})


def _arm(spec: GraspSpec, found: CompiledAnswer) -> Array:
    """(3,) from the point that the answer's twist refers to to the grasp's reference [m]."""
    return spec.reference - found.centre


_FIELD_MAKERS: dict[str, Callable[[GraspSpec, Scene, CompiledAnswer], Any]] = {
    "names": lambda spec, scene, found: spec.names,
    "forces": lambda spec, scene, found: found.components.reshape(-1, 3),
    "forces_world": lambda spec, scene, found: read_only(forces_in_world(scene.frames, found.components)),
    "gap": lambda spec, scene, found: found.motion[2::3],
    "slip": lambda spec, scene, found: found.motion.reshape(-1, 3)[:, :2],
    "object_displacement": lambda spec, scene, found: read_only(shift_twist(found.twist, _arm(spec, found))),
    "contact_state": lambda spec, scene, found: contact_words(found.states.tolist()),
    "residuals": lambda spec, scene, found: found.residuals,
    "uniqueness": lambda spec, scene, found: find_uniqueness(scene, (), _arm(spec, found)),
    "iterations": lambda spec, scene, found: found.iterations,
    "trace": lambda spec, scene, found: first_stage_trace(found),
}


# ----------------------------------------------------------------
# A grasp through the stages of its solver, until the certifier is content.

# Multiply-adds of the first search, milliseconds, and of the second one, hundredths of a second. What the first leaves
# open is more often an answer that Lemke's method finds at once than one that is not there
BRIEF_SEARCH_WORK, _LONG_SEARCH_WORK = 1e6, 2e7
_PROOF_WORDS, _NO_PROOF_WORDS = "nothing holds it", "no proof that nothing holds it"


def solve_in_stages(
    spec: GraspSpec,
    scene: Scene,
    section: Section,
    solver: AnySolver = None,
    start: Array = NO_START,
    proof: bool = True,
) -> GraspSolution:
    """Forces, slips and motion of `build_scene(spec)`; start : made by `start_values`, proof as in `Grasp.solve`.

    The first stage of a scene whose effects follow from its data is one compiled call, and for most scenes there is no
    other.
    """
    chain, asked = as_chain(solver), asked_effects_with_rows(spec.effects) if spec.effects else ()
    if chain is None or asked:
        return _run_all_stages(spec, scene, section, solver, start, None, proof)
    found = solve_scene(scene, section, chain.seed, start)
    if found.passes or found.escape is not None or not proof:
        return conclude_first_stage(spec, scene, section, found)
    return _run_all_stages(spec, scene, section, solver, start, found.proposal, proof)


def conclude_first_stage(spec: GraspSpec, scene: Scene, section: Section, found: CompiledAnswer) -> GraspSolution:
    """The solution that the first stage comes to by itself: what it found, or the proof that nothing holds."""
    if not found.passes:
        escape = found.escape
        trace = (*first_stage_trace(found), f"holdability: {_NO_PROOF_WORDS if escape is None else _PROOF_WORDS}")
        made = blank_solution(spec, scene, section, found.residuals, found.iterations, trace)
        return made if escape is None else as_not_holdable(made, spec, scene, escape_in_si(scene, escape))
    if found.is_unique and scene.scale is None and scene.prescribed is None and not scene.soft:
        return lazy_solution(spec, scene, section, found)
    checked = CheckedCandidate(found.candidate, Certification(found.motion, found.residuals), found.iterations)
    if not found.is_unique:
        return make_solution(spec, scene, section, found.kind.design.effects, checked, first_stage_trace(found))
    arm = _arm(spec, found)
    free_to = find_uniqueness(scene, (), arm)
    trace = first_stage_trace(found)
    return solution_from_candidate(spec, scene, section, checked, Status.SOLVED, found.states, free_to, trace, arm)


def _run_all_stages(
    spec: GraspSpec,
    scene: Scene,
    section: Section,
    solver: AnySolver,
    start: Array,
    first: Proposal | None,
    proof: bool,
) -> GraspSolution:
    """One stage after the other; `first` is the first one's proposal, where that is known."""
    chain = as_chain(solver)
    # The chain works on friction as a set, whatever the section: pyramids cost no more than the cone
    problem = (assemble if chain is None else GraspContactProblem)(
        scene, section, asked_effects_with_rows(spec.effects)
    )
    begin: Array | None = None
    if len(start):
        twist = shift_twist(start[-9:-3], scene.units.centre - start[-3:])
        begin = problem.natural(SolverCandidate(start[:-9], twist, {}, len(scene.soft)))
    run = _StagedSolve(spec, problem)
    stages = proposals(problem, solver, begin, first)
    if run.run_stages(itertools.islice(stages, 1)) or run.prove_escape() or chain is None or not proof:
        return run.solution()
    assert isinstance(problem, GraspContactProblem)  # chains work on friction as a set
    if is_static(problem) and run.run_balance():
        return run.solution()
    if not chain.searches:
        run.run_stages(stages)
        return run.solution()
    search = EquilibriumSearch(problem)
    # One fit of many contacts grows with their cube, and so does the work that a search may take
    most_work = chain.search_work * ((scene.n / MANY_CONTACTS) ** 3 if scene.kind.has_many_contacts else 1.0)
    # Each search goes on where the one before it stopped; then come so many of the stages that look for an answer
    for name, work, then in (
        (BRIEF_SEARCH_STAGE, BRIEF_SEARCH_WORK, STAGES_BETWEEN_SEARCHES),
        (LONG_SEARCH_STAGE, _LONG_SEARCH_WORK, None),
        (chain.search_stage, np.inf, 0),
    ):
        begun = search.is_brief or name == chain.search_stage
        if begun and run.run_search(search, chain, min(work, most_work), name):
            break
        if run.run_stages(itertools.islice(stages, then)):
            break
    return run.solution()


def certify_known_answer(
    spec: GraspSpec, scene: Scene, section: Section, candidate: SolverCandidate, name: str
) -> GraspSolution:
    """The solution that a known answer is, if the certifier agrees, with its own forces and motion where others satisfy
    the same conditions, too. name : of where it is from, for the trace.
    """
    problem = GraspContactProblem(scene, section, asked_effects_with_rows(spec.effects))
    run = _StagedSolve(spec, problem)
    run.run_stages([(name, Proposal(problem.natural(candidate), 0, "known"))])
    return run.solution(smallest=False)


class _StagedSolve:
    """The stages of one solve so far: what they found, what is proven, and a line of each."""

    def __init__(self, spec: GraspSpec, problem: AnyProblem) -> None:
        self.spec, self.problem, self.scene = spec, problem, problem.scene
        self.trace: list[str] = []
        self.best: CheckedCandidate | None = None
        self.escape: Array | None = None
        self.no_equilibrium: EquilibriumSearchResult | None = None

    def run_stages(self, stages: Iterable[tuple[str, Proposal]]) -> bool:
        """Whether one of these stages leads to an answer."""
        for name, proposal in stages:
            checked = self._certify(self.problem.candidate(proposal.z), proposal.iterations)
            worst = checked.certification.residuals.worst
            self.trace.append(stage_line(name, proposal.outcome, proposal.iterations, worst))
            if self.best is None or worst < self.best.certification.residuals.worst:
                self.best = checked
            if checked.certification.residuals.passes:
                return True
        return False

    def prove_escape(self) -> bool:
        """Whether it is proven that nothing holds the object."""
        self.escape = find_escape_twist(self.scene, self.problem.section)
        self.trace.append(f"holdability: {_NO_PROOF_WORDS if self.escape is None else _PROOF_WORDS}")
        return self.escape is not None

    def run_balance(self) -> bool:
        """Whether forces that balance the load are found, where any of them are an answer."""
        scene = self.scene
        capacity = build_capacity(scene, self.problem.section, self.problem.effects, torques=False)
        forces = scene.arrays.prescribed / scene.units.force_unit
        forces[scene.kind.index] = find_deepest_balance(capacity, scene.natural.w).forces
        candidate = SolverCandidate(forces * scene.units.force_unit, np.zeros(6), {}, len(scene.soft))
        proposal = Proposal(self.problem.natural(candidate), 0, "found" if np.isfinite(forces).all() else "none")
        return self.run_stages([(STATIC_STAGE, proposal)])

    def run_search(self, search: EquilibriumSearch, chain: Auto, work: float, name: str) -> bool:
        """Whether the search decides within its budget."""
        found = search.run(work, chain.search_end())
        self.trace.append(f"{name}: {found.words}")
        if found.candidate is not None:
            self.best = self._certify(found.candidate, 0 if self.best is None else self.best.iterations)
        elif found.bounds is not None:
            self.no_equilibrium = found
        return found.candidate is not None or found.bounds is not None

    def _certify(self, candidate: SolverCandidate, iterations: int) -> CheckedCandidate:
        certified = certify_candidate(self.scene, self.problem.effects, self.problem.section, candidate)
        return CheckedCandidate(candidate, certified, iterations)

    def solution(self, smallest: bool = True) -> GraspSolution:
        """What all this comes to. smallest : as in `make_solution`."""
        assert self.best is not None  # every solver proposes something
        spec, scene, trace, residuals = self.spec, self.scene, tuple(self.trace), self.best.certification.residuals
        if residuals.passes:
            return make_solution(spec, scene, self.problem.section, self.problem.effects, self.best, trace, smallest)
        made = blank_solution(spec, scene, self.problem.section, residuals, self.best.iterations, trace)
        if self.escape is not None:
            return as_not_holdable(made, spec, scene, self.escape)
        if (found := self.no_equilibrium) is None:
            return made
        certificate = None if found.escape is None else escape_certificate(spec, scene, scene.twist(found.escape))
        return replace(
            made,
            status=Status.NO_EQUILIBRIUM,
            bounds=found.bounds,
            cause=found.cause,
            certificate=certificate,
            yielding=found.yielding,
        )


# ----------------------------------------------------------------
# Grasps whose effects depend on the forces of the answer: solved again until the forces stay.
#
# f ← forces of the grasp with E(f) and d(f)
#
# Every solve is certified for its E, and the last one for the E of its own forces: that is what SOLVED means here.
# Where an effect has none under the forces (fingers buckle), where the forces keep changing, or where the changed grasp
# has no answer, nothing is claimed.

_MAX_SOLVES = 100  # solves


def is_force_dependent(spec: GraspSpec) -> bool:
    """Whether any effect depends on the forces of the answer."""
    return any(e.depends_on_forces for e in spec.effects)


def _force_dependent_titles(spec: GraspSpec) -> str:
    """What these effects are called."""
    return ", ".join([e.title for e in spec.effects if e.depends_on_forces])


def update_effects(spec: GraspSpec, forces: Array) -> GraspSpec | str:
    """The specification as it is under forces (n, 3) [N], contact axes; or, in words, why there is none."""
    effects = []
    for e in spec.effects:
        made = e.under(spec, forces, spec.effects) if e.depends_on_forces else e
        if isinstance(made, str):
            return made
        effects.append(made)
    return spec.replace(effects=tuple(effects), asked=spec.asked)


def solve_to_fixed_point(
    spec: GraspSpec,
    scene: Scene,
    section: Section,
    solver: AnySolver = None,
    start: Array = NO_START,
    proof: bool = True,
) -> GraspSolution:
    """Solve again and again, each time with what force-dependent effects add under the last forces, until these stay.

    scene : of the unloaded fingers; the other arguments as in `solve_in_stages`. The trace ends with how the iteration
    went. What is said of uniqueness holds for the last E.
    """
    forces, solution, where = np.zeros((scene.n, 3)), None, start
    if len(start):
        forces = scene.forces_to_contact_axes(start[:-9])[: 3 * scene.n].reshape(-1, 3)
    words = f"the forces still change after {_MAX_SOLVES} solves"
    for count in range(1, _MAX_SOLVES + 1):
        loaded = update_effects(spec, forces)
        if isinstance(loaded, str):
            words = loaded
            break
        now = build_scene(loaded)
        solution = solve_in_stages(loaded, now, section, solver, where, proof)
        if not solution.held:
            words = f"no answer with the flexibility under these forces, in solve {count}: {solution.status.name}"
            break
        change, forces = _relative_change(solution.forces - forces, solution.forces), solution.forces
        where = start_values(solution, now)
        if change <= FIXED_POINT_TOLERANCE or count == _MAX_SOLVES:
            made = _certify_again(spec, now, solution, f"{count} solves, forces change by {change:.1e}")
            if not isinstance(made, str):
                return made
            words = made if change <= FIXED_POINT_TOLERANCE else words
    if len(start) and (solution is None or (count == 1 and not solution.held)):  # the start led nowhere
        return solve_to_fixed_point(spec, scene, section, solver, proof=proof)
    assert solution is not None  # unloaded fingers always have an E
    trace = (*solution.trace, f"{_force_dependent_titles(spec)}: {words}")
    if solution.status is Status.NOT_HOLDABLE:  # whatever gives way, no force within friction balances the load
        return replace(solution, trace=trace)
    # What was proven of one E is not proven of all
    return blank_solution(spec, scene, section, solution.residuals, solution.iterations, trace)


def _certify_again(spec: GraspSpec, now: Scene, solution: GraspSolution, words: str) -> GraspSolution | str:
    """The solution with the effects' own law among its residuals, or why not."""
    miss = fixed_point_residual(spec, now, solution.forces, solution.residuals.motion_scale)
    if isinstance(miss, str):
        return miss
    residuals = replace(solution.residuals, effects=max(solution.residuals.effects, miss))
    words = f"{words}, E(f) by {miss:.1e}"
    if not residuals.passes:
        return words
    return replace(solution, residuals=residuals, trace=(*solution.trace, f"{_force_dependent_titles(spec)}: {words}"))


def fixed_point_residual(spec: GraspSpec, scene: Scene, forces: Array, motion_size: float) -> float | str:
    """How far E and the offsets of a scene are from those of the specification under these forces (n, 3) [N], relative;
    or, in words, why there are none. motion_size [m] : what offsets are measured by.
    """
    own = update_effects(spec, forces)
    if isinstance(own, str):
        return own
    there = build_scene(own)
    off = float(abs(there.offset - scene.offset).max(initial=0.0)) / motion_size
    return max(_relative_change(there.flexibility - scene.flexibility, scene.flexibility), off)


def _relative_change(difference: Array, of: Array) -> float:
    """The largest entry of a difference beside the largest of what differs."""
    size = float(abs(of).max(initial=0.0))
    return float(abs(difference).max(initial=0.0)) / size if size > 0.0 else 0.0


# ----------------------------------------------------------------
# From a specification to its solution.


def solve_spec(
    spec: GraspSpec,
    section: Section,
    solver: AnySolver = None,
    start: Array = NO_START,
    scene: Scene | None = None,
    proof: bool = True,
) -> GraspSolution:
    """The certified solution; its status says what it is worth, and nothing is raised for want of one.

    start : made by `start_values`. scene : `build_scene(spec)`, where that is known. proof : as in `Grasp.solve`.
    """
    run = solve_to_fixed_point if spec.effects and is_force_dependent(spec) else solve_in_stages
    return run(spec, build_scene(spec) if scene is None else scene, section, solver, start, proof)
