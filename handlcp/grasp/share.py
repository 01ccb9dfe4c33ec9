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

import copy
import gc
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import Array, nothing, read_only
from handlcp.grasp.certify import judge
from handlcp.grasp.changed import changed
from handlcp.grasp.effects import (
    AnisotropicFriction,
    CoulombCone,
    CoulombPlanar,
    CoulombPyramid,
    FingerFlexibility,
    SoftFingerCone,
    SoftFingerPyramid,
)
from handlcp.grasp.environment import ENVIRONMENT
from handlcp.grasp.explain import Explanation
from handlcp.grasp.first import find, start_at
from handlcp.grasp.friction import AnisotropicCoulomb, Coulomb
from handlcp.grasp.pyramid import Section
from handlcp.grasp.required import with_friction
from handlcp.grasp.scene import cross_rows
from handlcp.grasp.soft_form import chain_form
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.solving import natural_start
from handlcp.lcp import proposals

if TYPE_CHECKING:
    from handlcp.grasp.grasp import Grasp

__all__ = ["best_times", "measured", "without"]

_TURNS, _BURST, _MOST = 40, 3, 0.5  # turns of so many runs in a row, but no more [s] for all of them together


def without(grasp: Grasp) -> Iterator[tuple[str, Grasp]]:
    """(title, the grasp without that effect) for each that can be left out; balance and contact cannot."""
    if grasp.scene.rough:
        for friction in (CoulombPyramid, CoulombCone, CoulombPlanar):
            yield friction.title, with_friction(grasp, 0.0)
    contacts, soft = grasp.contacts, grasp.scene.soft
    if soft:
        hard = tuple([c.with_friction(Coulomb(c.mu)) if i in soft else c for i, c in enumerate(contacts)])
        for effect in (SoftFingerPyramid, SoftFingerCone):
            yield effect.title, changed(grasp, contacts=hard)
    if grasp.scene.anisotropic:
        alike = [isinstance(c.friction, AnisotropicCoulomb) for c in contacts]
        round_ = [c.with_friction(Coulomb(c.mu)) if a else c for c, a in zip(contacts, alike, strict=True)]
        yield AnisotropicFriction.title, changed(grasp, contacts=tuple(round_))
    if grasp.flexibility.any():
        rigid = changed(grasp, flexibility=read_only(np.zeros_like(grasp.flexibility)))
        yield FingerFlexibility.title, rigid
    if grasp.scene.environment and not grasp.effects:  # what is asked for by name may count the contacts
        yield ENVIRONMENT.title, grasp._fingers_alone()
    for e in grasp.effects:
        yield e.title, changed(grasp, effects=tuple(x for x in grasp.effects if x is not e))


def measured(
    grasp: Grasp,
    explanation: Explanation,
    section: Section,
    solution: GraspSolution,
    clock: Callable[[dict[int, Callable[[], bool]]], dict[int, float]] | None = None,
) -> Explanation:
    """The explanation with `seconds` and the shares of its effects; as it was where there is no answer to start at.

    solution : of the grasp. clock : times runs [s]; None: `best_times`. An effect has no share where the scene without
    it does not have the answer described above (a given force that friction would not bear).
    """
    if not solution.held:
        return explanation
    grasp = grasp._answering(solution)
    waiting = grasp._without()
    runs = {-1: _run(grasp, section, solution.forces, solution)}
    for k, line in enumerate(explanation.effects):
        at = next((i for i, (title, _) in enumerate(waiting) if line.on and title == line.title), None)
        if at is not None:
            run = _solved_by_the_same(grasp, waiting.pop(at)[1], section, solution)
            if run():
                runs[k] = run
    if not runs[-1]():
        return explanation
    times = (clock or best_times)(runs)
    whole = times.pop(-1)
    lines = tuple(
        replace(line, share=1.0 - times[k] / whole if k in times else None)
        for k, line in enumerate(explanation.effects)
    )
    return replace(explanation, effects=lines, seconds=whole)


def _solved_by_the_same(grasp: Grasp, less: Grasp, section: Section, solution: GraspSolution) -> Callable[[], bool]:
    """A run of `less` under the load w = -G r and with the offsets d = v - Gᵀu - E r of the solution's r, u and v,
    those of the contacts that it has: the first; where they are soft, with their moments and turning, too.
    """
    s = less.scene
    r = s.lawful(solution.forces[: s.n]).copy()
    r[s.governed_mask & (s.mu == 0.0), :2] = 0.0
    arms, turn = s.positions - grasp.reference, s.frames.transpose(0, 2, 1)
    world = np.einsum("nij,nj->ni", s.frames, r)
    u = solution.object_displacement
    moved = np.einsum("nij,nj->ni", turn, u[:3] + cross_rows(np.broadcast_to(u[3:], arms.shape), arms))
    # Motions scale as forces do, the other way round
    v = s.physical(np.column_stack([solution.slip, solution.gap])[: s.n])
    torsion, load = nothing(), -np.append(world.sum(axis=0), cross_rows(arms, world).sum(axis=0))
    if s.soft:
        assert solution.torsion is not None  # soft in `less`, soft in the grasp
        torsion = solution.torsion[list(s.soft)] / s.levers
        load[3:] -= s.spin_axes @ torsion
    retreat = s.flexibility @ np.append(r, torsion)
    d = s.lawful(v - moved - retreat[: 3 * s.n].reshape(-1, 3))
    if s.soft:
        assert solution.spin is not None
        less = copy.copy(less)
        less._spin = solution.spin[list(s.soft)] - (s.spin_axes.T @ u[3:] + retreat[3 * s.n :]) / s.levers
    made = changed(less, wrench=read_only(load), offset=read_only(d))
    return _run(made, section, s.physical(r), solution)


def _run(grasp: Grasp, section: Section, forces: Array, solution: GraspSolution) -> Callable[[], bool]:
    """The work that is timed; whether it ends in an answer."""
    assert solution.reference is not None
    start = start_at(forces, solution.object_displacement, solution.reference)

    def run() -> bool:
        made = grasp._placed()
        if not made.general:
            return find(made.scene, section, 0, start).passes
        problem = chain_form(made.scene, section, made.stamped)
        for _, proposal in proposals(problem, None, natural_start(problem, start)):
            if judge(made.scene, problem.effects, section, problem.candidate(proposal.z)).residuals.passes:
                return True
        return False

    return run


def best_times(runs: dict[int, Callable[[], bool]]) -> dict[int, float]:
    """Best time of each run [s], in turns, the collector off meanwhile."""
    best, clock, on = dict.fromkeys(runs, np.inf), time.perf_counter, gc.isenabled()
    end = clock() + _MOST
    gc.disable()
    try:
        for turn in range(_TURNS):
            for k, run in runs.items():
                for _ in range(_BURST):
                    start = clock()
                    run()
                    best[k] = min(best[k], clock() - start)
            if turn and clock() > end:
                break
    finally:
        if on:
            gc.enable()
    return best
