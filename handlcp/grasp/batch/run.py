"""Shards of a batch on cores, or on somebody's executor: the first stage, and what it leaves open."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from queue import SimpleQueue
from typing import Any, Generic, NamedTuple, TypeVar

from handlcp.check import Array
from handlcp.grasp.analysis.advice import advised
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.build import build
from handlcp.grasp.batch.first_stage import (
    Answers,
    Batch,
    Members,
    answers_in_threads,
    kinds_of,
    parcel,
    settled,
    shards,
    solve_parcel,
)
from handlcp.grasp.batch.worker_pool import worker_pool
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import CompiledAnswer, compiled_kind
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.solve.stages import solve_built
from handlcp.lcp.compiler.when import soon
from handlcp.lcp.solve import AnySolver

# ----------------------------------------------------------------
# Jobs on any `concurrent.futures` executor: what comes back in the order in which it is done, and what fails.

J = TypeVar("J")


class Jobs(Generic[J]):
    """Jobs on their way through an executor, each with what its sender knows it by.

    Leaving the `with` block cancels what has not begun. An error of a job or of the executor itself, such as a pool
    that lost a process, comes out of `send` or `done` as it is.
    """

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._sent: dict[Future[Any], tuple[J, int]] = {}
        self._done: SimpleQueue[Future[Any]] = SimpleQueue()
        self.size = 0  # bytes on their way

    def __enter__(self) -> Jobs[J]:
        return self

    def __exit__(self, *_: object) -> None:
        for future in self._sent:
            future.cancel()

    def __len__(self) -> int:
        return len(self._sent)

    def send(self, job: J, run: Callable[[Any], Any], cargo: Any, size: int = 0) -> None:
        """Have run(cargo) computed; size : of the cargo [bytes]."""
        future = self._executor.submit(run, cargo)
        self._sent[future] = job, size
        self.size += size
        future.add_done_callback(self._done.put)

    def done(self, wait: bool) -> Iterator[tuple[J, Any]]:
        """(job, result) of those that are done; wait : for one at least."""
        while self._sent and (wait or not self._done.empty()):
            future = self._done.get()
            job, size = self._sent.pop(future)
            self.size -= size
            wait = False
            yield job, future.result()


# ----------------------------------------------------------------
# What the first stage leaves: each grasp through the later stages by itself, here or in another process.


@dataclass(frozen=True, slots=True)
class Left:
    """Grasps as they travel, in one pickle: what they share, such as their hand, is in it once, and a grasp made by
    `replace(wrench=...)` adds some 350 bytes and the row of its first stage. Scenes stay at home.
    """

    specs: tuple[GraspSpec, ...]
    sections: tuple[Section, ...]
    rows: tuple[Array | None, ...]
    solver: AnySolver
    proof: bool


def solve_one(batch: Batch, k: int, row: Array | None) -> GraspSolution:
    """The solution of grasp k. row : what its first stage came to, where that is known."""
    g = batch.grasps[k]
    scene = replace(g.scene)  # a solve hangs matrices on its scene: on one that goes, so that no batch piles them up
    return at_home(batch, k, _solved(g.spec, scene, batch.section(k), batch.solver, batch.proof, row))


def left_of(batch: Batch, at: Sequence[int], rows: dict[int, Array]) -> Left:
    """These grasps as they travel, with their rows, which are taken out."""
    specs, sections = tuple([batch.grasps[k].spec for k in at]), tuple([batch.section(k) for k in at])
    return Left(specs, sections, tuple([rows.pop(k, None) for k in at]), batch.solver, batch.proof)


@soon()
def solve_left(left: Left) -> list[GraspSolution]:
    """The solutions, without their scenes, wherever the grasps were sent."""
    every = zip(left.specs, left.sections, left.rows, strict=True)
    return [replace(_solved(s, build(s), own, left.solver, left.proof, row), scene=None) for s, own, row in every]


def at_home(batch: Batch, k: int, solution: GraspSolution) -> GraspSolution:
    """A solution with the scene of its grasp, and advice that is worked out when it is asked for."""
    g = batch.grasps[k]
    return advised(replace(solution, scene=g.scene), g.spec, batch.section(k))


def _solved(
    spec: GraspSpec, scene: Scene, section: Section, solver: AnySolver, proof: bool, row: Array | None
) -> GraspSolution:
    if row is None:
        return solve_spec(spec, section, solver, scene=scene, proof=proof)
    first = CompiledAnswer(compiled_kind(scene, section), row)
    return solve_built(spec, scene, section, solver, proof=proof, first=first)


# ----------------------------------------------------------------
# A batch on its way through its stages: on the cores of this machine, or on an executor.

# ---- on this machine
_LOOK = 0.25  # seconds of later stages that are done here before anybody asks how long the rest will take [s]
_WORTH = 2.0  # seconds that the rest has to take: another process needs one to import the package and load kernels [s]
_SHARD = 0.25  # seconds of work that travel together: long beside the way there and back, short at the end [s]
_AHEAD = 2  # shards on their way for each process, so that it need not wait for this one

# ---- on an executor: a Dask cluster spends 0.2 to 1 ms on a task; a grasp takes some ten µs in the first stage, from
# 1 ms on in the later ones. A shard is long beside its task. Small batches are cut finer, down to where it no longer is
_SHARES = 64  # shards that a batch is cut into at least, so that many workers have work
_FIRST = 256, 2048  # grasps of a shard in the first stage, least and most
_LATER = 32  # grasps of a shard in the later stages, most
_PIECES = 8  # shards for what another shard leaves, at least
_WEIGHT = 2**22  # bytes of a shard in the first stage, most: Dask warns of 10 MB
_FLYING = 2**28  # bytes of shards on their way: a batch of any size needs no more memory than that


class Single(NamedTuple):
    """A solution with the place of its grasp in the batch."""

    at: int
    solution: GraspSolution


Found = Iterator[Answers | Single]


def on_cores(batch: Batch, workers: int) -> Found:
    """What is found, as it comes: the first stage in threads, then what it left, in processes where that takes long."""
    kinds, left = kinds_of(batch)
    rows: dict[int, Array] = {}
    for answers in answers_in_threads(batch, kinds, workers):
        kept, lost = settled(answers, batch.proof)
        rows |= lost
        if len(kept.at):
            yield kept
    queue, begun, done = deque(sorted([*left, *rows])), time.perf_counter(), 0
    while queue:
        k = queue.popleft()
        yield Single(k, solve_one(batch, k, rows.pop(k, None)))
        done += 1
        spent = time.perf_counter() - begun
        if workers > 1 and spent >= _LOOK and spent / done * len(queue) > _WORTH:
            yield from _with_processes(batch, queue, rows, workers, max(1, min(_LATER, round(_SHARD * done / spent))))


def _with_processes(batch: Batch, queue: deque[int], rows: dict[int, Array], workers: int, size: int) -> Found:
    """The rest of the queue: this process goes on with it, while others start and take shards of so many grasps."""
    with Jobs[list[int]](worker_pool(workers - 1)) as jobs:
        while queue or len(jobs):
            while queue and len(jobs) < _AHEAD * (workers - 1):
                at = [queue.pop() for _ in range(min(size, len(queue)))]
                jobs.send(at, solve_left, left_of(batch, at, rows))
            if queue:
                k = queue.popleft()
                yield Single(k, solve_one(batch, k, rows.pop(k, None)))
            for at, solutions in jobs.done(wait=not queue):
                yield from (Single(k, at_home(batch, k, s)) for k, s in zip(at, solutions, strict=True))


def on_executor(batch: Batch, executor: Executor) -> Found:
    """What is found, as it comes, all of it on the executor: what a shard leaves goes there again, in smaller ones."""
    kinds, left = kinds_of(batch)
    rows: dict[int, Array] = {}
    share = -(-len(batch) // _SHARES)
    most = min(_FIRST[1], max(_FIRST[0], share))
    first = deque([s for own in kinds for s in shards([own], min(most, _WEIGHT // (8 * own.kind.scene_width)))])
    later = deque(_split(left, share))
    with Jobs[Members | list[int]](executor) as jobs:
        while first or later or len(jobs):
            while (first or later) and jobs.size < _FLYING:
                if later:
                    some = later.popleft()
                    jobs.send(some, solve_left, left_of(batch, some, rows))
                else:
                    cargo = parcel(batch, shard := first.popleft())
                    jobs.send(shard, solve_parcel, cargo, cargo.size)
            for job, result in jobs.done(wait=True):
                if isinstance(job, Members):
                    kept, lost = settled(Answers(*job, result), batch.proof)
                    rows |= lost
                    later.extend(_split(list(lost), share))
                    if len(kept.at):
                        yield kept
                else:
                    yield from (Single(k, at_home(batch, k, s)) for k, s in zip(job, result, strict=True))


def _split(left: list[int], share: int) -> Iterator[list[int]]:
    """In several pieces even where few are left: each may take seconds."""
    size = max(1, min(_LATER, share, len(left) // _PIECES))
    return (left[k : k + size] for k in range(0, len(left), size))
