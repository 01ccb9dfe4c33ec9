"""numba's idea of a cache, kept in `folders`: one file for each kernel and types of arguments. It never raises.

numba's own cache notices changes of the file that holds a kernel, not of those that it calls; its index files can be
torn by two processes that write at a time; and it raises where it cannot write.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from handlcp.lcp.compiler import folders, link
from handlcp.lcp.compiler.compile_policy import warn_not_kept


class KernelCache:
    """The cache of one kernel, with the methods that numba's dispatcher calls.

    name : of the kernel, dotted. inside : the package; of others nothing is kept: what they call is not known.
    """

    def __init__(self, function: Any) -> None:
        self.name, self._code = f"{function.__module__}.{function.__qualname__}", function.__code__.co_code
        self.inside = function.__module__.startswith("handlcp.") and "<" not in function.__qualname__
        self._ready: dict[Any, Any] = {}

    @property
    def cache_path(self) -> str:
        """The folder that compiled kernels are written to, the first of those that are read."""
        return str(next(iter(folders.cache_folders()), ""))

    def stamp(self, types: Any, target: Any) -> int:
        """A number that changes when code for these types is kept anew; 0 where there is none."""
        return folders.file_stamp(self._file(types, target.codegen()))

    def has(self, types: Any, target: Any) -> bool:
        """Whether there is compiled code for these types; the next `load_overload` finds it ready."""
        found = self.load_overload(types, target)
        if found is not None:
            self._ready[types] = found
        return found is not None

    def load_overload(self, types: Any, target: Any) -> Any:
        """The compiled function, or None."""
        if (found := self._ready.pop(types, None)) is not None:
            return found
        if not self.inside:
            return None
        try:
            if (data := folders.read_file(self._file(types, target.codegen()))) is None:
                return None
            target.refresh()
            large, needs, reduced = pickle.loads(data)
            if not all([_is_linkable(need) for need in needs]):
                return None
            found = CompileResult._rebuild(target, *reduced)
        except Exception:  # whatever is wrong with a file, it can be compiled anew
            return None
        found.library.needs = {need.symbol: need for need in needs}
        if large:
            link.keep_apart(found, self.name, types)
        return found

    def save_overload(self, types: Any, found: Any) -> None:
        """Keep a compiled function; say once where that fails."""
        if not self.inside or found.library.has_dynamic_globals or any(not x.can_cache for x in found.lifted):
            return
        large, needs = link.is_large(found), tuple(getattr(found.library, "needs", {}).values())
        if large:
            link.keep_apart(found, self.name, types)
        try:
            why = folders.write_file(self._file(types, found.codegen), dumps((large, needs, found._reduce())))
        except Exception as error:
            why = f"{type(error).__name__}: {error}"
        if why is not None:
            warn_not_kept(why)

    def enable(self) -> None:
        """Do nothing, as the cache is always on."""

    def disable(self) -> None:
        """Do nothing, as HANDLCP_CACHE_DIR says where the cache is, and an unwritable folder is none."""

    def flush(self) -> None:
        """Do nothing, as files of an earlier source are never read."""

    def _file(self, types: Any, codegen: Any) -> str:
        """The name of a file: all that the code depends on, as types, processor, versions, and the function itself."""
        versions = numba.__version__, llvmlite.__version__, np.__version__
        said = repr((types, codegen.magic_tuple(), versions, self._code))
        return f"{self.name}-{hashlib.sha256(said.encode()).hexdigest()[:24]}.nbc"


def _is_linkable(need: link.LinkedKernel) -> bool:
    """Whether what compiled code calls is there under its symbol, or can be loaded."""
    module, _, name = need.kernel.rpartition(".")
    jit = getattr(sys.modules[module], name).dispatcher
    if need.types not in jit.overloads:
        if not jit._cache.has(need.types, jit.targetctx):
            return False
        jit.compile(need.types)
    return bool(jit.overloads[need.types].fndesc.llvm_func_name == need.symbol)
