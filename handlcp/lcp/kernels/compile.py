"""One decorator for every compiled kernel, typed so that strict checks see through it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

__all__ = ["kernel"]

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile with numba; cached on disk, so that only the first process ever pays for it. Threads run them side by
    side.
    """
    return cast(F, numba.njit(cache=True, error_model="numpy", nogil=True)(function))
