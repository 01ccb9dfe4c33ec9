"""`borrowed`: arrays that a kernel reads without owning them."""

from __future__ import annotations

from typing import TypeVar

T = TypeVar("T")


def borrowed(arrays: T) -> T:
    """An argument of a kernel, array or tuple of such, as read by that kernel alone. Compiled code counts who uses an
    array, each time that one is passed on or viewed, and does not count these. Nothing of them may be returned.
    """
    return arrays  # compiled code: `link`
