"""`Kernel`: a function that runs as plain Python until it is worth compiling."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property, update_wrapper
from time import perf_counter
from types import CodeType, ModuleType
from typing import Any

import numpy as np

from handlcp.lcp.compiler import background_compile, compile_policy
from handlcp.lcp.compiler.folders import is_kept


class _ThreadState(threading.local):
    """What this thread runs as Python.

    outermost : the kernel that no other kernel called; None: it runs none.
    """

    outermost: Kernel | None = None


_THREAD = _ThreadState()


class Kernel:
    """A pure function of arrays and numbers, called by Python or by other kernels. `when` says when it is compiled.

    function : the Python function. run : what a call goes to, a method of the kernel or numba's dispatcher. jit : that
    dispatcher, once there is one. spent : seconds that it ran as Python, with all that it called, since it last got
    compiled code. asked : whether another process was asked to compile it. look : it goes on as Python until `spent`
    is so much, without a look for code. missing : types of arguments that there was no code for on disk, with what
    `folders.stamp` said.

    Compiled and interpreted return the same Python types, and numbers that agree to rounding. Neither says anything of
    divisions by zero and overflow.
    """

    is_inner = False  # whether compiled code alone calls it: what Python needs to call it is not compiled

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.function, self.run = function, self._run_or_fetch
        self.jit: Any = None
        self.spent, self.asked, self.look = 0.0, False, 0.0
        self.missing: dict[Any, int] = {}

    def __call__(self, *args: Any) -> Any:
        """Run the kernel, compiled where it is, else as Python."""
        return self.run(*args)

    def __reduce__(self) -> str:
        """Pickled by name, as functions are."""
        return self.function.__qualname__

    def interpret(self, *args: Any) -> Any:
        """Run it as Python, on its account."""
        begun, outermost = perf_counter(), _THREAD.outermost is None
        try:
            if not outermost:
                return self.function(*args)
            _THREAD.outermost = self
            with np.errstate(all="ignore"):
                return _as_python_numbers(self.function(*args))
        finally:
            if outermost:
                _THREAD.outermost = None
            self.spent += perf_counter() - begun

    def pays(self) -> bool:
        """Whether it has run as Python for so long that compiling it is worth what it costs."""
        if self.spent > compile_policy.BACKGROUND_AFTER_SECONDS and background_compile.can_compile():
            return not self._is_compiled_with_caller
        return self.spent > compile_policy.WAIT_AFTER_SECONDS and self.spent > self.compiling_takes

    @cached_property
    def compiling_takes(self) -> float:
        """Seconds, roughly, with all kernels that it calls."""
        return compile_policy.compile_seconds(self._instructions)

    @property
    def dispatcher(self) -> Any:
        """numba's, made when first asked for."""
        from handlcp.lcp.compiler.dispatch import dispatcher  # numba: a quarter of a second

        return dispatcher(self)

    def begin_anew(self) -> None:
        """It has compiled code for these arguments; the next ones that it has none for wait as long."""
        self.spent, self.asked, self.look = 0.0, False, 0.0

    def wait(self, again: bool) -> None:
        """Go on as Python for a while. again : without asking numba's dispatcher, which has no code for any types."""
        self.look = compile_policy.next_look(self.spent)
        if again:
            self.run = self._run_or_fetch

    def _run_or_fetch(self, *args: Any) -> Any:
        """Run it as Python, unless compiled code is worth fetching."""
        if self.spent >= self.look or compile_policy.is_compiling_now():
            if compile_policy.kernel_mode() == "interpreted":
                self.run = self.interpret
            elif self._is_worth_a_look():
                self.run = self.dispatcher  # until it has no code: `wait`
                return self.run(*args)
        return self.interpret(*args)

    def _is_worth_a_look(self) -> bool:
        if compile_policy.is_compiling_now() or (
            compile_policy.is_compiling_in_background() and not self._is_compiled_with_caller
        ):
            return True
        if self.spent <= compile_policy.load_seconds():
            return False
        if self.asked or is_kept(f"{self.__module__}.{self.function.__qualname__}") or self.pays():
            return True
        self.look = compile_policy.next_look(self.spent)
        return False

    @property
    def _is_compiled_with_caller(self) -> bool:
        """Whether a kernel that called it as Python is being compiled, and this one with it."""
        outermost = _THREAD.outermost
        return outermost is not None and outermost.asked

    @cached_property
    def _instructions(self) -> int:
        """Of its bytecode and that of all kernels that it calls, by name or as attributes of a module."""
        seen: dict[CodeType, int] = {}
        todo = [self.function]
        while todo:
            function: Any = todo.pop()
            code = function.__code__
            if code not in seen:
                seen[code] = len(code.co_code) // 2
                found = [function.__globals__.get(name) for name in code.co_names]
                for module in [m for m in found if isinstance(m, ModuleType) and m.__name__.startswith("handlcp")]:
                    found += [getattr(module, name, None) for name in code.co_names]
                todo += [k.function for k in found if isinstance(k, Kernel)]
        return sum(seen.values())


def _as_python_numbers(value: Any) -> Any:
    """A result as compiled code returns it: numpy's numbers as Python's."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, tuple):
        parts = [_as_python_numbers(v) for v in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value
