"""`Explanation`: which effects a grasp has, why, and what each costs in unknowns."""

from __future__ import annotations

import re
import time
import timeit
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from handlcp.check import read_only
from handlcp.contact.friction import Section
from handlcp.grasp.assembly.problem import (
    MULTIPLIER_NAMES,
    GraspContactProblem,
    GraspProblem,
    asked_effects_with_rows,
    assemble,
    effects_called_for,
    solution_candidate,
)
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.effects.contact_mechanics import FingerFlexibility
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.effect import FOLLOWED_LOADINGS, ONE_SOLVE
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.compiled_answer import solve_scene, start_values
from handlcp.grasp.solve.equilibrium_search import is_certified
from handlcp.grasp.solve.solve_spec import is_force_dependent, update_effects
from handlcp.lcp import proposals
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.record import Record
from handlcp.words import format_length, list_names, wrap_text


@dataclass(frozen=True, slots=True)
class EffectDescription:
    """An effect in words, or something else that a grasp can be made of; the page of effects is made of these.

    title, equation : as in `Effect`. when : who wants it, in one sentence. in_python : keyword arguments that ask for
    it, as Python; "": every grasp has it. in_file : the same as lines of a scene file (TOML); "": no scene file can.
    brings : its unknowns. source : where its law is from. module : dotted name of the module that holds it.
    """

    title: str
    equation: str
    when: str
    in_python: str
    in_file: str
    brings: str
    source: str
    module: str

    @property
    def in_short(self) -> str:
        """In Python, without what a mapping holds."""
        return re.sub(r"{.*}", "{…}", self.in_python)

    @property
    def file_keys(self) -> tuple[str, ...]:
        """What a scene file has for it: dotted keys, or a table with brackets about its name."""
        if self.in_file.startswith("["):
            return (self.in_file.partition("\n")[0],)
        return tuple(line.partition(" = ")[0] for line in self.in_file.splitlines())


def describe_effect(kind: type[Effect]) -> EffectDescription:
    """That of an effect, read off its class."""
    return EffectDescription(
        kind.title, kind.equation, kind.when, kind.in_python, kind.in_file, kind.brings, kind.source, kind.__module__
    )


ENVIRONMENT_DESCRIPTION = EffectDescription(
    title="environment contacts",
    equation="E = blkdiag(E_fingers, E_environment),  J_environment = 0",
    when="The object rests on a table, leans on a wall or sits in a fixture.",
    in_python="environment=Table((0, 0, 0.104), normal=(0, 0, -1))",
    in_file="environment = [{ point_m = [0, 0, 0.104], normal = [0, 0, -1] }]",
    brings="a contact's for each",
    source="contacts as any other: Ai & Li (2025), equations (3) and (4)",
    module="handlcp.grasp.model.request",
)


_ANSWERS_MEANT = {
    FOLLOWED_LOADINGS: "check, follow, load_limit, payload, required_grip, required_torque and what else follows the "
    'loading in steps; not solve, margins, sensitivity or reliability(by="solve"), which know no way',
    ONE_SOLVE: "solve, margins and sensitivity; what follows the loading has it in its geometry",
}


@dataclass(frozen=True, slots=True)
class EffectLine:
    """One effect of a grasp, whether it is on and why, and the unknowns that it brings: ((name, count, free), …).

    answers : which answers count it, "followed loadings alone" or "one solve alone"; "": every answer.
    share : of a solve's time, as measured (`measure_shares`); below 0 where it saves time. None: not measured, or
        nothing to measure: an effect that is off, or that no scene is without.
    """

    title: str
    equation: str
    on: bool
    why: str
    unknowns: tuple[tuple[str, int, bool], ...] = ()
    answers: str = ""
    share: float | None = None

    @property
    def cost(self) -> int:
        """The number of unknowns that the effect brings."""
        return sum(count for _, count, _ in self.unknowns)


