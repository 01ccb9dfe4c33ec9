"""What is asked of joints and tendons in a step of a path, and what they do in a state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only


class Task(NamedTuple):
    """Of a step, (nv,) each: where joints are commanded to, and stood before it. drawn (t,) : d of tendons [N]; None
    while the hand is driven.
    """

    commanded: Array
    begun: Array
    drawn: Array | None


class Pull(NamedTuple):
    """What joints, posts and tendons do in a state.

    modes : (nv + m + t,) of joints and posts 0 where they stick, ±1 the way they slip; of tendons 1 where slack.
    post_friction : (m,) what each post takes of its tendon's tension [N].
    drawn : (t,) d, how far tendons are drawn in times their stiffness [N].
    tension : (t,) with which they pull [N], how much harder than at first where it is not known how hard that was.
    taut : (t,) the same of springs that could push, a [N].
    """

    modes: Ints
    post_friction: Array
    drawn: Array
    tension: Array
    taut: Array

    @property
    def slack(self) -> Bools:
        """(t,) which of them hang through."""
        return np.asarray(self.tension > self.taut)


NO_PULL = Pull(np.zeros(0, dtype=np.int64), *[read_only(np.zeros(0))] * 4)
