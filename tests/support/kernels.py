"""The package's compiled functions as a whole: which there are, and for how many types each has been compiled."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import ModuleType

from numba.core.dispatcher import Dispatcher

__all__ = ["compiled", "kernels"]


def kernels() -> Iterator[tuple[ModuleType, str, Dispatcher]]:
    """(module, name there, function) of every one; a function that several modules import comes several times."""
    for module in [m for name, m in sys.modules.items() if name.startswith("handlcp.")]:
        for name, value in list(vars(module).items()):
            if isinstance(value, Dispatcher):
                yield module, name, value


def compiled() -> int:
    """Signatures for which something has been compiled, or loaded from the cache."""
    functions = {id(kernel): kernel for _, _, kernel in kernels()}
    return sum(len(kernel.signatures) for kernel in functions.values())
