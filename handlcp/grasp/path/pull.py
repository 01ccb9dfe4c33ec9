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
    """What joints, posts and tendons do in a state. does : as `Joints` has it. posts (m,) : f [N]. drawn (t,) : d [N].
    tension (t,) : with which tendons pull [N], how much harder than at first where it is not known how hard that was.
    taut (t,) : the same as springs that could push, a.
    """

    does: Ints
    posts: Array
    drawn: Array
    tension: Array
    taut: Array

    @property
    def slack(self) -> Bools:
        """(t,) which of them hang through."""
        return np.asarray(self.tension > self.taut)


NO_PULL = Pull(np.zeros(0, dtype=np.int64), *[read_only(np.zeros(0))] * 4)
