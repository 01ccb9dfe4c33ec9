"""What a contact does and how a path ends: the one numbering of both, for kernels and Python alike.

`Status` of a solve is in `lcp/problem.py`. Kernels take the numbers as constants, so a change of this file
compiles them anew.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum


class ContactStatus(IntEnum):
    """What a contact does. GLIDING pushes without friction, RESTING touches without pushing: laws tell these two apart,
    and answers count them as SLIDING and SEPARATED.
    """

    SEPARATED = 0
    STICKING = 1
    SLIDING = 2
    GLIDING = 3
    RESTING = 4
    UNKNOWN = 5  # there is no answer


SEPARATED, STICKING, SLIDING = ContactStatus.SEPARATED, ContactStatus.STICKING, ContactStatus.SLIDING
UNKNOWN = ContactStatus.UNKNOWN
_SHOWN = (SEPARATED, STICKING, SLIDING, SLIDING, SEPARATED, UNKNOWN)
_CONTACT_WORDS = {SEPARATED: "separated", STICKING: "sticking", SLIDING: "sliding", UNKNOWN: "unknown"}
_STATUS_OF_WORD = {word: status for status, word in _CONTACT_WORDS.items()}


def shown_statuses(codes: Iterable[int]) -> tuple[ContactStatus, ...]:
    """(n,) of each contact SEPARATED, STICKING, SLIDING or UNKNOWN, from any codes of `ContactStatus`."""
    return tuple([_SHOWN[code] for code in codes])


def contact_words(codes: Iterable[int]) -> tuple[str, ...]:
    """(n,) of each contact "separated", "sticking", "sliding" or "unknown", as public answers have it."""
    return tuple([_CONTACT_WORDS[_SHOWN[code]] for code in codes])


def contact_statuses(words: Iterable[str]) -> tuple[ContactStatus, ...]:
    """(n,) the statuses that the words of a public answer stand for."""
    return tuple([_STATUS_OF_WORD[word] for word in words])


class PathStatus(IntEnum):
    """How a path, or a step of it, ends.

    REACHED : the end of its program. LIMIT : a limit that was set, such as a joint's torque. UNBOUNDED : nothing ends
        it, however large the load.
    Lost, where no static state follows: RUNS_AWAY (each iterate ends farther on than the one before), UNSTABLE (a small
        push grows), PUSHED_OUT (by the squeeze), LOOSE (no finger holds the object), NO_FORCES (these fingers create no
        forces that balance the load), TOO_FAR (the object moves farther than a step may), LEAPS (the step jumps over a
        snap), JUMPS (a loaded object snaps, on a path to its load limit).
    Given up, which is never a limit: STUCK (forces balance the load, and no next state is found), CROSSES (a tendon
        goes over to the other side of a round body), SNAPS (where none is wanted), TOO_MANY_STEPS.
    """

    REACHED = 0
    LIMIT = 1
    UNBOUNDED = 2
    RUNS_AWAY = 10
    UNSTABLE = 11
    PUSHED_OUT = 12
    LOOSE = 13
    NO_FORCES = 14
    TOO_FAR = 15
    LEAPS = 16
    JUMPS = 17
    STUCK = 20
    CROSSES = 21
    SNAPS = 22
    TOO_MANY_STEPS = 23

    @property
    def is_lost(self) -> bool:
        """Whether the object is lost."""
        return PathStatus.RUNS_AWAY <= self <= PathStatus.JUMPS

    @property
    def is_given_up(self) -> bool:
        """Whether the path was given up, which says nothing about the object."""
        return self >= PathStatus.STUCK
