"""Steps for an accuracy: twice as many until the answer changes by no more."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from handlcp.errors import Unsupported

__all__ = ["doubled", "insisted"]

_MOST = 6  # times: no more steps for an accuracy

T = TypeVar("T")


def doubled(answer: Callable[[int], T], apart: Callable[[T, T], float], accuracy: float) -> tuple[T, float]:
    """The first answer that is no farther from the one with half the steps than `accuracy`, or the last one that is
    tried; and how far it is.

    answer : with so many times as many steps. apart : how far two are from each other, relative.
    """
    last, off = answer(1), float("inf")
    for k in range(1, _MOST + 1):
        found = answer(2**k)
        off = apart(last, found)
        last = found
        if off <= accuracy:
            break
    return last, off


def insisted(off: float, accuracy: float, what: str) -> None:
    """Raises Unsupported where what `doubled` found is farther off. what : changes, such as "the limit"."""
    if off > accuracy:
        raise Unsupported(
            f"with {2**_MOST} times as many steps {what} still changes by {off:.2g}, more than accuracy={accuracy:g}: "
            "the path branches where its steps are"
        )
