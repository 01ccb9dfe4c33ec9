"""What each effect of a grasp costs: its measured share of a solve.

    share = 1 - T_without / T

T is the time from the grasp's numbers to a certified answer: E put together, effects stamped, the solver started at
the answer, the certifier. T_without is the same for the scene without the effect, under the load and with the offsets
that make the old forces (without the friction, where that is left out) and the old motion its answer. Neither solver
has anything left to find then, so that no share depends on how many steps a search happens to take. What a solution
leaves free and its diagnosis are not counted. Times are the best of many, taken in turns.

Shares don't add up to one: balance and contact have none, and effects that share a cost (all those that keep a scene
off the compiled first stage) each show it only as far as leaving that one out would save it.
"""

from __future__ import annotations

import time
import timeit
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from handlcp.check import read_only
from handlcp.grasp.analysis.explanation import ENVIRONMENT, Explanation, effects_on
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.build import build
from handlcp.grasp.assembly.candidate import candidate_of
from handlcp.grasp.assembly.contact_form import GraspContactProblem, stamped
from handlcp.grasp.friction import Section
from handlcp.grasp.model.kind import cross_rows
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.search.over_modes import passes
from handlcp.grasp.solve.compiled_answer import solve_scene, start_from
from handlcp.grasp.solve.solve_spec import force_dependent, under_forces
from handlcp.lcp import proposals
from handlcp.lcp.compiler.when import at_once

_TURNS, _BURST, _MOST = 40, 3, 0.5  # turns of so many runs in a row, but no more [s] for all of them together

Run = Callable[[], bool]
Clock = Callable[[dict[int, Run]], dict[int, float]]


def without(spec: GraspSpec, section: Section) -> Iterator[tuple[str, GraspSpec]]:
    """(title, the grasp without that effect) for each that can be left out; balance and contact cannot."""
    for e in effects_on(spec, build(spec), section):
        if (changes := e.without(spec.contacts)) is not None:
            dropped = {"effects": tuple(x for x in spec.effects if x is not e)}
            yield e.title, spec.replace(**(changes or dropped))
    if spec.n > spec.of_hand and not any(e.by_name for e in spec.effects):  # those may count the contacts
        yield ENVIRONMENT.title, spec.fingers_alone()


@at_once()
def measured(
    spec: GraspSpec, section: Section, explanation: Explanation, solution: GraspSolution, clock: Clock | None = None
) -> Explanation:
    """The explanation with `seconds` and the shares of its effects; as it was where there is no answer to start at.

    solution : of the grasp. clock : times runs [s]; None: `best_times`. An effect has no share where the scene without
    it does not have the answer described above (a given force that friction would not bear).
    """
    if not solution.held:
        return explanation
    if force_dependent(spec) and not isinstance(bent := under_forces(spec, solution.forces), str):
        spec = bent
    runs = {-1: _run(spec, build(spec), section, solution)}
    if not runs[-1]():
        return explanation
    lines, waiting = list(explanation.effects), list(without(spec, section))
    for k, line in enumerate(lines):
        at = next((i for i, (title, _) in enumerate(waiting) if line.on and title == line.title), None)
        if at is not None:
            less = waiting.pop(at)[1]
            torsion = None if solution.torsion is None else solution.torsion[: less.n]
            own = replace(solution, forces=solution.forces[: less.n], torsion=torsion)  # its contacts are the first
            run = _run(less, _with_the_same_answer(less, own), section, own)
            if run():
                runs[k] = run
    times = (clock or best_times)(runs)
    whole = times.pop(-1)
    for k, seconds in times.items():
        lines[k] = replace(lines[k], share=1.0 - seconds / whole)
    return replace(explanation, effects=tuple(lines), seconds=whole)


def _with_the_same_answer(less: GraspSpec, solution: GraspSolution) -> Scene:
    """The scene of `less` under the load w = -G r and with the offsets d = v - Gᵀu - E r of the solution's r, u, v."""
    scene = build(less)
    answer = candidate_of(scene, solution)
    r, u = answer.components.copy(), answer.twist
    for own, free, t in zip(scene.kind.contact_components, scene.governed, scene.kind.tangents, strict=True):
        if free and t == 0:  # it bears no friction
            r[own[0] - 2 : own[0]] = 0.0
    v = np.column_stack([solution.slip, solution.gap])[: scene.n].reshape(-1)
    if scene.soft:
        assert solution.spin is not None  # soft in `less`, soft in the grasp
        v = np.append(v, solution.spin[list(scene.soft)])
    G = scene.geometry.grasp_matrix
    d = scene.physical(v) - G.T @ u - scene.flexibility @ r  # motions scale as forces do, the other way round
    load, centre = -G @ r, scene.units.centre
    moment = load[3:] + cross_rows(centre, load[:3])
    return replace(scene, force=read_only(load[:3]), moment=read_only(moment), offset=read_only(d))


def _run(spec: GraspSpec, answered: Scene, section: Section, solution: GraspSolution) -> Run:
    """The work that is timed, ending with the solve of `answered`; whether it ends in an answer."""
    asked, start = stamped(spec.effects), start_from(solution, answered)

    def run() -> bool:
        build(spec)
        scene = replace(answered)  # anew: nothing is kept from the run before
        if not asked:
            return solve_scene(scene, section, 0, start).passes
        problem = GraspContactProblem(scene, section, asked)
        begin = problem.natural(candidate_of(scene, solution))
        return any(passes(problem, problem.candidate(p.z)) for _, p in proposals(problem, None, begin))

    return run


def best_times(runs: dict[int, Run]) -> dict[int, float]:
    """Best time of each run [s], in turns, the collector off meanwhile."""
    best, clock = dict.fromkeys(runs, np.inf), time.perf_counter
    timers = {k: timeit.Timer(run, timer=clock) for k, run in runs.items()}  # they switch the collector off
    end = clock() + _MOST
    for turn in range(_TURNS):
        for k, timer in timers.items():
            best[k] = min(best[k], *timer.repeat(_BURST, number=1))
        if turn and clock() > end:
            break
    return best
