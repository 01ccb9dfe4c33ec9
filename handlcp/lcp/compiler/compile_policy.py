"""`kernel_mode` and the one place that decides when a kernel is compiled.

A kernel runs as plain Python until that has taken a second. Then another process compiles it (`background_compile.py`)
while calls go on as Python, and compiled code takes over once it is there. Where no other process may be started, calls
go on until they have taken as long as compiling takes, and the next one waits for it: at most twice as long as was
necessary.

`compile_in_background` is for those who know that they will call kernels often, `compile_now` for those who cannot go
on as Python: streams, and whoever makes one call that takes very long.

The variable HANDLCP_KERNELS overrides it: "compiled" compiles every kernel at its first call, "interpreted" none ever,
"auto" is the rule above. NUMBA_DISABLE_JIT=1 means "interpreted", too.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Iterator
from functools import cache

from handlcp.errors import InputError
from handlcp.lcp.compiler.folders import writable_folder

# ----------------------------------------------------------------
# What is said about compiling, on stderr: once a program, and again where it takes much longer than was said. Of the
# processes that a program starts to compute, one alone says it.

_SILENT_SECONDS = 1.0  # what is compiled within this time is not worth a line [s]

_announced: dict[str, float] = {}  # what a line was about, and how long it said that takes [s]
_announce_permit: Callable[[], bool] | None = None  # gives this process leave to say it; None: it has that


def warn_not_kept(why: str) -> None:
    """That compiled code is not kept, and what to do about it."""
    _print_once(
        f"compiled code is not kept ({why}). Set HANDLCP_CACHE_DIR to a folder that can be written, to compile once."
    )


@contextlib.contextmanager
def announce_waiting(seconds: float) -> Iterator[None]:
    """Around compiling that may take so many seconds: a line once it takes more than one."""
    where = writable_folder()
    seconds = max(seconds, _SILENT_SECONDS)
    text = f"compiling, about {seconds:.0f} s" + ("" if where is None else f", once; kept in {where}")
    timer = threading.Timer(_SILENT_SECONDS, _print_once, (text, seconds))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def silence() -> None:
    """Say nothing about compiling in this process: who calls this has a progress bar of its own."""
    _announced["compiling"] = float("inf")


def share_announcements(permit: Callable[[], bool]) -> None:
    """Share what is said about compiling with other processes: say nothing until `permit` gives True, which it does to
    one of them. It is asked when there is something to say, or at once where this process has said something.
    """
    global _announce_permit
    _announce_permit = permit
    if _announced:
        _is_permitted()


def _is_permitted() -> bool:
    global _announce_permit
    if _announce_permit is not None and _announce_permit():
        _announce_permit = None
    return _announce_permit is None


def _print_once(text: str, seconds: float = 0.0) -> None:
    """A line on stderr, if there is one, unless one that begins with the same word was there before, and what it is
    about does not take more than twice as long as that one said.
    """
    kind = text.partition(",")[0].partition(" ")[0]
    is_new = kind not in _announced or seconds > 2.0 * _announced[kind]
    if sys.stderr is not None and is_new and _is_permitted():
        _announced[kind] = seconds
        with contextlib.suppress(OSError, ValueError):  # closed, or nobody listens any more
            print(f"handlcp: {text}", file=sys.stderr, flush=True)


# ----------------------------------------------------------------

BACKGROUND_AFTER_SECONDS = 1.0  # a kernel runs as Python for so long before another process compiles it [s]
WAIT_AFTER_SECONDS = 3.0  # and for so long at least before a call waits for its compiling [s]
# Calls from which `compile_in_background` and `compile_now` believe that compiled code pays: interpreted they take a
# second
MANY_CALLS = 100
_NUMBA_IMPORT_SECONDS, _KERNEL_LOAD_SECONDS = 0.3, 0.05  # what numba's import takes, and a kernel from a warm cache [s]
_SECONDS_PER_INSTRUCTION = 2e-3  # what numba takes to compile one instruction of Python's bytecode [s]

_LOOK_INTERVALS = (
    0.05,
    0.5,
)  # between two looks for code, at least and at most: a tenth of what the kernel took so far [s]

_lock = threading.Lock()
_open_blocks = {"soon": 0, "at once": 0}  # how many blocks of each are open, in all threads


@cache
def kernel_mode() -> str:
    """The mode of kernels that HANDLCP_KERNELS says. Raises InputError for anything else than its three words."""
    word = os.environ.get("HANDLCP_KERNELS") or "auto"
    if word not in ("auto", "compiled", "interpreted"):
        raise InputError("HANDLCP_KERNELS", '"auto", "compiled" or "interpreted"', repr(word))
    if word == "auto" and os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return "interpreted"
    return word


@contextlib.contextmanager
def compile_now(calls: float = MANY_CALLS) -> Iterator[None]:
    """A block, or a function decorated with `@at_once()`, in which kernels are compiled or loaded at their first call,
    which waits for it.

    calls : how often they will be called, where that is known; fewer than MANY are not worth it. It holds for all
    threads while any of them is inside: work is often spread over several.
    """
    with _count_block("at once", calls):
        yield


@contextlib.contextmanager
def compile_in_background(calls: float = MANY_CALLS) -> Iterator[None]:
    """The same where calls go on as Python until another process has compiled what they need."""
    with _count_block("soon", calls):
        yield


@contextlib.contextmanager
def _count_block(kind: str, calls: float) -> Iterator[None]:
    if calls < MANY_CALLS:
        yield
        return
    with _lock:
        _open_blocks[kind] += 1
    try:
        yield
    finally:
        with _lock:
            _open_blocks[kind] -= 1


def is_compiling_now() -> bool:
    """Whether a kernel that is called now is to be compiled first."""
    return (_open_blocks["at once"] > 0 and kernel_mode() == "auto") or kernel_mode() == "compiled"


def is_compiling_in_background() -> bool:
    """Whether a kernel that is called now is to be compiled, while it runs as Python if that can be."""
    return _open_blocks["soon"] > 0 and kernel_mode() == "auto"


def next_look(spent: float) -> float:
    """When a kernel that waits for its code looks for it again, by the clock of what it spent as Python [s]."""
    least, most = _LOOK_INTERVALS
    return spent + min(max(least, 0.1 * spent), most)


def load_seconds() -> float:
    """What compiled code takes to load from a warm cache [s]."""
    return _KERNEL_LOAD_SECONDS if "numba" in sys.modules else _NUMBA_IMPORT_SECONDS + _KERNEL_LOAD_SECONDS


def compile_seconds(instructions: int) -> float:
    """What so many instructions of Python's bytecode take numba to compile [s], roughly."""
    return _SECONDS_PER_INSTRUCTION * instructions
