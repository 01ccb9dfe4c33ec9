"""One decorator for every compiled kernel, typed so that strict checks see through it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

__all__ = ["kernel"]

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile with numba; the machine code is cached on disk, so only the first process ever pays for it."""
    return cast(F, numba.njit(cache=True, error_model="numpy")(function))