@dataclass(frozen=True, slots=True)
class Explanation(Record):
    """All effects, on and off, and the size of the problem that comes of them.

    unknowns : of all effects together. eliminated : how many of them never reach the solver.
    rcond : reciprocal condition estimate of the free block, which decided about elimination; None for the exact cone,
        where nothing is eliminated.
    seconds : what a solve takes from its answer on [s], which the shares are of; None: not measured.
    """

    entries = ("effects", "unknowns", "eliminated", "rcond", "seconds", "size")

    effects: tuple[EffectLine, ...]
    unknowns: int
    eliminated: int
    rcond: float | None
    seconds: float | None = None

    @property
    def size(self) -> int:
        """Unknowns the solver sees."""
        return self.unknowns - self.eliminated

    def __str__(self) -> str:
        lines = []
        for e in self.effects:
            brings = ", ".join(f"{name}: {count}{' free' if free else ''}" for name, count, free in e.unknowns)
            takes = "" if e.share is None else f"; {round(100 * e.share)} % of the solve"
            counts = f"; in {e.answers}" if e.answers else ""
            cost = f" [{brings or 'no unknowns'}{takes}{counts}]" if e.on else ""
            lines.append(wrap_text(f"{e.title}: {e.why}{cost}", "     ", "on   " if e.on else "off  "))
        what = f"{self.eliminated} free unknowns eliminated" if self.eliminated else "none eliminated"
        if self.rcond is not None:
            what += f" (condition of their block {1.0 / self.rcond:.1e})" if self.rcond > 0.0 else " (singular block)"
        lines.append(wrap_text(f"{self.unknowns} unknowns, {what}: the solver sees {self.size}", "  "))
        if self.seconds is not None:
            took = f"{1e6 * self.seconds:.0f} µs from the numbers to a certified answer, started at the answer"
            lines.append(wrap_text(took, "  "))
        lines += [wrap_text(note, "  ") for note in self.notes]
        return "\n".join(lines)

    @property
    def notes(self) -> tuple[str, ...]:
        """Which answers are meant where not every one counts an effect; () where all count all of them."""
        some = {e.answers for e in self.effects if e.on}
        return tuple([f"{which}: {_ANSWERS_MEANT[which]}" for which in (FOLLOWED_LOADINGS, ONE_SOLVE) if which in some])


def explain_effects(spec: GraspSpec, scene: Scene, section: Section) -> Explanation:
    """What is on comes first; the sizes are those of the assembled problem."""
    on = (*effects_called_for(scene, section), *spec.effects)
    problem = assemble(scene, section, asked_effects_with_rows(spec.effects))
    counted = {g.name: g for g in problem.groups}
    lines, k = [], 3 * spec.of_hand
    own, m = spec.flexibility[:k, :k], spec.n - spec.of_hand
    for e in on:
        names = [name for u in e.unknowns(scene) for name in (u.name, MULTIPLIER_NAMES.get(u.name))]
        brought = tuple([(name, counted[name].count, counted[name].free) for name in names if name in counted])
        line = EffectLine(e.title, e.equation, True, e.why(scene), brought, e.answers)
        if e.title == FingerFlexibility.title:  # told apart from what compliances asked for add to E
            line = replace(line, why=f"E is not zero ({format_length(own.trace() / k)}/N in the mean)")
            if not own.any():
                line = replace(line, on=False, why="E of the fingers is zero: rigid fingers", unknowns=())
        lines.append(line)
    present = {type(e) for e in on}
    for kind in effect_kinds():
        if kind not in present and (why := kind.absent(scene, section)) is not None:
            lines.append(EffectLine(kind.title, kind.equation, False, why))
    why = "none given"
    if m:
        block = spec.flexibility[k:, k:]
        soft = f"{format_length(block.trace() / (3 * m))}/N in the mean" if block.any() else "rigid"
        why = f"{m} of the {spec.n} contacts: {list_names(spec.names[-m:])}; {soft}"
    # The unknowns of the environment are counted with contact and friction
    lines.append(EffectLine(ENVIRONMENT_DESCRIPTION.title, ENVIRONMENT_DESCRIPTION.equation, m > 0, why))
    for title, law, is_on, why, answers in () if spec.mechanism is None else spec.mechanism.report.explanation_lines():
        lines.append(EffectLine(title, law, is_on, why, answers=answers))
    total = sum(g.count for g in problem.groups)
    rcond = problem.rcond if isinstance(problem, GraspProblem) else None
    return Explanation(tuple(sorted(lines, key=lambda line: not line.on)), total, total - problem.n, rcond)


# ----------------------------------------------------------------
# What each effect of a grasp costs: its measured share of a solve.
#
#     share = 1 - T_without / T
#
# T is the time from the grasp's numbers to a certified answer: E put together, effects stamped, the solver started at
# the answer, the certifier. T_without is the same for the scene without the effect, under the load and with the offsets
# that make the old forces (without the friction, where that is left out) and the old motion its answer. Neither solver
# has anything left to find then, so that no share depends on how many steps a search happens to take. What a solution
# leaves free and its diagnosis are not counted. Times are the best of many, taken in turns.
#
# Shares don't add up to one: balance and contact have none, and effects that share a cost (all those that keep a scene
# off the compiled first stage) each show it only as far as leaving that one out would save it.


_MAX_TURNS, _RUNS_PER_TURN = 40, 3  # turns of so many runs in a row
_MAX_SECONDS = 0.5  # of all of them together

TimedRun = Callable[[], bool]
Clock = Callable[[dict[int, TimedRun]], dict[int, float]]


