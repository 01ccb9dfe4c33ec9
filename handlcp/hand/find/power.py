"""The search for power grasps: an object against the palm, and the whole hand closed round it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import islice
from typing import Any

import numpy as np

from handlcp.check import Array, Bools
from handlcp.errors import InputError, NotReached, Unsupported
from handlcp.grasp.batch.solve_many import solve_many
from handlcp.hand.asked.closing import closing_torques
from handlcp.hand.find.candidate import Candidate, candidate_of, followed_through
from handlcp.hand.find.clear import Links, Place
from handlcp.hand.find.palm import LAID, Laid, laid, settled
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.objects.inside import links_inside
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.model import HandModel
from handlcp.hand.sites.touchers import ALL, touchers
from handlcp.hand.sites.wrap import bending
from handlcp.hand.state import HandState
from handlcp.progress import tick

SHARE, LARGEST = 0.5, 0.5  # of a joint's torque limit; [N·m], also where no limit is known
HARDER = 1.0, 2.0  # times as much, in turn, where nothing is held
_AT_ONCE, _MOST = 12, 48  # closed exactly and solved: of a round, and in all
_FOLLOWED = 2  # grasps of a round that are followed with success, at most
_CHECKED = 12  # times that grasps are checked, before those that only lie there
_AGAIN = 3  # times that the hand closes again on an object that came to rest elsewhere than where it was laid
_WORTH = 0.5  # of the best: what holds no more is not followed any further
_REACH, _FARTHER = 4e-3, 12e-3  # [m] links no farther away may come to touch; where one farther away did
_DEEP = 1e-3  # [m] deeper in the object no link may be


class PowerSearch:
    """The search of one hand for one object; tried, refused : as of `Search` in `hand/find/find.py`.

    asked : what is passed on to `state.grasp`, closing_torque included.
    """

    def __init__(self, hand: HandModel, obj: Object, asked: Mapping[str, Any], seed: int) -> None:
        self._hand, self._obj, self._asked, self._seed = hand, obj, dict(asked), seed
        self._links, self._among = Links(hand, ()), touchers(hand, ALL)
        self.tried: Counter[str] = Counter(sampled=LAID)
        self.refused: list[Candidate] = []
        self._times = 1.0

    def run(self, tries: int) -> list[Candidate]:
        """The grasps that hold when they are checked and followed, the best first."""
        clear = self._links.out_of_each_other
        open_hands = laid(self._hand, self._obj, _coefficient(self._asked["friction"]), self._seed, clear)
        self.tried["laid"] = len(open_hands)
        enclosing = list(
            islice((one for one in open_hands if one.score > 0.0 and clear(one.closed)), min(tries, _MOST))
        )
        cradles = list[Candidate]()
        for times in HARDER if self._asked["closing_torque"] is None else HARDER[:1]:
            self._times, self.tried["times"] = times, int(times)
            found = self._closed(enclosing)
            if _best(found):
                return found
            cradles += found
            if not self.tried["clear"]:
                break
        return sorted(cradles, key=lambda one: one.rank)

    def _closed(self, open_hands: Sequence[Laid]) -> list[Candidate]:
        """The same, closed with one torque."""
        waiting, cradles, checked = list[Candidate](), list[Candidate](), self.tried["checked"]
        for k in range(0, len(open_hands), _AT_ONCE):
            some, last = open_hands[k : k + _AT_ONCE], k + _AT_ONCE >= len(open_hands)
            waiting = sorted([*waiting, *self._held(some)], key=lambda one: one.rank)
            firm = [one for one in waiting if one.rank < 0.0 and (last or one.held_force > _load(one))]
            waiting = [one for one in waiting if one not in firm]  # one solve costs far less than to follow these
            found = self._followed(firm, checked + _CHECKED)
            if _best(found):
                return found
            cradles += found
        return cradles or self._followed(waiting[:_FOLLOWED], checked + _CHECKED + _FOLLOWED)

    def _followed(self, some: Iterable[Candidate], most: int) -> list[Candidate]:
        """Those of some of which the check is sure, with what they hold when they are followed, the best first. One
        that holds as much as the load in every direction ends it, or `most` that are checked in all.
        """
        found = list[Candidate]()
        for one in some:
            if self.tried["checked"] >= most or len(found) >= _FOLLOWED or _best(found) > _load(one):
                break
            if (sure := self._sure(one)) is None:  # this costs less than to follow it in all directions
                self.refused.append(one)
                continue
            self.tried["followed"] += 1
            tick(f"following grasp {self.tried['followed']}")
            best = _best(found)
            if (held := followed_through(sure, _WORTH * best)) is not None:
                found.append(held)
            elif not best:
                self.refused.append(sure)
        return sorted(found, key=lambda one: one.rank)

    def _sure(self, one: Candidate) -> Candidate | None:
        """The grasp if its check is sure of it, or else one that is closed again where the object came to rest."""
        for _ in range(_AGAIN + 1):
            self.tried["checked"] += 1
            tick(f"checking grasp {self.tried['checked']}")
            if one.sure or one.settles:
                return one
            if not (anew := self._anew(one)):
                return None
            one = anew[0]
        return None

    def _anew(self, one: Candidate) -> list[Candidate]:
        """The hand opened and closed again, round the object where it came to rest when it was checked; with contacts
        on links farther away, where one had come into the object. Nothing where that is not held.
        """
        path = one.verdict.loading
        if path is None or not path.reached or path.object is None:
            return []
        max_gap = _FARTHER if one.verdict.about("link_inside") else None
        return self._solved(self._clear(lambda: one.grasp.replace(object=path.object, max_gap=max_gap)))

    def _held(self, some: Iterable[Laid]) -> list[Candidate]:
        """The grasps of these that are clear and held."""
        grasps = list[HandGrasp]()
        for one in some:
            self.tried["tried"] += 1
            tick(f"{self.tried['tried']} placements tried")
            if (place := settled(self._hand, self._among, self._obj, one)) is not None:
                self.tried["settled"] += 1
                grasps += self._clear(partial(self._closed_at, place, one.closing))
        return self._solved(grasps)

    def _solved(self, grasps: Sequence[HandGrasp]) -> list[Candidate]:
        """Those of them that one solve holds."""
        answers = solve_many(grasps, "cone", workers=1, proof=False)
        found = [candidate_of("power", *one) for one in zip(grasps, answers, strict=True) if one[1].held]
        self.tried["held"] += len(found)
        return found

    def _closed_at(self, place: Place, closing: Bools) -> HandGrasp:
        """The hand closed round the object. Raises InputError, NotReached, Unsupported."""
        state, obj = HandState(self._hand, place.q), place.of(self._obj)
        asked = self._asked | {"closing_torque": self._torque(state, obj, closing)}
        return state.grasp(obj, links=ALL, hold_object=True, max_gap=_REACH, **asked)

    def _clear(self, closed: Callable[[], HandGrasp]) -> list[HandGrasp]:
        """The grasp, or none where it does not enclose the object, or links are in each other or in the object."""
        try:
            grasp = closed()
        except (NotReached, Unsupported):
            return []
        except InputError as error:
            if error.argument not in ("target", "links"):  # a link deep in the object, or too many that touch
                raise
            return []
        if not encloses(self._hand, grasp):
            return []
        self.tried["enclosing"] += 1
        obj = grasp.target
        assert obj is not None
        if not self._links.out_of_each_other(grasp.state.q):
            return []
        if any(link.depth > _DEEP for link in links_inside(grasp.state, obj, grasp.state.hand.tips.every)):
            return []
        self.tried["clear"] += 1
        return [grasp]

    def _torque(self, state: HandState, obj: Object, closing: Bools) -> Array:
        """(nv,) [N·m] of the joints that close (nv,), positive towards the object: as asked, or by their limits."""
        way, asked = bending(self._hand, state.q, obj), self._asked["closing_torque"]
        if asked is None:
            return np.where(closing & (way != 0.0), closing_by_limit(self._hand, self._times), 0.0)
        given = closing_torques(self._hand, way, asked)
        return np.where(way != 0.0, np.where(closing, np.sign(way) * given, 0.0), given)


def _load(one: Candidate) -> float:
    """[N] Its size."""
    return float(np.linalg.norm(one.grasp.spec.wrench[:3]))


def _best(found: Iterable[Candidate]) -> float:
    """The largest force of those that are held in every direction [N]; 0 without any."""
    return max((one.held_force for one in found if one.rank < 0.0), default=0.0)


def closing_by_limit(hand: HandModel, times: float = 1.0) -> Array:
    """(nv,) [N·m] with which joints close where nothing else is said: half of the limit, at most 0.5 N·m, or so many
    times that, or as much for each joint of those that are driven together.
    """
    C = hand.kinematics.coupling
    return np.minimum(SHARE * hand.torque_limits, times * LARGEST * (1.0 if C is None else abs(C).sum(axis=0)))


def encloses(hand: HandModel, grasp: HandGrasp) -> bool:
    """Whether two links or more of fingers touch, and the palm, or links of two fingers or more on three sides."""
    of = grasp.state.hand.links_of_sites or ()
    by_name = {t.name: t for t in touchers(hand, ALL)}
    C, shared = hand.kinematics.coupling, hand.moves.all(axis=0)
    rows = {name: by_name[name].support[0] if C is None else by_name[name].support[0] @ abs(C) for name in set(of)}
    of_fingers = {name for name, row in rows.items() if ((row > 0.0) & ~shared).any()}
    if len(of_fingers) < 2:
        return False
    return len(of_fingers) < len(rows) or len(of_fingers) >= 3


def _coefficient(friction: Any) -> float:
    """Of a friction that was asked for, roughly."""
    if friction is None:
        return 0.6
    if isinstance(friction, (int, float)):
        return float(friction)
    return float(getattr(friction, "mu", 0.6))
