"""Cells of a sweep on their way: in this process, in others, on anybody's executor. All give the same rows."""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any, NamedTuple

from handlcp.check import cores
from handlcp.design.sweep.work import DESIGN, MOST_HEADS, Done, Row, Task, Values, work
from handlcp.errors import InputError
from handlcp.grasp.batch.run import Jobs

SERIAL = "serial"
_LONG = 1.5  # seconds of a task: long beside the way there and back, and no more is lost when all is stopped [s]
_MOST = 32  # designs of a task
_MANY = 128  # workers of an executor that does not tell how many it has

# ----------------------------------------------------------------
# Where tasks go.


class _Here(Executor):
    """In this process, at once."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        """A future that is done."""
        from concurrent.futures import Future

        future = Future[Any]()
        future.set_result(fn(*args, **kwargs))
        return future


@contextmanager
def executor_for(given: Any) -> Iterator[Executor]:
    """What a user asked for as an executor. One that is made here ends with the block, at once where that fails.

    Raises InputError for anything but an executor, a Dask client, "serial" or None.
    """
    if isinstance(given, str) and given == SERIAL:
        yield _Here()
    elif isinstance(given, Executor):
        yield given
    elif hasattr(given, "get_executor"):  # a Dask client
        yield given.get_executor()
    elif given is None:
        from joblib.externals.loky import get_reusable_executor  # starts under notebooks, and scripts without a guard

        one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        made = get_reusable_executor(cores(None), initializer=_with_parent, env=one_thread)
        try:
            yield made
        except BaseException:
            made.shutdown(wait=True, kill_workers=True)
            raise
    else:
        expected = 'a concurrent.futures.Executor, a Dask client, "serial", or None: processes on this machine'
        raise InputError("executor", expected, repr(given)[:80])


def _with_parent() -> None:
    """This process ends within a second of the one that started it, also where that is killed."""
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


# ----------------------------------------------------------------
# Heads first; as soon as those of a cell are done the rest of it, in tasks of a second or two.


class _Job(NamedTuple):
    """designs : of a task, and for heads the whole cell."""

    designs: Sequence[int]
    heads: bool


class _Rest(NamedTuple):
    """Designs of a cell whose heads are done, and what they start from."""

    designs: deque[int]
    near: bytes | None


def rows_of(
    maker: bytes, cells: Sequence[Sequence[int]], values: Mapping[int, Values], there: frozenset[int],
    executor: Executor,
) -> Iterator[list[Row]]:  # fmt: skip
    """The rows of all designs but those that are there, as they come. values : of each design.

    A cell of which anything is missing has its heads evaluated anew, which gives the others their grasps to start from:
    no more than a search is done twice, and no grasps need to be kept. What the executor itself raises comes out.
    """
    heads = deque([cell for cell in cells if not there.issuperset(cell)])
    rests, workers = deque[_Rest](), getattr(executor, "_max_workers", _MANY)
    flying = 1 if isinstance(executor, _Here) else 2 * workers
    spent, done = 0.0, 0
    with Jobs[_Job](executor) as jobs:

        def send(job: _Job, own: Sequence[int], near: bytes | None) -> None:
            jobs.send(job, work, Task(maker, [(k, values[k]) for k in own], near, job.heads))

        while heads or rests or len(jobs):
            while (heads or rests) and len(jobs) < flying:
                if not rests:
                    cell = heads.popleft()
                    send(_Job(cell, True), cell[:MOST_HEADS], None)
                    continue
                rest, size = rests[0], max(1, min(_MOST, int(_LONG * done / spent))) if spent else 1
                own = [rest.designs.popleft() for _ in range(min(size, len(rest.designs)))]
                if not rest.designs:
                    rests.popleft()
                send(_Job(own, False), own, rest.near)
            for job, result in jobs.done(wait=True):
                found: Done = result
                rows = [row for row in found.rows if row[DESIGN] not in there]
                if job.heads:
                    tried = there | {row[DESIGN] for row in found.rows}
                    if left := [k for k in job.designs if k not in tried]:
                        rests.append(_Rest(deque(left), found.near))
                else:
                    spent, done = spent + found.seconds, done + len(found.rows)
                if rows:
                    yield rows
