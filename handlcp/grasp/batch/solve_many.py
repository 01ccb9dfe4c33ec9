"""`solve_many`: shards of a batch on cores, or on somebody's executor: the first stage, and what it leaves open."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from queue import SimpleQueue
from typing import Any, Generic, NamedTuple, TypeVar

from handlcp.check import check_call, check_workers
from handlcp.contact.friction import Pyramid, Section
from handlcp.errors import InputError
from handlcp.grasp.analysis.solve_to_accuracy import attach_advice
from handlcp.grasp.batch.grasp_batch import (
    GraspBatch,
    Shard,
    ShardAnswers,
    answers_in_threads,
    batch_of,
    group_by_kind,
    pack_shard,
    solve_parcel,
)
from handlcp.grasp.batch.solutions import Solutions
from handlcp.grasp.batch.worker_pool import worker_pool
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.compiled_answer import CompiledAnswer
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lcp import Auto, ContactSolver, Solver
from handlcp.lcp.compiler.compile_policy import compile_in_background
from handlcp.lcp.solve import AnySolver
from handlcp.progress import Progress, track_progress

# ----------------------------------------------------------------
# Jobs on any `concurrent.futures` executor: what comes back in the order in which it is done, and what fails.

J = TypeVar("J")


class ExecutorJobs(Generic[J]):
    """Jobs on their way through an executor, each with what its sender knows it by.

    Leaving the `with` block cancels what has not begun. An error of a job or of the executor itself, such as a pool
    that lost a process, comes out of `send` or `done` as it is.
    """

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._sent: dict[Future[Any], tuple[J, int]] = {}
        self._done: SimpleQueue[Future[Any]] = SimpleQueue()
        self.size = 0  # bytes on their way

    def __enter__(self) -> ExecutorJobs[J]:
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

    def finished_results(self, wait: bool) -> Iterator[tuple[J, Any]]:
        """(job, result) of those that are done; wait : for one at least."""
        while self._sent and (wait or not self._done.empty()):
            future = self._done.get()
            job, size = self._sent.pop(future)
            self.size -= size
            wait = False
            yield job, future.result()


# ----------------------------------------------------------------
# What the first stage leaves: each grasp through the later stages by itself, here or in another process.


class SingleSolution(NamedTuple):
    """A solution with the place of its grasp in the batch."""

    at: int
    solution: GraspSolution


@dataclass(frozen=True, slots=True)
class UnsolvedGrasps:
    """Grasps as they travel, in one pickle: what they share, such as their hand, is in it once, and a grasp made by
    `replace(wrench=...)` adds some 350 bytes. Scenes stay at home.
    """

    specs: tuple[GraspSpec, ...]
    sections: tuple[Section, ...]
    solver: AnySolver
    proof: bool


def pack_unsolved(batch: GraspBatch, at: Sequence[int]) -> UnsolvedGrasps:
    """These grasps as they travel."""
    specs, sections = tuple([batch.grasps[k].spec for k in at]), tuple([batch.section(k) for k in at])
    return UnsolvedGrasps(specs, sections, batch.solver, batch.proof)


@compile_in_background()
def solve_unsolved(left: UnsolvedGrasps) -> list[GraspSolution]:
    """The solutions, without their scenes, wherever the grasps were sent."""
    each = zip(left.specs, left.sections, strict=True)
    return [replace(solve_spec(spec, s, left.solver, proof=left.proof), scene=None) for spec, s in each]


def solve_one(batch: GraspBatch, k: int) -> SingleSolution:
    """The solution of grasp k."""
    g = batch.grasps[k]
    scene = replace(g.scene)  # a solve hangs matrices on it: on one that goes, no batch piles them up
    return restore_scene(batch, k, solve_spec(g.spec, batch.section(k), batch.solver, scene=scene, proof=batch.proof))


def restore_scene(batch: GraspBatch, k: int, solution: GraspSolution) -> SingleSolution:
    """A solution with the scene of its grasp, and advice that is worked out when it is asked for."""
    g = batch.grasps[k]
    return SingleSolution(k, attach_advice(replace(solution, scene=g.scene), g.spec, batch.section(k)))


# ----------------------------------------------------------------
# A batch on its way through its stages: on the cores of this machine, or on an executor.

# ---- on this machine
_TRIAL_SECONDS = 0.25  # seconds of later stages that are done here before anybody asks how long the rest will take [s]
# Seconds that the rest has to take: another process needs one to import the package and load kernels [s]
_MIN_PROCESS_SECONDS = 2.0
_SHARD_SECONDS = 0.25  # seconds of work that travel together: long beside the way there and back, short at the end [s]
_SHARDS_PER_PROCESS = 2  # shards on their way for each process, so that it need not wait for this one

# ---- on an executor: a Dask cluster spends 0.2 to 1 ms on a task; a grasp takes some ten µs in the first stage, from
# 1 ms on in the later ones. A shard is long beside its task. Small batches are cut finer, down to where it no longer is
_MIN_SHARDS = 64  # shards that a batch is cut into at least, so that many workers have work
_FIRST_SHARD_GRASPS = 256, 2048  # grasps of a shard in the first stage, least and most
_MAX_LATER_GRASPS = 32  # grasps of a shard in the later stages, most
_MIN_PIECES = 8  # shards for what another shard leaves, at least
_MAX_SHARD_BYTES = 2**22  # bytes of a shard in the first stage, most: Dask warns of 10 MB
_MAX_BYTES_SENT = 2**28  # bytes of shards on their way: a batch of any size needs no more memory than that


FoundSolutions = Iterator[ShardAnswers | SingleSolution]


def solve_on_cores(batch: GraspBatch, workers: int) -> FoundSolutions:
    """What is found, as it comes: the first stage in threads, then what it left, in processes where that takes long."""
    shards, left = group_by_kind(batch)
    for answers in answers_in_threads(batch, shards, workers):
        kept, lost = answers.split_settled(batch.proof)
        left += lost
        if len(kept.at):
            yield kept
    queue, begun, done = deque(sorted(left)), time.perf_counter(), 0
    while queue:
        yield solve_one(batch, queue.popleft())
        done += 1
        spent = time.perf_counter() - begun
        if workers > 1 and spent >= _TRIAL_SECONDS and spent / done * len(queue) > _MIN_PROCESS_SECONDS:
            size = max(1, min(_MAX_LATER_GRASPS, round(_SHARD_SECONDS * done / spent)))
            yield from _with_processes(batch, queue, workers, size)


def _with_processes(batch: GraspBatch, queue: deque[int], workers: int, size: int) -> FoundSolutions:
    """The rest of the queue: this process goes on with it, while others start and take shards of so many grasps."""
    with ExecutorJobs[list[int]](worker_pool(workers - 1)) as jobs:
        while queue or len(jobs):
            while queue and len(jobs) < _SHARDS_PER_PROCESS * (workers - 1):
                at = [queue.pop() for _ in range(min(size, len(queue)))]
                jobs.send(at, solve_unsolved, pack_unsolved(batch, at))
            if queue:
                yield solve_one(batch, queue.popleft())
            for at, solutions in jobs.finished_results(wait=not queue):
                yield from (restore_scene(batch, k, s) for k, s in zip(at, solutions, strict=True))


def solve_on_executor(batch: GraspBatch, executor: Executor) -> FoundSolutions:
    """What is found, as it comes, all of it on the executor: what a shard leaves goes there again, in smaller ones."""
    shards, left = group_by_kind(batch)
    share = -(-len(batch) // _MIN_SHARDS)
    most = min(_FIRST_SHARD_GRASPS[1], max(_FIRST_SHARD_GRASPS[0], share))
    first = deque[Shard]()
    for own in shards:
        first += own.split(max(1, min(most, _MAX_SHARD_BYTES // (8 * own.kind.width))))
    later = deque(_split(left, share))
    with ExecutorJobs[Shard | list[int]](executor) as jobs:
        while first or later or len(jobs):
            while (first or later) and jobs.size < _MAX_BYTES_SENT:
                if later:
                    some = later.popleft()
                    jobs.send(some, solve_unsolved, pack_unsolved(batch, some))
                else:
                    cargo = pack_shard(batch, shard := first.popleft())
                    jobs.send(shard, solve_parcel, cargo, cargo.size)
            for job, result in jobs.finished_results(wait=True):
                if isinstance(job, Shard):
                    answers = ShardAnswers(job.at, CompiledAnswer(job.kind, result))
                    kept, lost = answers.split_settled(batch.proof)
                    later.extend(_split(lost, share))
                    if len(kept.at):
                        yield kept
                else:
                    yield from (restore_scene(batch, k, s) for k, s in zip(job, result, strict=True))


def _split(left: list[int], share: int) -> Iterator[list[int]]:
    """In several pieces even where few are left: each may take seconds."""
    size = max(1, min(_MAX_LATER_GRASPS, share, len(left) // _MIN_PIECES))
    return (left[k : k + size] for k in range(0, len(left), size))


# ----------------------------------------------------------------
# Many grasps at once, over all cores or a cluster: for sweeps over loads, postures and designs.


@check_call()
def solve_many(
    grasps: Iterable[Grasp],
    faces: int | str | Pyramid = "cone",
    solver: Solver | ContactSolver | Auto | None = None,
    *,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Progress = None,
    proof: bool = True,
) -> Solutions:
    """The solution of each grasp, as its own `solve(faces, solver, throw=False, proof=proof)` gives it: the same bits,
    whatever the workers, on machines of one kind.

    workers : how many at a time on this machine; None: one a core.
    executor : any `concurrent.futures` executor, which then does all the work, such as `client.get_executor()` of a
        Dask cluster; None: this machine. handlcp has to be installed where it works.
    progress : None: a line on the terminal once it takes long; False: none; True: a line on stderr that stays; a
        function: called with (grasps done, all grasps) from time to time.
    proof : where no answer is found, whether to search for a proof that there is none, up to some seconds a grasp;
        False: stop there, in bounded time, and say UNDECIDED.

    The solver's first stage takes grasps of one kind as the rows of a matrix, in threads, a few ten microseconds each.
    What it leaves goes through the later stages one by one, and in processes where that takes seconds. An executor
    gets both in shards. Beside the grasps themselves, a batch keeps up to 8 (3 c + n + 27) bytes for each of n contacts
    with c force components, 0.6 kB with five fingers; and some 6 kB for each that the first stage leaves.

    Raises InputError for anything but grasps, and for `workers` beside an executor. What an executor raises, such as
    BrokenProcessPool where a process was killed, comes out as it is, and there are no solutions; a Dask cluster sends
    what a lost worker had to another.
    """
    batch = batch_of(grasps, faces, solver, proof)
    if executor is not None and not isinstance(executor, Executor):
        raise InputError("executor", "a concurrent.futures.Executor, or None", repr(executor)[:80])
    if executor is not None and workers is not None:
        raise InputError("workers", "None beside an executor, which has its own", workers)
    count = check_workers(workers)
    answers: list[ShardAnswers] = []
    singles: dict[int, GraspSolution] = {}
    with track_progress("grasps", len(batch), progress) as say, compile_in_background(len(batch)):
        for found in solve_on_cores(batch, count) if executor is None else solve_on_executor(batch, executor):
            if isinstance(found, SingleSolution):
                singles[found.at] = found.solution
                say(1)
            else:
                answers.append(found)
                say(len(found.at))
    return Solutions(batch, answers, singles)