def specs_without(spec: GraspSpec, section: Section) -> Iterator[tuple[str, GraspSpec]]:
    """(title, the grasp without that effect) for each that can be left out; balance and contact cannot."""
    for e in (*effects_called_for(build_scene(spec), section), *spec.effects):
        if (changes := e.without(spec.contacts)) is not None:
            dropped = {"effects": tuple(x for x in spec.effects if x is not e)}
            yield e.title, spec.replace(**(changes or dropped))
    if spec.n > spec.of_hand and not any(e.by_name for e in spec.effects):  # those may count the contacts
        yield ENVIRONMENT_DESCRIPTION.title, spec.fingers_alone()


@compile_now()
def measure_shares(
    spec: GraspSpec, section: Section, explanation: Explanation, solution: GraspSolution, clock: Clock | None = None
) -> Explanation:
    """The explanation with `seconds` and the shares of its effects; as it was where there is no answer to start at.

    solution : of the grasp. clock : times runs [s]; None: `best_times`. An effect has no share where the scene without
    it does not have the answer described above (a given force that friction would not bear).
    """
    if not solution.held:
        return explanation
    if is_force_dependent(spec) and not isinstance(bent := update_effects(spec, solution.forces), str):
        spec = bent
    runs = {-1: _make_timed_run(spec, build_scene(spec), section, solution)}
    if not runs[-1]():
        return explanation
    lines, waiting = list(explanation.effects), list(specs_without(spec, section))
    for k, line in enumerate(lines):
        at = next((i for i, (title, _) in enumerate(waiting) if line.on and title == line.title), None)
        if at is not None:
            less = waiting.pop(at)[1]
            torsion = None if solution.torsion is None else solution.torsion[: less.n]
            own = replace(solution, forces=solution.forces[: less.n], torsion=torsion)  # its contacts are the first
            run = _make_timed_run(less, _scene_with_same_answer(less, own), section, own)
            if run():
                runs[k] = run
    times = (clock or best_times)(runs)
    whole = times.pop(-1)
    for k, seconds in times.items():
        lines[k] = replace(lines[k], share=1.0 - seconds / whole)
    return replace(explanation, effects=tuple(lines), seconds=whole)


def _scene_with_same_answer(less: GraspSpec, solution: GraspSolution) -> Scene:
    """The scene of `less` under the load w = -G r and with the offsets d = v - Gᵀu - E r of the solution's r, u, v."""
    scene = build_scene(less)
    answer = solution_candidate(scene, solution)
    r, u = answer.components.copy(), answer.twist
    for own, free, t in zip(scene.kind.contact_components, scene.force_unknown, scene.kind.tangent_count, strict=True):
        if free and t == 0:  # it bears no friction
            r[own[0] - 2 : own[0]] = 0.0
    v = np.column_stack([solution.slip, solution.gap])[: scene.n].reshape(-1)
    if scene.soft:
        assert solution.spin is not None  # soft in `less`, soft in the grasp
        v = np.append(v, solution.spin[list(scene.soft)])
    G = scene.geometry.grasp_matrix
    d = scene.motions_to_law_axes(v) - G.T @ u - scene.flexibility @ r
    load, centre = -G @ r, scene.units.centre
    moment = load[3:] + cross_rows(centre, load[:3])
    return replace(scene, force=read_only(load[:3]), moment=read_only(moment), offset=read_only(d))


def _make_timed_run(spec: GraspSpec, answered: Scene, section: Section, solution: GraspSolution) -> TimedRun:
    """The work that is timed, ending with the solve of `answered`; whether it ends in an answer."""
    asked, start = asked_effects_with_rows(spec.effects), start_values(solution, answered)

    def run() -> bool:
        build_scene(spec)
        scene = replace(answered)  # anew: nothing is kept from the run before
        if not asked:
            return bool(solve_scene(scene, section, 0, start).passes)
        problem = GraspContactProblem(scene, section, asked)
        begin = problem.natural(solution_candidate(scene, solution))
        return any(is_certified(problem, problem.candidate(p.z)) for _, p in proposals(problem, None, begin))

    return run


def best_times(runs: dict[int, TimedRun]) -> dict[int, float]:
    """Best time of each run [s], in turns, the collector off meanwhile."""
    best, clock = dict.fromkeys(runs, np.inf), time.perf_counter
    timers = {k: timeit.Timer(run, timer=clock) for k, run in runs.items()}  # they switch the collector off
    end = clock() + _MAX_SECONDS
    for turn in range(_MAX_TURNS):
        for k, timer in timers.items():
            best[k] = min(best[k], *timer.repeat(_RUNS_PER_TURN, number=1))
        if turn and clock() > end:
            break
    return best
