"""Many grasps at once, over all cores: for sweeps over loads, postures and designs."""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, overload

import numpy as np

from handlcp.check import Bools, integer, read_only
from handlcp.errors import InputError
from handlcp.grasp.analysis.advice import solve_with_advice
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.friction import Pyramid, Section, as_section
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.solve.compiled_answer import NOWHERE, CompiledAnswer, CompiledKind, compiled_kind, pack
from handlcp.grasp.solve.compiled_solve import solve_scenes
from handlcp.grasp.solve.stages import answered
from handlcp.lcp import Auto, ContactSolver, Solver, Status, as_chain
from handlcp.lcp.kernels.compile import at_once
from handlcp.lcp.solve import AnySolver

__all__ = ["Solutions", "solve_many"]

_CHUNK = 256  # grasps that a thread takes at a time: long beside the handing over, short beside the whole
_ALONE = 2.0  # seconds of later stages that are done here, before other processes are worth waking [s]
_BATCH = 4  # grasps that travel together: they share the hand that they are of


class Solutions(Sequence[GraspSolution]):
    """The solutions of `solve_many`, in the order of its grasps; most are made when they are first looked at.

    held : (m,) bool, whether each is SOLVED.
    """

    def __init__(
        self, grasps: tuple[Grasp, ...], sections: Sequence[Section], found: list[CompiledAnswer | GraspSolution]
    ) -> None:
        self._grasps, self._sections, self._found = grasps, sections, found
        self.held: Bools = np.array([isinstance(a, CompiledAnswer) or a.held for a in found], dtype=bool)

    @property
    def statuses(self) -> tuple[Status, ...]:
        """The status of each."""
        return tuple(Status.SOLVED if isinstance(a, CompiledAnswer) else a.status for a in self._found)

    def __len__(self) -> int:
        return len(self._grasps)

    @overload
    def __getitem__(self, at: int) -> GraspSolution: ...
    @overload
    def __getitem__(self, at: slice) -> list[GraspSolution]: ...
    def __getitem__(self, at: int | slice) -> GraspSolution | list[GraspSolution]:
        if isinstance(at, slice):
            return [self[k] for k in range(len(self))[at]]
        answer, grasp = self._found[at], self._grasps[at]
        if isinstance(answer, CompiledAnswer):
            answer = self._found[at] = answered(grasp.spec, grasp.scene, self._sections[at], answer)
        return answer

    def __repr__(self) -> str:
        return f"Solutions({len(self)} grasps, {int(self.held.sum())} held)"


def solve_many(
    grasps: Iterable[Grasp], faces: int | str | Pyramid = 8, solver: Solver | ContactSolver | Auto | None = None, *,
    workers: int | None = None, progress: Callable[[int, int], None] | None = None,
) -> Solutions:  # fmt: skip
    """The solution of each grasp, as its own `solve(faces, solver, throw=False)` gives it, whatever the workers.

    workers : how many at a time; None: one a core. progress : called with (grasps done, all grasps) from time to time.

    The solver's first stage takes grasps of one kind as the rows of a matrix, in threads, a few ten microseconds each.
    What it leaves goes through the later stages one by one, and, where that takes seconds, in processes. Most of the
    time then goes into searches for a proof that nothing holds: `Auto(search_seconds=0)` does without them.
    Raises InputError for anything but grasps.
    """
    if isinstance(grasps, Grasp) or not isinstance(grasps, Iterable):
        raise InputError("grasps", "several Grasps, such as a list", repr(grasps)[:80])
    every = tuple(grasps)
    for k, g in enumerate(every):
        if not isinstance(g, Grasp):
            raise InputError(f"grasps[{k}]", "a Grasp", repr(g)[:80])
    if progress is not None and not callable(progress):
        raise InputError("progress", "a function of (done, total), or None", repr(progress)[:80])
    count = (os.cpu_count() or 1) if workers is None else integer("workers", workers, 1)
    either = {planar: as_section(faces, planar=planar) for planar in (False, True)}
    sections = [either[g.scene.kind.planar] for g in every]
    found: list[Any] = [None] * len(every)
    done = 0

    def say(more: int) -> None:
        nonlocal done
        done += more
        if progress is not None and (more or not every):
            progress(done, len(every))

    if (chain := as_chain(solver)) is not None:
        parts = [range(at, min(at + _CHUNK, len(every))) for at in range(0, len(every), _CHUNK)]
        with at_once(len(every)), ThreadPoolExecutor(count) as pool:  # starts no thread before the first is asked for
            spread = map if count == 1 or len(parts) == 1 else pool.map
            for solved in spread(lambda part: _first_stage(every, sections, chain, part, found), parts):
                say(solved)
    left = [k for k, answer in enumerate(found) if answer is None]
    rest = _one_by_one([every[k] for k in left], [sections[k] for k in left], solver, count)
    with at_once(len(left)):
        for k, solution in zip(left, rest, strict=True):
            found[k] = solution
            say(1)
    return Solutions(every, sections, found)


def _first_stage(
    grasps: Sequence[Grasp], sections: Sequence[Section], chain: Auto, part: range, found: list[Any]
) -> int:
    """Put what the first stage answers in its places; returns how many those are."""
    kinds: dict[CompiledKind, list[int]] = {}
    for k in part:
        if not any(e.stamps or e.depends_on_forces for e in grasps[k].spec.effects):
            kinds.setdefault(compiled_kind(grasps[k].scene, sections[k]), []).append(k)
    for kind, members in kinds.items():
        scenes = np.empty((len(members), kind.scene_width))
        for row, k in zip(scenes, members, strict=True):
            pack(grasps[k].scene, sections[k], row)
        rows = np.empty((len(members), kind.answer_width))
        solve_scenes(read_only(scenes), kind.pattern, NOWHERE, chain.seed, rows)
        for row, k in zip(read_only(rows), members, strict=True):
            if (answer := CompiledAnswer(kind, row)).passes:
                found[k] = answer
    return sum(found[k] is not None for k in part)


def _one_by_one(
    grasps: Sequence[Grasp], sections: Sequence[Section], solver: AnySolver, workers: int
) -> Iterator[GraspSolution]:
    """The solution of each, in order, through all stages of the solver; `workers` processes for long lists: most of
    that work is Python's.
    """
    begun, k = time.perf_counter(), 0
    while k < len(grasps) and (workers == 1 or time.perf_counter() - begun < _ALONE):
        yield solve_with_advice(grasps[k].spec, sections[k], solver, scene=grasps[k].scene)
        k += 1
    if k == len(grasps):
        return
    from joblib import Parallel, delayed  # a tenth of a second that short lists should not pay

    batches = [slice(at, at + _BATCH) for at in range(k, len(grasps), _BATCH)]
    run = Parallel(n_jobs=workers, return_as="generator", batch_size=1)
    answers = run(delayed(_batch)(grasps[b], sections[b], solver) for b in batches)
    for grasp, solution in zip(grasps[k:], itertools.chain.from_iterable(answers), strict=True):
        yield replace(solution, scene=grasp.scene)


@at_once()
def _batch(grasps: Sequence[Grasp], sections: Sequence[Section], solver: AnySolver) -> list[GraspSolution]:
    """In another process; scenes stay at home."""
    pairs = zip(grasps, sections, strict=True)
    return [replace(solve_with_advice(g.spec, s, solver, scene=g.scene), scene=None) for g, s in pairs]
