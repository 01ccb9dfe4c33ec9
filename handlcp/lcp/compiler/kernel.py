"""A function that runs as plain Python until it is worth compiling."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property, update_wrapper
from time import perf_counter
from types import CodeType, ModuleType
from typing import Any

import numpy as np

from handlcp.lcp.compiler import when
from handlcp.lcp.compiler.folders import is_kept


class _Thread(threading.local):
    """inside : whether this thread is in a kernel that runs as Python."""

    inside = False


_THREAD = _Thread()


class Kernel:
    """A pure function of arrays and numbers, called by Python or by other kernels. `when` says when it is compiled.

    function : the Python function. run : what a call goes to, a method of the kernel or numba's dispatcher. jit : that
    dispatcher, once there is one. spent : seconds that it ran as Python, with all that it called, since it last got
    compiled code. missing : types of arguments that there is no code for on disk.

    Compiled and interpreted return the same Python types, and numbers that agree to rounding. Neither says anything of
    divisions by zero and overflow.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.function, self.run = function, self._undecided
        self.jit: Any = None
        self.spent, self.missing = 0.0, set[Any]()

    def __call__(self, *args: Any) -> Any:
        """Run it."""
        return self.run(*args)

    def __reduce__(self) -> str:
        """Pickled by name, as functions are."""
        return self.function.__qualname__

    def interpret(self, *args: Any) -> Any:
        """Run it as Python, on its account."""
        begun, outermost = perf_counter(), not _THREAD.inside
        try:
            if not outermost:
                return self.function(*args)
            _THREAD.inside = True
            with np.errstate(all="ignore"):
                return _plain(self.function(*args))
        finally:
            if outermost:
                _THREAD.inside = False
            self.spent += perf_counter() - begun

    def pays(self) -> bool:
        """Whether it has run as Python for as long as it takes to compile."""
        return self.spent > when.LEAST and self.spent > self.compiling_takes

    @cached_property
    def compiling_takes(self) -> float:
        """Seconds, roughly, with all kernels that it calls."""
        return when.compiling_takes(self._instructions)

    @property
    def dispatcher(self) -> Any:
        """numba's, made when first asked for."""
        from handlcp.lcp.compiler.dispatch import dispatcher  # numba: a quarter of a second

        return dispatcher(self)

    def begin_anew(self) -> None:
        """It has compiled code for these arguments; the next ones that it has none for wait as long."""
        self.spent = 0.0

    def _undecided(self, *args: Any) -> Any:
        """Run it as Python, unless compiled code is worth fetching."""
        if when.mode() == "interpreted":
            self.run = self.interpret
        elif when.compiling_at_once() or (self.spent > when.loading_takes() and (self._is_kept or self.pays())):
            return self.dispatcher(*args)
        return self.interpret(*args)

    @cached_property
    def _is_kept(self) -> bool:
        return is_kept(f"{self.__module__}.{self.function.__qualname__}")

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


def _plain(value: Any) -> Any:
    """A result as compiled code returns it: numpy's numbers as Python's."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, tuple):
        parts = [_plain(v) for v in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value
