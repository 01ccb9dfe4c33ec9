"""Kernels and numba: the dispatcher of a kernel, which runs what is compiled and asks `when` about anything else."""

from __future__ import annotations

import threading
from typing import Any

import numba
from numba.extending import typeof_impl

from handlcp.lcp.compiler import background_compile, compile_policy, link
from handlcp.lcp.compiler.cache import KernelCache
from handlcp.lcp.compiler.compile_policy import announce_waiting
from handlcp.progress import exclude_from_budget

t: Any = numba.types

_lock = threading.RLock()


def dispatcher(kernel: Any) -> Any:
    """That of a `Kernel`, made at the first call. Calling it costs no more than one that numba made alone.

    For types of arguments that it has no code for, it loads some, or compiles where that pays by now, or else lets the
    kernel run as Python.
    """
    with _lock:
        if kernel.jit is None:
            typeof_impl.register(type(kernel))(_typeof)
            options = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
            options["no_cpython_wrapper"] = kernel.is_inner
            jit = numba.njit(**options, pipeline_class=link.KernelCompiler)(kernel.function)
            jit._cache = KernelCache(kernel.function)
            jit.compile = lambda types: _compile(jit, types)
            # numba's C code calls what this one returns
            jit._compile_for_args = lambda *args: _choose_code(kernel, jit, args)
            jit.get_call_template = lambda args, kws: type(jit).get_call_template(jit, _general_types(args), kws)
            kernel.jit = kernel.run = jit
        return kernel.jit


def _compile(jit: Any, types: Any) -> Any:
    with link.short_messages():
        return type(jit).compile(jit, types)


def _typeof(kernel: Any, _: Any) -> Any:
    """Compiled kernels call others by their global names."""
    return numba.types.Dispatcher(dispatcher(kernel))


def _choose_code(kernel: Any, jit: Any, args: tuple[Any, ...]) -> Any:
    """What is to run for these arguments: compiled code, or the kernel as Python."""
    given = tuple([jit.typeof_pyval(a) for a in args])
    jit._types_active_call.clear()
    types = tuple([_writable_type(one) for one in given])
    known = types in jit.overloads
    if not known and types in kernel.missing and kernel.spent < kernel.look and not compile_policy.is_compiling_now():
        return kernel.interpret
    with exclude_from_budget():
        if not (known or _is_kept(kernel, jit, types) or _is_compiled(kernel, jit, types)):
            kernel.wait(again=not jit.overloads)
            return kernel.interpret
        kernel.begin_anew()
        code = jit.compile(types)
    if given != types:  # the next call with such arguments finds it without asking here
        jit._insert([one._code for one in given], code, False)
    return code


# ---- One set of types for a kernel where numba would make several: for constants, and for arrays that are read-only. A
# kernel that writes into one of these is found where it runs as Python.


def _general_types(args: Any) -> Any:
    """Types of arguments in a call from another kernel, as the kernel is compiled for."""
    return tuple([_writable_type(one) if isinstance(one, t.Array) else t.unliteral(one) for one in args])


def _writable_type(one: Any) -> Any:
    """A type of argument with arrays that may be written to."""
    if isinstance(one, t.Array):
        return one if one.mutable else one.copy(readonly=False)
    if isinstance(one, t.BaseTuple) and len(one):
        parts = tuple([_writable_type(part) for part in one.types])
        return one if parts == one.types else t.BaseTuple.from_types(parts, getattr(one, "instance_class", None))
    return one


# ----------------------------------------------------------------


def _is_kept(kernel: Any, jit: Any, types: Any) -> bool:
    """Whether compiled code for these types is there to load; a file that could not be loaded is not read again."""
    file = jit._cache.stamp(types, jit.targetctx)
    if kernel.missing.get(types) == file:
        return False
    if jit._cache.has(types, jit.targetctx):
        return True
    kernel.missing[types] = file
    return False


def _is_compiled(kernel: Any, jit: Any, types: Any) -> bool:
    """Compile it where this call is to wait for that; else another process may be asked to. Returns whether it is."""
    if not compile_policy.is_compiling_now():
        if not (compile_policy.is_compiling_in_background() or kernel.pays()):
            return False
        if (
            background_compile.can_compile() and jit._cache.inside and not kernel.missing[types]
        ):  # else what is there does not fit
            background_compile.request_compile(kernel.function, types)
            kernel.asked = True
            return False
    with announce_waiting(kernel.compiling_takes):
        jit.compile(types)
    return True
