"""The search for power grasps: an object against the palm, and the whole hand closed round it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import wraps
from itertools import islice
from typing import Any, ParamSpec

import numpy as np

from handlcp.check import Array, Bools
from handlcp.geometry.link_contacts import ALL_LINKS, contact_bodies
from handlcp.geometry.link_penetration import find_penetrating_links
from handlcp.geometry.object import Object
from handlcp.grasp.batch.solve_many import solve_many
from handlcp.hand.closing import bending_rates
from handlcp.hand.find.candidate import Candidate, candidate_of
from handlcp.hand.find.chosen import Chooser, firmest
from handlcp.hand.find.clear import Links
from handlcp.hand.find.palm import LAID, Laid, laid, settled
from handlcp.hand.find.refused import skipping_refused
from handlcp.hand.hand import HandState
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.request import GraspRequest
from handlcp.hand.torque_closing import read_closing_torques
from handlcp.progress import report_progress
from handlcp.robot.hand_model import HandModel

SHARE, MOST = 0.5, 0.5  # of a joint's torque limit; [N·m], also where no limit is known
_AT_ONCE, _SOLVED = 12, 48  # closed exactly and solved: of a round, and in all
_FOLLOWED = 2  # grasps of a round that are followed with success, at most
_CHECKED = 6  # grasps that are checked, before those that only lie there
REACH = 4e-3  # [m] links no farther away may come to touch while the hand closes on what gives way
_DEEP = 1e-3  # [m] deeper in the object no link may be
P = ParamSpec("P")


def _none_where_refused(grasps: Callable[P, list[HandGrasp]]) -> Callable[P, list[HandGrasp]]:
    """No grasps where one cannot be made there."""

    @wraps(grasps)
    def made(*args: P.args, **kwargs: P.kwargs) -> list[HandGrasp]:
        with skipping_refused():
            return grasps(*args, **kwargs)
        return []

    return made


class PowerSearch(Chooser):
    """The search of one hand for one object.

    asked : what is passed on to `state.grasp`, closing_torque included.
    """

    def __init__(self, hand: HandModel, obj: Object, asked: Mapping[str, Any], seed: int) -> None:
        super().__init__(LAID)
        self._hand, self._obj, self._asked, self._seed = hand, obj, dict(asked), seed
        self._links, self._among = Links(hand, ()), contact_bodies(hand, ALL_LINKS)

    def run(self, tries: int) -> list[Candidate]:
        """The grasps that hold when they are checked and followed, the best first."""
        clear = self._links.out_of_each_other
        open_hands = laid(self._hand, self._obj, _coefficient(self._asked["friction"]), self._seed, clear)
        self.tried["laid"] = len(open_hands)
        enclosing = (one for one in open_hands if one.score > 0.0 and clear(one.closed))
        most = min(tries, _SOLVED)
        waiting, cradles = list[Candidate](), list[Candidate]()
        for tried in range(0, most, _AT_ONCE):
            some = list(islice(enclosing, min(tries, _AT_ONCE)))
            waiting = sorted([*waiting, *self._held(some)], key=lambda one: one.rank)
            last = not some or tried + _AT_ONCE >= most
            firm = [one for one in waiting if one.rank < 0.0 and (last or one.held_force > _load(one))]
            waiting = [one for one in waiting if one not in firm]  # one solve costs far less than to follow these
            found = self.followed(firm, self._checks(), _FOLLOWED)
            if firmest(found):
                return found
            cradles += found
            if not some:
                break
        if not cradles:
            cradles = self.followed(waiting, _FOLLOWED, _FOLLOWED)
        return sorted(cradles, key=lambda one: one.rank)

    def _checks(self) -> int:
        """How many more may be checked."""
        return max(_CHECKED - self.tried["checked"], 0)

    def _made(self, one: Candidate) -> Candidate | None:
        """With motors that have turned on until they pull with their torque: this costs more than to solve one. None
        where one solve of that is not held.
        """
        grasp = HandGrasp(one.grasp.spec.asked.spec())
        solution = grasp.solve(throw=False, proof=False)
        return candidate_of("power", grasp, solution) if solution.held else None

    def _is_sure(self, one: Candidate) -> bool:
        """Also of one that snaps on the way, and then settles: this costs less than to follow it in all directions."""
        return one.sure or one.settles

    def _enough(self, one: Candidate) -> float:
        """Its load."""
        return _load(one)

    def _held(self, some: list[Laid]) -> list[Candidate]:
        """The grasps of these that are clear and held."""
        grasps = list[HandGrasp]()
        for one in some:
            self.tried["tried"] += 1
            report_progress(f"{self.tried['tried']} placements tried")
            grasps += self._grasp(one)
        return self._solved(grasps)

    def _solved(self, grasps: list[HandGrasp]) -> list[Candidate]:
        """Those that one solve holds."""
        found = list[Candidate]()
        for grasp, solution in zip(grasps, solve_many(grasps, "cone", workers=1, proof=False), strict=True):
            if solution.held:
                found.append(candidate_of("power", grasp, solution))
        self.tried["held"] += len(found)
        return found

    def from_open(self, state: HandState, obj: Object, torque: Array) -> list[Candidate]:
        """The grasp of an open hand that closes on the object where it is, with this torque (nv,) [N·m], checked and
        followed; none where it does not hold.
        """
        return self.followed(self._solved(self._closed(state, obj, torque)), 1, 1)

    @_none_where_refused
    def _grasp(self, one: Laid) -> list[HandGrasp]:
        """The grasp of an open hand, or none where it does not enclose the object, or links are in each other."""
        place = settled(self._hand, self._among, self._obj, one)
        if place is None:
            return []
        self.tried["settled"] += 1
        state, obj = HandState(self._hand, place.q), place.of(self._obj)
        return self._closed(state, obj, self._torque(state, obj, one.closing))

    @_none_where_refused
    def _closed(self, state: HandState, obj: Object, torque: Array) -> list[HandGrasp]:
        asked = self._asked | {"closing_torque": torque, "links": ALL_LINKS, "hold_object": True, "max_gap": REACH}
        grasp = HandGrasp(GraspRequest(state, obj, **asked).spec_at_touch())
        if not encloses(self._hand, grasp):
            return []
        self.tried["enclosing"] += 1
        closed = HandState(self._hand, grasp.state.q)
        if not self._links.out_of_each_other(closed.q):
            return []
        if any(link.depth > _DEEP for link in find_penetrating_links(grasp.state, obj, grasp.state.hand.tips.numbers)):
            return []
        self.tried["clear"] += 1
        return [grasp]

    def _torque(self, state: HandState, obj: Object, closing: Bools) -> Array:
        """(nv,) [N·m] of the joints that close (nv,), positive towards the object: as asked, or by their limits."""
        way, asked = bending_rates(self._hand, state.q, obj), self._asked["closing_torque"]
        if asked is None:
            return np.where(closing & (way != 0.0), closing_by_limit(self._hand), 0.0)
        given = read_closing_torques(self._hand, way, asked)
        return np.where(way != 0.0, np.where(closing, np.sign(way) * given, 0.0), given)


def _load(one: Candidate) -> float:
    """[N] Its size."""
    return float(np.linalg.norm(one.grasp.spec.wrench[:3]))


def closing_by_limit(hand: HandModel) -> Array:
    """(nv,) [N·m] with which joints close where nothing else is said: half of what they can close with and hold for
    good, at most 0.5 N·m, or as much for each joint of those that are driven together.
    """
    C, least = hand.kinematics.coupling, np.minimum(hand.torque_limits, hand.torques.closing_limits)
    return np.minimum(SHARE * least, MOST * (1.0 if C is None else abs(C).sum(axis=0)))


def encloses(hand: HandModel, grasp: HandGrasp) -> bool:
    """Whether two links or more of fingers touch, and the palm, or links of two fingers or more on three sides."""
    of = grasp.state.hand.links_of_sites or ()
    by_name = {t.name: t for t in contact_bodies(hand, ALL_LINKS)}
    C, shared = hand.kinematics.coupling, hand.moving_joints.all(axis=0)
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
