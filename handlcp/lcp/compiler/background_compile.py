"""`request_compile`: another process compiles into the cache, while calls go on as Python.

One such process works for a cache folder at a time: it holds a lock of the operating system on a file there, which goes
with it however it ends. It ends with the process that started it, whose end closes its standard input, and when it has
had nothing to do for some seconds, so that others get their turn. It says nothing.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib
import os
import pickle
import queue
import subprocess
import sys
import threading
import time
from collections import Counter
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import IO, Any

from handlcp.lcp.compiler import folders

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

ENVIRONMENT_VARIABLE = "HANDLCP_COMPILE_BESIDE"  # 0: no other process is started

_LOCK_FILE = "compiling"  # the file that is locked
_EXIT_BUSY, _EXIT_CANNOT_COMPILE = 3, 4  # exit codes: another process is at work; nothing can be compiled or kept
_IDLE_SECONDS = 3.0  # without a request for so long it ends [s]
_LOCK_RACE_SECONDS = 0.5  # two processes that start at a time look at the lock for so long [s]
_KILL_AFTER_SECONDS = 0.5  # the process may take so long to end before it is killed [s]
_NICENESS = 5  # its work is worth less than the answers themselves, and more than nothing on a busy machine
_MAX_SEND_TRIES = 2  # a process that is just ending may not hear what it is asked for

CompileRequest = tuple[str, str, bytes]  # module and name of a kernel, pickled types of arguments

_SERVER_PROGRAM = (
    "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); "
    "from handlcp.lcp.compiler.background_compile import serve; serve()"
)

# ----------------------------------------------------------------
# In the process that works.


class _CompilerProcess:
    """The process beside this one, if any. sent : what it was asked for. finished_requests : how often a kernel was
    asked for by now of processes that ended with nothing left to do. failed : nothing more is asked.
    """

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.process: subprocess.Popen[bytes] | None = None
        self.sent: set[CompileRequest] = set()
        self.finished_requests: Counter[CompileRequest] = Counter()
        self.failed = False

    def ask(self, request: CompileRequest) -> None:
        """Have a kernel compiled, once, unless another process's compiler is at work: then later."""
        with self.lock:
            if self.process is not None and (ended := self.process.poll()) is not None:
                if ended == 0:
                    self.finished_requests.update(self.sent)
                self._release()
                self.failed = ended not in (0, _EXIT_BUSY)
            self.failed |= (
                self.finished_requests[request] >= _MAX_SEND_TRIES
            )  # they were through with it, and there is no code
            if self.failed or request in self.sent or (self.process is None and _is_locked()):
                return
            if self.process is None and not self._start():
                self.failed = True
                return
            self._send(request)  # where the process just ended, a later look finds that
            self.sent.add(request)

    def end(self) -> None:
        """Stop the process that compiles. What it was at is lost, what it finished is kept."""
        if (process := self._release()) is not None:
            try:
                process.wait(_KILL_AFTER_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def detach_in_fork(self) -> None:
        """In a fork of the process that started it: it is not ours."""
        self.lock = threading.Lock()  # a thread that is not here may have held the other
        if (process := self._release()) is not None:
            process.returncode = 0  # nothing to wait for

    def _release(self) -> subprocess.Popen[bytes] | None:
        """The process, which hears that nothing more comes, and is not known here any longer."""
        process, self.process, self.sent = self.process, None, set()
        if process is not None and process.stdin is not None:
            process.stdin.close()
        return process

    def _start(self) -> bool:
        """In a session of its own, where Ctrl-C does not reach it: it ends with this one anyhow."""
        one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        windows: dict[str, Any] = {"creationflags": 0x08004000}  # no window, below normal priority
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-c", _SERVER_PROGRAM],
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=os.environ | one_thread | {ENVIRONMENT_VARIABLE: "0"},
                **(windows if os.name == "nt" else {"start_new_session": True}),
            )
        except OSError:
            return False
        _register_exit_hooks()
        return self._send(sys.path)

    def _send(self, message: CompileRequest | list[str]) -> bool:
        assert self.process is not None
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(pickle.dumps(message))
        except OSError:
            return False
        return True


_PROCESS = _CompilerProcess()


@cache
def _register_exit_hooks() -> None:
    atexit.register(lambda: _PROCESS.end())
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=lambda: _PROCESS.detach_in_fork())


def can_compile() -> bool:
    """Whether another process may compile for this one: there is a core for it, and a folder that keeps code."""
    return not _PROCESS.failed and _is_allowed() and folders.writable_folder() is not None


@cache
def _is_allowed() -> bool:
    forbidden = os.environ.get(ENVIRONMENT_VARIABLE, "") == "0" or getattr(sys, "frozen", False) or not sys.executable
    return not forbidden and _usable_cores() > 1


def _usable_cores() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def request_compile(function: Any, types: Any) -> None:
    """Have a kernel compiled for these types of arguments, once, beside this process. Nothing happens where the
    compiler of another process is at work: who asks again later gets a turn. `can_compile` is False once it turned out
    that nobody can.
    """
    _PROCESS.ask((function.__module__, function.__qualname__, pickle.dumps(types)))


# ----------------------------------------------------------------
# The lock, of either side.


def _is_locked() -> bool:
    """Whether somebody compiles into the folder now."""
    folder = folders.writable_folder()
    if folder is None or not (folder / _LOCK_FILE).exists():
        return False
    with contextlib.suppress(OSError):
        file = _acquire_lock(folder)
        if file is None:
            return True
        file.close()
    return False


def _acquire_lock(folder: Path) -> IO[bytes] | None:
    """The open file whose lock is ours until it is closed; None: somebody else has it. Raises OSError where nothing can
    be locked.
    """
    file = open(folder / _LOCK_FILE, "ab")  # noqa: SIM115 (the lock is held as long as it is open)
    try:
        if sys.platform == "win32":
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        file.close()
        return None
    return file


# ----------------------------------------------------------------
# In the process that compiles.


def serve() -> None:
    """Compile what comes in at standard input, in order, until that is closed or nothing comes."""
    if hasattr(os, "nice"):
        os.nice(_NICENESS)
    requests: queue.SimpleQueue[CompileRequest] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(requests,), daemon=True).start()
    try:
        code = _compile_requests(requests)
    except Exception:
        code = _EXIT_CANNOT_COMPILE  # the other process compiles it itself, and says what is wrong
    os._exit(code)


def _listen(requests: queue.SimpleQueue[CompileRequest]) -> None:
    """Pass requests on; end the process, between two files, with the one that sends them."""
    with contextlib.suppress(Exception):
        while True:
            requests.put(pickle.load(sys.stdin.buffer))
    with folders.write_lock:
        os._exit(0)


def _compile_requests(requests: queue.SimpleQueue[CompileRequest]) -> int:
    """Returns the exit code."""
    if (folder := folders.writable_folder()) is None:
        return _EXIT_CANNOT_COMPILE
    folders.make_folder(folder)
    until = time.monotonic() + _LOCK_RACE_SECONDS
    while (file := _acquire_lock(folder)) is None:
        if time.monotonic() > until:
            return _EXIT_BUSY
        time.sleep(0.05)
    with file, contextlib.suppress(queue.Empty):
        while True:
            module, name, pickled = requests.get(timeout=_IDLE_SECONDS)
            jit, types = attrgetter(name)(importlib.import_module(module)).dispatcher, pickle.loads(pickled)
            jit.compile(types)
            if not jit._cache.stamp(types, jit.targetctx):
                return _EXIT_CANNOT_COMPILE  # nobody else can load it
    return 0
