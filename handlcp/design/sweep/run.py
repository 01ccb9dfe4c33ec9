"""Cells of a sweep on their way: in this process, in others, on anybody's executor. All give the same rows."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor
from contextlib import contextmanager
from typing import Any, NamedTuple

from handlcp.check import check_workers
from handlcp.design.evaluation import Evaluation
from handlcp.design.sweep.work import DESIGN, Done, Heads, Row, Task, Values, packed, row_of, unpacked, work
from handlcp.errors import InputError
from handlcp.grasp.batch.solve_many import ExecutorJobs
from handlcp.grasp.batch.worker_pool import end_workers, worker_pool

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
def executor_for(given: Any) -> Iterator[Callable[[], Executor]]:
    """Gives what a user asked for as an executor, each time that it is called: one that is made here is made anew where
    it has lost a process, and ends at once where the block fails.

    Raises InputError for anything but an executor, a Dask client, "serial" or None.
    """
    if given is None:
        try:
            yield lambda: worker_pool(check_workers(None))
        except BaseException:
            end_workers()
            raise
    else:
        executor = _asked(given)
        yield lambda: executor


def _asked(given: Any) -> Executor:
    """Raises InputError."""
    if isinstance(given, str) and given == SERIAL:
        return _Here()
    if isinstance(given, Executor):
        return given
    if hasattr(given, "get_executor"):  # a Dask client
        made: Executor = given.get_executor()
        return made
    expected = 'a concurrent.futures.Executor, a Dask client, "serial", or None: processes on this machine'
    raise InputError("executor", expected, repr(given)[:80])


# ----------------------------------------------------------------
# Heads first; as soon as those of a cell are done the rest of it, in tasks of a second or two.


class _Cell:
    """A cell on its way. left : designs that may begin and have not. near : what they start from, packed."""

    def __init__(self, designs: Sequence[int]) -> None:
        self.designs, self.heads = designs, Heads(designs)
        self.left = deque[int]()
        self.near: bytes | None = None


class _Job(NamedTuple):
    """Designs of one task, their cell, and whether it is one of its heads."""

    designs: list[int]
    cell: _Cell
    head: bool


class _Queue:
    """The designs of a sweep, in the order in which they begin.

    A cell of which anything is missing has its heads evaluated anew, which gives the others their grasps to start from:
    no more than its search is done twice, and no grasps need to be kept.
    """

    def __init__(self, cells: Sequence[Sequence[int]], there: frozenset[int]) -> None:
        self.there = there
        self.cells = deque([_Cell(cell) for cell in cells if not there.issuperset(cell)])
        self.heads, self.open = deque[_Job](), deque[_Cell]()
        self.spent, self.done = 0.0, 0

    @property
    def waiting(self) -> bool:
        """Whether anything has not begun."""
        return bool(self.cells or self.heads or self.open)

    def next(self, suspects: deque[_Job] | None = None) -> _Job | None:
        """What begins next, of these where there are any; None: nothing for now."""
        if suspects is not None:
            return suspects.popleft() if suspects else None
        if self.open:
            cell = self.open[0]
            size = max(1, min(_MOST, int(_LONG * self.done / self.spent))) if self.spent else 1
            own = [cell.left.popleft() for _ in range(min(size, len(cell.left)))]
            if not cell.left:
                self.open.popleft()
            return _Job(own, cell, False)
        if not self.heads and self.cells:
            self._go_on(self.cells.popleft())
        return self.heads.popleft() if self.heads else None

    def put(self, job: _Job, done: Done) -> list[Row]:
        """A job is done: its rows that were not there."""
        if job.head:
            grasps: Evaluation | None = None if done.grasps is None else unpacked(done.grasps)
            job.cell.heads.found[job.designs[0]] = grasps
            self._go_on(job.cell)
        else:
            self.spent, self.done = self.spent + done.seconds, self.done + len(done.rows)
        return [row for row in done.rows if row[DESIGN] not in self.there]

    def _go_on(self, cell: _Cell) -> None:
        near, ready = cell.heads.near, cell.heads.ready()
        if ready or cell.heads.done:
            cell.near = None if near is None else packed(near)
        self.heads.extend(_Job([k], cell, True) for k in ready)
        if cell.heads.done:
            cell.left.extend(k for k in cell.designs if k not in self.there and k not in cell.heads.found)
            if cell.left:
                self.open.append(cell)


def rows_of(
    maker: bytes, cells: Sequence[Sequence[int]], values: Mapping[int, Values], there: frozenset[int], given: Any,
    does: Callable[[Task], Done] = work,
) -> Generator[list[Row], None, None]:  # fmt: skip
    """The rows of all designs but those that are there, as they come. values : of each design. given : the executor
    that a user asked for. does : what a worker does with a task.

    Where a process of this machine's own dies, such as by a crash in compiled code, the designs that were under way are
    done one by one, and one that ends its process again is a row that says so. What other executors raise comes out.
    """
    queue, suspects = _Queue(cells, there), deque[_Job]()
    with executor_for(given) as renewed:
        while queue.waiting or suspects:
            executor, flying, alone = renewed(), list[_Job](), bool(suspects)
            most = 1 if alone or isinstance(executor, _Here) else 2 * getattr(executor, "_max_workers", _MANY)
            try:
                with ExecutorJobs[_Job](executor) as jobs:
                    while True:
                        while len(flying) < most and (job := queue.next(suspects if alone else None)) is not None:
                            flying.append(job)
                            designs = [(k, values[k]) for k in job.designs]
                            jobs.send(job, does, Task(maker, designs, job.cell.near, job.head))
                        if not flying:
                            break
                        for job, done in jobs.finished_results(wait=True):
                            flying.remove(job)
                            if rows := queue.put(job, done):
                                yield rows
            except BrokenExecutor as error:
                if given is not None:
                    raise
                if not alone:
                    suspects.extend(_Job([k], job.cell, job.head) for job in flying for k in job.designs)
                    continue
                why = f"{type(error).__name__}: the process that evaluated it ended"
                for job in flying:
                    number = job.designs[0]
                    if rows := queue.put(job, Done([row_of((number, values[number]), why)], None, 0.0)):
                        yield rows
