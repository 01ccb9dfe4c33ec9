"""Processes of this machine that compute, for all calls of a program: one pool, which waits for the next call.

They are loky's, which start under notebooks, pytest and scripts without a __main__ guard. Each computes with one
thread. None hears Ctrl-C, whether or not this program does: it is for this program, which ends them. They also end when
this program is killed.
"""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager, suppress
from functools import cache, partial
from typing import Any

from handlcp.lcp.compiler import compile_policy

_ONE_THREAD_ENVIRONMENT = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
# Loky's, of a process that it replaces, such as a large one
_REPLACED_WARNING = "A worker stopped while some jobs were given"
_PARENT_CHECK_SECONDS = 1.0  # between two looks whether this program is still there [s]


def worker_pool(count: int) -> Any:
    """The executor with so many processes; the same as before, if these are all there.

    A process that is replaced is nothing to act on. loky warns of it in a thread of its own, which would end where
    warnings are errors, and every call would wait for ever.
    """
    from joblib.externals.loky import get_reusable_executor

    warnings.filterwarnings("ignore", _REPLACED_WARNING, UserWarning)
    with _hold_back_interrupts():
        pool = get_reusable_executor(
            count, initializer=_start_worker, initargs=(os.getpid(), _compile_permit()), env=_ONE_THREAD_ENVIRONMENT
        )
        with suppress(BrokenExecutor):  # a process has just died: whoever sends work next hears it
            pool.submit(os.getpid)  # which starts them
    return pool


def end_workers() -> None:
    """End the processes, whatever they are at."""
    from joblib.externals.loky import get_reusable_executor

    get_reusable_executor(reuse=True).shutdown(wait=True, kill_workers=True)


@cache
def _compile_permit() -> Any:
    """The one permit of this program and its processes to say that they compile."""
    from joblib.externals.loky import backend

    permit = backend.get_context("loky").Semaphore(1)
    compile_policy.share_announcements(partial(permit.acquire, False))
    return permit


def _start_worker(parent: int, permit: Any) -> None:
    """In a new process, first of all."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    compile_policy.share_announcements(partial(permit.acquire, False))
    threading.Thread(target=_end_with_parent, args=(parent,), daemon=True).start()


def _end_with_parent(parent: int) -> None:
    """End this process soon after the one that started it, also where that is killed."""
    while os.getppid() == parent:
        time.sleep(_PARENT_CHECK_SECONDS)
    os._exit(1)


@contextmanager
def _hold_back_interrupts() -> Iterator[None]:
    """Ctrl-C arrives after this block. Processes that start in it, or by a thread that does, never hear it."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
