"""A batch on its way through its stages: on the cores of this machine, or on an executor."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Executor
from typing import NamedTuple

from handlcp.check import Array
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.batch.batch import Batch
from handlcp.grasp.batch.executors import Jobs
from handlcp.grasp.batch.first_stage import Answers, Members, answers_in_threads, kinds_of, parcel, settled, shards
from handlcp.grasp.batch.later_stages import at_home, left_of, solve_left, solve_one
from handlcp.grasp.batch.packing import solve_parcel

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
    # Loky's workers start under notebooks, pytest and scripts without a __main__ guard, and wait for the next batch
    from joblib.externals.loky import get_reusable_executor

    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    with Jobs[list[int]](get_reusable_executor(workers - 1, env=one_thread)) as jobs:
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
