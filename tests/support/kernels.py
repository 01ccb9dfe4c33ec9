"""The package's kernels as a whole, kernels anew, and the places and the times that decide about compiling."""

import ast
import importlib
import pathlib
import sys
from contextlib import ExitStack, contextmanager
from unittest.mock import patch

import numpy as np

import handlcp
from handlcp.lcp.compiler import background_compile, compile_policy, folders
from handlcp.lcp.compiler.kernel import Kernel
from handlcp.lcp.kernels import dense as _door
from handlcp.lcp.kernels.dense import multiply_add, solve_ranked

PACKAGE = pathlib.Path(handlcp.__file__).parent
roots, put = folders._root_folders, folders.write_file
waiting, decorated = compile_policy.announce_waiting, _door.kernel
_allowed = background_compile._is_allowed.__wrapped__


def kernels():
    """(module, name there, kernel) of every one; a kernel that several modules import comes several times."""
    for module in [m for name, m in sys.modules.items() if name.startswith("handlcp.")]:
        for name, value in list(vars(module).items()):
            if isinstance(value, Kernel):
                yield module, name, value


def _distinct():
    return list({id(kernel): kernel for _, _, kernel in kernels()}.values())


def compiled():
    """Signatures for which something has been compiled, or loaded from the cache."""
    return sum(len(kernel.jit.signatures) for kernel in _distinct() if kernel.jit is not None)


@contextmanager
def interpreted():
    """All kernels that are imported by now run as Python."""
    with ExitStack() as stack:
        for one in _distinct():
            stack.enter_context(patch.object(one, "run", one.interpret))
        yield


def small():
    """A kernel that takes little to compile: (M, z, q, w) writes M z + q into w."""
    return multiply_add


def run_small(kernel):
    """(3,) what the small kernel writes."""
    out = np.zeros(3)
    kernel(np.eye(3), np.arange(3.0), np.ones(3), out)
    return out


def large():
    """A kernel that calls large ones, which it does not take in: (A, b, x, columns, tolerance) solves A x = b."""
    return solve_ranked


def anew(one):
    """The same kernel as in a new process."""
    return Kernel(one.function)


def is_compiled(one):
    """Whether compiled code of it has been made or loaded."""
    return one.jit is not None and bool(one.jit.signatures)


def loaded(one):
    """How many of its signatures came from the cache."""
    return sum(one.jit.stats.cache_hits.values())


@contextmanager
def automatic():
    """Kernels that are made anew decide for themselves when they compile, whatever the suite asks for."""
    with patch.object(compile_policy, "kernel_mode", lambda: "auto"):
        yield


@contextmanager
def impatient(least=0.0, instruction=0.0):
    """Compiling pays after so many seconds."""
    with (
        patch.object(compile_policy, "WAIT_AFTER_SECONDS", least),
        patch.object(compile_policy, "_SECONDS_PER_INSTRUCTION", instruction),
    ):
        yield


@contextmanager
def compiler_beside(cores=2):
    """A compiler beside this process, as in a new one on so many cores; it has ended after the block. Kernels look for
    what it compiles at every call.
    """
    one = background_compile._CompilerProcess()
    with (
        patch.object(background_compile, "_PROCESS", one),
        patch.object(background_compile, "_is_allowed", _allowed),
        patch.object(background_compile, "_usable_cores", lambda: cores),
        patch.object(compile_policy, "next_look", lambda spent: spent),
    ):
        try:
            yield one
        finally:
            one.end()


@contextmanager
def alone():
    """No other process compiles."""
    with patch.object(background_compile, "_is_allowed", lambda: False):
        yield


def is_locked():
    """Whether some process compiles into the cache now."""
    return background_compile._is_locked()


@contextmanager
def cached_in(folder):
    """Compiled code is kept there alone."""
    with (
        patch.dict("os.environ", {"HANDLCP_CACHE_DIR": str(folder)}),
        patch.object(folders, "cache_folders", folders.cache_folders.__wrapped__),
        patch.object(folders, "_unwritable_folders", {}),
    ):
        yield


def folder_of_cache():
    """Where compiled code goes now."""
    return folders.cache_folders()[0]


def said_afresh(monkeypatch, patience):
    """Nothing has been said yet; a line about waiting comes after so many seconds."""
    monkeypatch.setattr(compile_policy, "_announced", {})
    monkeypatch.setattr(compile_policy, "_SILENT_SECONDS", patience)


def mode(monkeypatch, word):
    """What HANDLCP_KERNELS with this word means."""
    monkeypatch.setenv("HANDLCP_KERNELS", word)
    return compile_policy.kernel_mode.__wrapped__()


def known_files():
    """The files whose contents the fingerprint stands for."""
    every = PACKAGE.rglob("*.py")
    return {f for f in every if b"\n@kernel" in f.read_bytes() or f.name in folders._CONSTANT_FILES}


def constants():
    """(file with kernels, name in capitals that it imports, file that it comes from) within the package."""
    for file in known_files():
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("handlcp."):
                source = PACKAGE.joinpath(*node.module.split(".")[1:]).with_suffix(".py")
                values = vars(importlib.import_module(node.module))
                for name in [a.name for a in node.names if a.name.isupper() and not callable(values[a.name])]:
                    yield file, name, source
