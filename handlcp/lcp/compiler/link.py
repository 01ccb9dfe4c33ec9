"""Large kernels are compiled once: who calls one calls it, and does not take its code in.

numba links the code of whatever a function calls into that function, and optimises all of it together, again in every
caller. Small kernels gain by that. A large one is left where it is: its callers need it by its symbol, which the
execution engine finds in the code that was compiled or loaded before. A symbol that is not there would end the process;
so what compiled code needs is kept beside it, and looked for before that code is loaded (`cache`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numba
from numba.core import cgutils
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.extending import intrinsic, overload
from numba.np import arrayobj

from handlcp.lcp.compiler.borrow import borrowed

t: Any = numba.types

_LARGE_KERNEL_INSTRUCTIONS = 150  # instructions of LLVM, optimised: of these a call costs little


class LinkedKernel(NamedTuple):
    """A kernel that compiled code calls: its dotted name, the types of its arguments, and its symbol."""

    kernel: str
    types: Any
    symbol: str


class Library(JITCodeLibrary):  # type: ignore[misc]
    """Code of one kernel. own : what its callers need of it, where it is large. needs : large kernels that it calls."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.own: LinkedKernel | None = None
        self.needs: dict[str, LinkedKernel] = {}

    def add_linking_library(self, library: Any) -> None:
        """Whatever this code calls: taken in, unless it is a large kernel."""
        own = getattr(library, "own", None)
        if own is None:
            super().add_linking_library(library)
            self.needs |= getattr(library, "needs", {})
        else:
            self.needs[own.symbol] = own


class KernelCompiler(Compiler):  # type: ignore[misc]
    """Numba's compiler of one kernel, whose code is a `Library`; all other functions have numba's own.

    numba's way to extend it: https://numba.readthedocs.io/en/stable/extending/customizing.html
    """

    def define_pipelines(self) -> Any:
        """The pipelines of numba, with the library that they fill."""
        if self.state.library is None:
            self.state.library = Library(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
            self.state.library.enable_object_caching()
        return super().define_pipelines()


def is_large(found: Any) -> bool:
    """Whether a kernel that was just compiled is."""
    function = found.library.get_function(found.fndesc.llvm_func_name)
    return sum(1 for block in function.blocks for _ in block.instructions) > _LARGE_KERNEL_INSTRUCTIONS


def keep_apart(found: Any, kernel: str, types: Any) -> None:
    """From now on callers of this kernel do not take it in. found : what numba compiled, or loaded from a file."""
    found.library.own = LinkedKernel(kernel, types, found.fndesc.llvm_func_name)


# ----------------------------------------------------------------
# Arrays that a kernel borrows of its caller, who keeps them: code that counts owners of an array finds none to count.


@intrinsic  # type: ignore[untyped-decorator]
def _without_owner(_context: Any, arrays: Any) -> Any:
    """A value of the same type, whose arrays have no owner."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return _disown(context, builder, signature.args[0], values[0])

    return arrays(arrays), code


def _disown(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    if isinstance(kind, t.Array):
        made = context.make_array(kind)(context, builder, value)
        made.meminfo = cgutils.get_null_value(made.meminfo.type)
        return made._getvalue()
    if isinstance(kind, t.BaseTuple):
        for k, part in enumerate(kind.types):
            own = builder.extract_value(value, k)
            value = builder.insert_value(value, _disown(context, builder, part, own), k)
    return value


@overload(borrowed, target="cpu")  # type: ignore[untyped-decorator]
def _overload_borrowed(arrays: Any) -> Any:
    def disowned(arrays: Any) -> Any:
        return _without_owner(arrays)

    return disowned


# ----------------------------------------------------------------
# Whatever assigns to a slice takes in numba's message about shapes that differ, with all that puts numbers into words:
# two thirds of the time that a kernel takes to compile. While one is compiled, and nothing else can be, that message is
# another one.

_NUMBA_RAISE_STUB = "raise_with_shape_context"  # numba's stub for it, which is looked up when a kernel is compiled


def _shapes_differ(given: Any, wanted: Any) -> None:
    """What compiled code does where shapes differ."""


@overload(_shapes_differ, target="cpu")  # type: ignore[untyped-decorator]
def _overload_shapes_differ(given: Any, wanted: Any) -> Any:
    def raises(given: Any, wanted: Any) -> None:
        raise ValueError("cannot assign to a slice of another shape")

    return raises


@contextmanager
def short_messages() -> Iterator[None]:
    """A block in which what is compiled has a message without numbers. Others wait with their compiling."""
    with global_compiler_lock:
        theirs = getattr(arrayobj, _NUMBA_RAISE_STUB, None)
        setattr(arrayobj, _NUMBA_RAISE_STUB, _shapes_differ)
        try:
            yield
        finally:
            setattr(arrayobj, _NUMBA_RAISE_STUB, theirs)
