"""The search for fingertip grasps: postures and placements in which all fingers touch an object and hold it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import permutations
from typing import Any

import numpy as np
import scipy

from handlcp.check import Array
from handlcp.contact.friction import SoftFinger
from handlcp.geometry.distance import bounding_box
from handlcp.geometry.link_penetration import point_distances
from handlcp.geometry.object import Object
from handlcp.grasp.batch.solve_many import solve_many
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.hand.find.candidate import Candidate, candidate_of
from handlcp.hand.find.chosen import Chooser, firmest
from handlcp.hand.find.clear import Links, Place, end_of, free_ranges, size_of_object
from handlcp.hand.find.refused import skipping_refused
from handlcp.hand.find.touch import RESERVE, Asked, Touch, brought_together, normal_forces
from handlcp.hand.hand import HandState
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.progress import report_progress
from handlcp.robot.hand_model import HandModel

# ----------------------------------------------------------------
# Where to begin: postures all over the joint ranges, with the object between their fingertips.
#
# At the weighted middle c of the tips p, Σ w (p - c) = 0: forces along the lines to c, with shares w |p - c|,
# balance. So a ball around c can be held from all sides. The axes of a longer object are laid along those of the
# tips' spread.

SAMPLES = 4096  # postures and placements that are compared
_TILT = 0.5  # [rad] of the object's axes against those of the tips' spread, at most, about each axis
_OUTSIDE = 5e-3  # [m] how far outside the object the middles of links should be
_LIGHTEST = 0.1  # the smallest weight of a fingertip beside the largest
_TURNS = np.array([np.eye(3)[:, list(p)] for p in permutations(range(3))])
_TURNS[:, :, 2] *= np.linalg.det(_TURNS)[:, None]  # the ways to lay one frame's axes along another's


def guesses(hand: HandModel, tips: tuple[int, ...], links: Links, obj: Object, keep: int, seed: int) -> list[Place]:
    """The `keep` samples whose fingertips come nearest to touching the object, the nearest first; alike for a seed."""
    count = len(tips)
    lower, upper = free_ranges(hand)
    draws = scipy.stats.qmc.Sobol(hand.nv + count + 4, rng=seed).random(SAMPLES)
    joints, weights, rest = np.split(draws, [hand.nv, hand.nv + count], axis=1)
    qs = lower + joints * (upper - lower)
    (frames, middles), ends = links.middles, [end_of(hand, tip) for tip in tips]
    frames = [*[hand.tips.frames[tip] for tip in tips], *frames]
    every = _points(hand, qs, frames, np.concatenate([[middle for middle, _ in ends], middles]))
    points = every[:, :count]
    weights = _LIGHTEST + (1.0 - _LIGHTEST) * weights
    weights /= weights.sum(axis=1, keepdims=True)
    centres = np.einsum("ki,kix->kx", weights, points)
    rotations = _laid(points - centres[:, None], weights, rest)
    middle = 0.5 * np.sum(bounding_box(obj.geometry), axis=0)
    local = np.einsum("kix,kxy->kiy", every - centres[:, None], rotations) + middle
    gaps = point_distances(local.reshape(-1, 3), obj).reshape(SAMPLES, -1)
    inside = np.minimum(gaps[:, count:] - _OUTSIDE, 0.0)
    gaps = gaps[:, :count] - np.array([radius for _, radius in ends])
    cost = (gaps**2).mean(axis=1) + (inside**2).sum(axis=1) / count
    best = np.argsort(cost, kind="stable")[:keep]
    return [Place(qs[k], rotations[k], centres[k] - rotations[k] @ middle) for k in best]


def _points(hand: HandModel, qs: Array, frames: list[int], within: Array) -> Array:
    """(m, k, 3) points of frames, `within` (k, 3) of each, in postures (m, nv); world axes [m]."""
    points = np.empty((len(qs), *within.shape))
    for k, q in enumerate(qs):
        at, _ = hand.kinematics.frames_at(q, frames)
        points[k] = np.einsum("ixy,iy->ix", at[:, :3, :3], within) + at[:, :3, 3]
    return points


def _laid(arms: Array, weights: Array, draws: Array) -> Array:
    """(m, 3, 3) rotations whose axes are those of the tips' spread, in any order and tilted a little, as draws (m, 4)
    in [0, 1) say. arms (m, k, 3) of the tips, with weights (m, k).
    """
    spread = np.einsum("ki,kix,kiy->kxy", weights, arms, arms)
    axes = np.linalg.eigh(spread)[1]
    axes[:, :, 2] *= np.sign(np.linalg.det(axes))[:, None]
    ways = _TURNS[np.minimum((draws[:, 0] * len(_TURNS)).astype(int), len(_TURNS) - 1)]
    tilts = scipy.spatial.transform.Rotation.from_rotvec(_TILT * (2.0 * draws[:, 1:] - 1.0)).as_matrix()
    return np.asarray(axes @ tilts @ ways)


# ----------------------------------------------------------------
# From places to grasps: touched, held by forces, clear of links, solved; and better ones nearby.

_AT_ONCE = 64  # places of a round; the next ones are tried where none of these is held
_MORE = 1  # rounds after the first in which something is held, where all that is held only lies on fingers
SOLVED = 16  # grasps of each round that are solved
_ROUNDS, _BEST, _NEARBY = 3, 2, 8  # of refinement, of how many grasps, and trials around each
_WIDER = (0.0, 0.25, 0.5, 1.0)  # how far around a place that is known
_JOINTS, _SHIFT, _TURN = 0.05, 0.1, 0.15  # their size: of the joint ranges, of the object's size, rad
_CHECKED, _FOLLOWED = 8, 4  # grasps of a round that are checked, and those of them that are followed with success
_RECHECKED = 2  # grasps of each round of refinement, which are checked and followed
_LEAST = 0.5  # of the load, shared by the fingers: what each presses with at least
_FIRM = 1.0  # [N] the load of an object that weighs less
_TORSIONS, _SOFT = (0.002, 0.005), 8  # [m] of soft fingers, and at how many places, where hard ones hold nothing


def place_of(grasp: HandGrasp) -> Place:
    """Where hand and object of a grasp are."""
    target = grasp.target
    assert target is not None  # the search had one
    R, o = target.frame
    return Place(np.array(grasp.state.q), np.array(R), np.array(o))


class Search(Chooser):
    """The search of one hand for one object.

    asked : what is passed on to `state.grasp`; without `squeeze` and `grip_force` each finger presses as planned.
    """

    def __init__(
        self, hand: HandModel, tips: tuple[int, ...], obj: Object, asked: Mapping[str, Any], seed: int
    ) -> None:
        super().__init__(SAMPLES)
        self._hand, self._tips, self._obj, self._asked, self._seed = hand, tips, obj, asked, seed
        self._home = obj.moved_to(np.zeros(3))
        self._links = Links(hand, tips)
        self._size = size_of_object(obj)
        self._limits: Asked | None = None
        self._touches: list[Touch] = []  # places where all fingers touch

    @property
    def fingers(self) -> list[str]:
        """Names of the fingertips that are to touch."""
        return [self._hand.fingertips[i] for i in self._tips]

    def run(self, tries: int) -> list[Candidate]:
        """The grasps that hold when they are checked and followed, the best first; and the better ones around them."""
        places = self.places(tries)
        found: list[Candidate] = []
        more = _MORE
        while places and more and not firmest(found):
            more -= bool(found)
            found += self.followed(self._settled(places[:_AT_ONCE]), _CHECKED, _FOLLOWED)
            places = places[_AT_ONCE:]
        rng = np.random.default_rng(self._seed)
        for k in range(_ROUNDS if found else 0):
            found.sort(key=lambda one: one.rank)
            best = [place_of(candidate.grasp) for candidate in found[:_BEST]]
            near = self._settled(self.nearby(place, rng, 0.5**k) for place in best for _ in range(_NEARBY))
            found += self.followed(near, _RECHECKED, _RECHECKED, firmest(found))
        return sorted(found, key=lambda one: one.rank)

    def from_place(self, place: Place) -> list[Candidate]:
        """The grasp that begins at this place, brought together and checked; where it does not hold, at the places
        around it, the nearer ones first; none where none of these holds either.
        """
        rng = np.random.default_rng(self._seed)
        for share in _WIDER:
            places = [self.nearby(place, rng, share) for _ in range(_NEARBY)] if share else [place]
            if found := self.checked(self._settled(places), _RECHECKED):
                return found
        return []

    @property
    def unheld(self) -> str:
        """Why nothing is held where all fingers touch, and what would hold, tried; "" where something is, or none
        touch.
        """
        if self.tried["held"] or not self.tried["touching"]:
            return ""
        if not self.tried["balanced"]:
            why = f"no forces within {100 * RESERVE:.0f} % of friction balance the load at any of these"
        elif not self.tried["clear"]:
            return "links are in each other at all of these"
        else:
            why = "one solve holds none of these"
        if not self._hard:
            return why
        if len(self._tips) == 2:
            why = f"{why}: two hard fingertips bear no moment about the line between them"
        for torsion in _TORSIONS:
            some, of = self._with_soft(torsion)
            if some:
                law = f"friction=SoftFinger({self._mu:g}, {torsion:g})"
                return f"{why}; with soft fingers, {law}, {some} of the {of} that were tried are held"
        return f"{why}, and soft fingers would not help, either"

    @property
    def _hard(self) -> bool:
        """Whether no fingertip bears a moment."""
        return self._limits is not None and not self._limits.levers.any()

    @property
    def _mu(self) -> float:
        """The least coefficient of the fingers."""
        return 0.0 if self._limits is None else float(self._limits.mu.min())

    def _with_soft(self, torsion: float) -> tuple[int, int]:
        """How many of the places that were tried first one solve holds with soft fingers, and of how many."""
        asked = self._limits
        if asked is None or self._mu == 0.0:
            return 0, 0
        law = SoftFinger(self._mu, torsion)
        soft = replace(asked, levers=np.full_like(asked.mu, law.lever), mu=np.full_like(asked.mu, law.mu))
        grasps, some = [], self._touches[:_SOFT]
        for touch in some:
            forces = normal_forces(touch, touch.place.of(self._obj).center_of_mass, soft)
            grasps += [] if forces is None else [g.replace(friction=law) for g in self._grasp(touch, forces)]
        return sum(one.held for one in solve_many(grasps, "cone", workers=1, proof=False)), len(some)

    def places(self, tries: int) -> list[Place]:
        """So many to begin with, the most promising first."""
        return guesses(self._hand, self._tips, self._links, self._home, tries, self._seed)

    def held(self, places: Iterable[Place]) -> list[tuple[HandGrasp, GraspSolution]]:
        """The grasps that begin at these places and are held by one solve, with it; those of the least effort first."""
        ready: list[tuple[float, Touch, Array]] = []
        for place in places:
            self.tried["tried"] += 1
            report_progress(f"{self.tried['tried']} placements tried")
            touch = brought_together(self._hand, self._tips, self._links, self._home, place)
            if touch is None:
                continue
            self.tried["touching"] += 1
            forces = normal_forces(touch, touch.place.of(self._obj).center_of_mass, self._holding(touch))
            self._touches.append(touch)
            if forces is None:
                continue
            self.tried["balanced"] += 1
            ready.append((self._effort(touch, forces), touch, forces))
        ready.sort(key=lambda one: one[0])
        grasps: list[HandGrasp] = []
        for _, touch, forces in ready:
            if len(grasps) < SOLVED and self._links.out_of_each_other(touch.place.q):
                self.tried["clear"] += 1
                grasps += self._grasp(touch, forces)
        solved = solve_many(grasps, "cone", workers=1, proof=False)
        found = [(grasp, solution) for grasp, solution in zip(grasps, solved, strict=True) if solution.held]
        self.tried["held"] += len(found)
        return found

    def nearby(self, place: Place, rng: np.random.Generator, share: float) -> Place:
        """A place drawn around this one, so many times as far away as usual."""
        lower, upper = free_ranges(self._hand)
        joints = share * _JOINTS * (upper - lower) * rng.standard_normal(len(lower))
        twist = share * np.repeat([_SHIFT * self._size, _TURN], 3) * rng.standard_normal(6)
        return place.moved(np.clip(place.q + joints, lower, upper) - place.q, twist)

    def _settled(self, places: Iterable[Place]) -> list[Candidate]:
        """The grasps that begin at these places and are held, the best first."""
        found = [candidate_of("pinch", grasp, solution) for grasp, solution in self.held(places)]
        return sorted(found, key=lambda one: one.rank)

    def _grasp(self, touch: Touch, forces: Array) -> list[HandGrasp]:
        """The grasp of a place, or none where no distance is confirmed there, or a finger is rigid."""
        asked = dict(self._asked)
        if asked["squeeze"] is None and asked["grip_force"] is None:
            asked["grip_force"] = forces
        with skipping_refused(self.rigid):
            return [HandState(self._hand, touch.place.q).grasp(touch.place.of(self._obj), **asked)]
        return []

    def _holding(self, touch: Touch) -> Asked:
        """What the contacts are to hold; read off the first grasp, which is made as any other."""
        if self._limits is None:
            bare = dict(self._asked, squeeze=None, grip_force=None)
            grasp = HandState(self._hand, touch.place.q).grasp(touch.place.of(self._obj), **bare)
            laws = [contact.friction for contact in grasp.spec.contacts]
            mu, levers = np.array([[law.mu * min(law.scale), law.lever] for law in laws]).T
            heavy = max(float(np.linalg.norm(grasp.spec.wrench[:3])), _FIRM)
            self._limits = Asked(grasp.spec.wrench, mu, levers, self._size, _LEAST * heavy / len(mu))
        return self._limits

    def _effort(self, touch: Touch, forces: Array) -> float:
        """What ranks places before they are solved: the largest share of a torque limit, or forces without limits."""
        torque = abs(touch.levers.T @ forces) / self._hand.torque_limits
        weakest = float(torque.max(initial=0.0))
        return weakest if weakest > 0.0 else float(forces.sum())
