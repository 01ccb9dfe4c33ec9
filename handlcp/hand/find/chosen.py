"""What a search finds: grasps that the check is sure of, in the order of what they hold when they are followed.

What single solves hold in one posture says which grasps are worth following, no more: a path may end at a fifth of it,
where a contact that slips has rolled on, and the best grasp may be the eighth by single solves.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from handlcp.errors import Unsupported
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.find.held import followed
from handlcp.progress import report_progress

_LYING = 2  # grasps that are followed where none is known to hold more than what lies on it
_WORTH = 0.5  # of the best: what holds no more is not followed any further


class Chooser:
    """Of both kinds of search. tried : how many places, and grasps, came how far. refused : the grasps that one solve
    holds and the check does not, or not surely. found : those that were followed so far, in that order. rigid : why no
    grasp could be made of fingers that give way nowhere.
    """

    def __init__(self, sampled: int) -> None:
        self.tried: Counter[str] = Counter(sampled=sampled)
        self.refused: list[Candidate] = []
        self.found: list[Candidate] = []
        self.rigid: list[str] = []

    def checked(self, some: Sequence[Candidate], most: int) -> list[Candidate]:
        """Those from the first one on that the check is sure of; none where it is of none of the first so many."""
        for k, one in enumerate(some[:most]):
            if self._checked(one) is not None:
                return list(some[k:])
        return []

    def followed(self, some: Iterable[Candidate], most: int, follow: int, best: float = 0.0) -> list[Candidate]:
        """Those that the check is sure of, with what they hold when they are followed, the best first. At most so many
        are checked, and the first `follow` of which something is held are enough. What holds far less than the best so
        far, or than `best` [N], is left out, and what only lies there where there is one that holds.
        """
        found = list[Candidate]()
        for one in some:
            lies = one.rank >= 0.0
            if not most or len(found) >= (_LYING if lies else follow) or (lies and best) or best > self._enough(one):
                break
            most -= 1
            if (sure := self._checked(one)) is None:
                continue
            self.tried["followed"] += 1
            report_progress(f"following grasp {self.tried['followed']}")
            if (held := _followed(sure, _WORTH * best)) is not None:
                found.append(held)
                self.found.append(held)
                best = max(best, firmest([held]))
            elif not best:
                self.refused.append(sure)
        return sorted(found, key=lambda one: one.rank)

    def _checked(self, one: Candidate) -> Candidate | None:
        """The grasp that the check is sure of; None where it is not."""
        self.tried["checked"] += 1
        report_progress(f"checking grasp {self.tried['checked']}")
        made = self._made(one)
        if made is not None and self._is_sure(made):
            return made
        self.refused.append(made or one)
        return None

    def _made(self, one: Candidate) -> Candidate | None:
        """What is checked: the grasp itself."""
        return one

    def _is_sure(self, one: Candidate) -> bool:
        """Whether the check is."""
        return one.sure

    def _enough(self, one: Candidate) -> float:
        """[N] Where another one holds more, this one need not be followed."""
        return np.inf


def firmest(found: Iterable[Candidate]) -> float:
    """The largest force of those that are held in every direction [N]; 0 without any."""
    return max((one.held_force for one in found if one.rank < 0.0), default=0.0)


def _followed(one: Candidate, least: float) -> Candidate | None:
    """With what it holds when it is followed; None where that is not even the load, or no more than `least` [N]."""
    try:
        held = followed(one.grasp, least, one.patience)
    except Unsupported:
        return None
    if held is None:
        return None
    found = replace(one, held_force=held.force, cradled=held.cradled, gives_out=held.gives_out)
    found.__dict__["verdict"] = one.verdict  # known already, and long to find
    return found
