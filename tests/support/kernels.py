"""The package's kernels as a whole: which there are, for how many types each is compiled, and how to interpret them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import ModuleType
from unittest.mock import patch

from handlcp.lcp.compiler.kernel import Kernel

__all__ = ["compiled", "interpreted", "kernels"]


def kernels() -> Iterator[tuple[ModuleType, str, Kernel]]:
    """(module, name there, kernel) of every one; a kernel that several modules import comes several times."""
    for module in [m for name, m in sys.modules.items() if name.startswith("handlcp.")]:
        for name, value in list(vars(module).items()):
            if isinstance(value, Kernel):
                yield module, name, value


def _distinct() -> list[Kernel]:
    return list({id(kernel): kernel for _, _, kernel in kernels()}.values())


def compiled() -> int:
    """Signatures for which something has been compiled, or loaded from the cache."""
    return sum(len(kernel.jit.signatures) for kernel in _distinct() if kernel.jit is not None)


@contextmanager
def interpreted() -> Iterator[None]:
    """All kernels that are imported by now run as Python."""
    with ExitStack() as stack:
        for kernel in _distinct():
            stack.enter_context(patch.object(kernel, "run", kernel.interpret))
        yield
