"""Steps for an accuracy: twice as many until the answer changes by no more."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from handlcp.errors import Unsupported

MIN_STEP_RATIO = 1.6  # times as many steps: fewer than that tell nothing about the error
ERROR_SAFETY = 1.5  # times the change from half the steps, which is the error where it falls with the steps
_MAX_DOUBLINGS = 6  # times: no more steps for an accuracy

T = TypeVar("T")


def refine_until_converged(
    answer: Callable[[int], T], apart: Callable[[T, T], float], steps: Callable[[T], int], accuracy: float
) -> tuple[T, float]:
    """Double the steps until the answer is accurate: the answer, and its estimated relative error.

    That is the first answer whose error is estimated to be no more than `accuracy`, or the last one that is tried. The
    estimate comes from the change since an answer with about half the steps.

    answer : makes an answer with so many times as many steps.
    apart : relative difference of two answers.
    steps : that an answer took and that matter; hardly more than before where steps are short for other reasons.
    accuracy : relative error that will do.
    """
    last = found = answer(1)
    off = float("inf")
    for k in range(1, _MAX_DOUBLINGS + 1):
        found = answer(2**k)
        if steps(found) < MIN_STEP_RATIO * steps(last):
            continue
        off = ERROR_SAFETY * apart(last, found)
        if off <= accuracy:
            break
        last = found
    return found, off


def require_accuracy(off: float, accuracy: float, what: str) -> None:
    """Check that the estimated error of an answer is no more than the accuracy. Raises Unsupported.

    off, accuracy : relative.
    what : was found, in words, such as "the limit".
    """
    if off > accuracy:
        raise Unsupported(
            f"with {2**_MAX_DOUBLINGS} times as many steps {what} is still estimated to be off by {off:.2g}, more than "
            f"accuracy={accuracy:g}: ask for less, or the path branches where its steps are"
        )
