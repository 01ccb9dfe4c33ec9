"""One decorator for every kernel, typed so that strict checks see through it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from handlcp.lcp.compiler.kernel import Kernel

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Run as Python at first and compiled where that pays, by itself or called from other kernels; see
    `handlcp.lcp.compiler.when`. Compiled code is kept on disk. Threads run it side by side.
    """
    return cast(F, Kernel(function))
