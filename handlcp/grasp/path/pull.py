"""What is asked of joints and tendons in a step of a path, and what they do in a state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.grasp.model.cables import Cables


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

    def not_stored(self, cables: Cables | None, deflection: Array) -> float:
        """Energy that springs at joints and tendons have less for tendons that hang slack [J]. deflection (nv,) : of
        the joints from where they are commanded.
        """
        if cables is None or not self.slack.any():
            return 0.0
        k, more = cables.springs, self.tension - self.taut
        pushed = self.taut @ np.linalg.solve(k, self.taut) - self.tension @ np.linalg.solve(k, self.tension)
        return 0.5 * float(pushed + (cables.arms.T @ more) @ deflection)


NO_PULL = Pull(np.zeros(0, dtype=np.int64), *[read_only(np.zeros(0))] * 4)
