"""Jobs on any `concurrent.futures` executor: what comes back in the order in which it is done, and what fails."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from queue import SimpleQueue
from typing import Any, Generic, TypeVar

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
