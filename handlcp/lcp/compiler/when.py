"""When a kernel is compiled: the one place that decides.

A kernel runs as plain Python until that has taken as long as compiled code would take to get (whoever waits then has
waited twice as long as was necessary, at most). `at_once` is for those who know that they will call it often.

The variable HANDLCP_KERNELS overrides it: "compiled" compiles every kernel at its first call, "interpreted" none ever,
"auto" is the rule above. NUMBA_DISABLE_JIT=1 means "interpreted", too.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from handlcp.errors import InputError

LEAST = 3.0  # a kernel that was not asked for at once runs as Python for so long at least [s]
MANY = 100  # calls from which `at_once` believes that compiled code pays: interpreted they take a second
_IMPORT, _LOAD = 0.3, 0.05  # what numba's import takes, and a kernel from a warm cache [s]
_INSTRUCTION = 2e-3  # what numba takes to compile one instruction of Python's bytecode [s]

_lock = threading.Lock()
_inside = 0  # how many blocks of `at_once` are open, in all threads


@cache
def mode() -> str:
    """What HANDLCP_KERNELS says. Raises InputError for anything else than its three words."""
    word = os.environ.get("HANDLCP_KERNELS") or "auto"
    if word not in ("auto", "compiled", "interpreted"):
        raise InputError("HANDLCP_KERNELS", '"auto", "compiled" or "interpreted"', repr(word))
    if word == "auto" and os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return "interpreted"
    return word


@contextmanager
def at_once(calls: float = MANY) -> Iterator[None]:
    """A block, or a function decorated with `@at_once()`, in which kernels are compiled or loaded at their first call.

    calls : how often they will be called, where that is known; fewer than MANY are not worth it. It holds for all
    threads while any of them is inside: work is often spread over several.
    """
    global _inside
    if calls < MANY:
        yield
        return
    with _lock:
        _inside += 1
    try:
        yield
    finally:
        with _lock:
            _inside -= 1


def compiling_at_once() -> bool:
    """Whether a kernel that is called now is to be compiled first."""
    return (_inside > 0 and mode() == "auto") or mode() == "compiled"


def loading_takes() -> float:
    """What compiled code takes to load from a warm cache [s]."""
    return _LOAD if "numba" in sys.modules else _IMPORT + _LOAD


def compiling_takes(instructions: int) -> float:
    """What so many instructions of Python's bytecode take numba to compile [s], roughly."""
    return _INSTRUCTION * instructions
