"""`close_fingertips`: joints bend from an open posture until what they move touches, and what lies beyond goes on.

All joints that bend turn at once. Where a link touches, the joints that carry it stop, because turning on would push it
into the object; the joints beyond it go on until their own links touch or their range ends. So a proximal link that
touches first lets the distal one wrap round, and a fingertip that touches first stops its whole finger.

Which joints bend, and which way: of each finger, its last joint and those with axes within 45° of that one's (the
others spread or oppose it), toward the object. Where tendons or synergies move them, as near to that as these can. Each
link is measured again when it could have arrived at the earliest: its gap over a bound of its speed (conservative
advancement: Mirtich 1996).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, check_array, check_keys, check_number, read_only
from handlcp.errors import InputError, NotReached
from handlcp.geometry.contact_detection import Proximity, nearest_proximity, search_nearest
from handlcp.geometry.distance import bounding_balls, shape_size
from handlcp.geometry.link_contacts import (
    ALL_LINKS,
    ContactBody,
    body_frames,
    check_outside,
    contact_bodies,
    nearest_links,
)
from handlcp.geometry.link_penetration import point_distances
from handlcp.geometry.mesh import object_advice
from handlcp.geometry.object import Object
from handlcp.geometry.shape import check_object_metres
from handlcp.hand.squeeze import read_by_tip
from handlcp.kinematics.joint_tree import contact_jacobian
from handlcp.robot.hand_model import HandModel, HandPosture

_MIN_BEND_COSINE = np.cos(np.pi / 4)
# Of its speed: a tip that nears the object more slowly does not say which way a finger bends
_MIN_APPROACH_SHARE = 0.05
_TOUCH_TOLERANCE = 1e-6  # [m]
_MIN_TIME_STEP = 1e-5  # of a unit of time: no step is shorter, and a step too far is taken back
_SLIDE_PER_RADIAN = 0.05  # [m] that a joint that slides moves while others turn by a radian
_LEVER_MARGIN = 1.5  # levers grow as fingers bend
_MAX_STEPS = 20_000


def wrap_hand(
    hand: HandModel, obj: Object, q0: Any = None, rates: Any = True, until: float = np.inf, called: str = "obj"
) -> Array:
    """The posture (nv,) of a hand that closes from q0 (None: `neutral`), in its ranges, until all links touch or stand.

    rates : True; or how fast each joint turns, a mapping by joint name (others: 0) or (nv,), with its sign.
    until : when all stop.
    called : the object, in messages.

    Raises NotReached where no link comes to touch; InputError, UnknownName.
    """
    if not isinstance(obj, Object):
        raise InputError(called, object_advice(obj), repr(obj)[:80])
    check_object_metres(called, obj, HandPosture(hand, hand.neutral).tip_positions)
    q = np.clip(hand.kinematics.read_posture("q0", hand.neutral if q0 is None else q0), hand.lower, hand.upper)
    links = contact_bodies(hand, ALL_LINKS)
    speed = bending_rates(hand, q, obj) if rates is True else _read_rates(rates, hand)
    closing = _WrapClosing(hand, links, obj, q, speed, until)
    closing.close()
    there = [(link, closing.link_proximity(k)[0].gap) for k, link in enumerate(links)]
    deepest, gap = min(there, key=lambda one: one[1])
    check_outside(called, deepest.name, gap)
    if not any(gap <= 10 * _TOUCH_TOLERANCE for _, gap in there):
        expected = "an object that links come to touch when the hand closes from q0"
        raise NotReached(called, expected, nearest_links(there))
    return read_only(closing.q)


def _read_rates(value: Any, hand: HandModel) -> Array:
    if isinstance(value, Mapping):
        named = check_keys("wrap", value, hand.joint_names, "a joint")
        return np.array([check_number(f"wrap[{j!r}]", named[j]) if j in named else 0.0 for j in hand.joint_names])
    return check_array("wrap", value, (hand.nv,), what="True, a mapping of joints to speeds, or a speed for each joint")


def bending_rates(hand: HandModel, q: Array, obj: Object) -> Array:
    """(nv,) ±1 of joints that bend fingers to the object, less of slides, 0 of others; of transmissions the nearest."""
    posture, speed, moves = HandPosture(hand, q), np.zeros(hand.nv), hand.moving_joints
    alone = moves.sum(axis=0) == 1
    turning = posture.angular_jacobian(hand.tips.numbers)
    for i in hand.tips.numbers:
        own = np.flatnonzero(moves[i] & alone) if (moves[i] & alone).any() else np.flatnonzero(moves[i])
        if not len(own):
            continue
        last, p = own[-1], posture.tip_positions[i]
        J = posture.jacobian_at(p[None], (i,))[0]
        way = obj.center_of_mass - p
        toward = way / max(float(np.linalg.norm(way)), 1e-12)
        if not turning[i, :, last].any():
            slides = [j for j in own if not turning[i, :, j].any()]
            speed[slides] = _SLIDE_PER_RADIAN * np.sign(toward @ J[:, slides])
            continue
        axes = turning[i][:, own] / np.maximum(np.linalg.norm(turning[i][:, own], axis=0), 1e-12)
        along = axes[:, -1] @ axes
        bends = own[abs(along) >= _MIN_BEND_COSINE]
        signs = np.sign(along[abs(along) >= _MIN_BEND_COSINE])
        nears = float((toward @ J[:, bends]) @ signs)
        if abs(nears) < _MIN_APPROACH_SHARE * float(np.linalg.norm(J[:, bends], axis=0).sum()):
            nears = float((hand.upper[bends] - q[bends] - q[bends] + hand.lower[bends]) @ signs)
        speed[bends] = signs * (1.0 if nears >= 0.0 else -1.0)
    if hand.stiffness.is_transmission:  # it moves its joints together
        commands = hand.stiffness.command_directions
        speed = commands @ (commands.T @ speed)
    return speed


class _LinkApproach(NamedTuple):
    """Where a link is, how fast it nears the object [m per unit of time], and when it could touch at the earliest."""

    near: Proximity
    speed: float
    earliest_touch: float


class _WrapClosing:
    """Joints at q that turn at `speed`; those that have stopped have speed 0."""

    def __init__(
        self, hand: HandModel, links: tuple[ContactBody, ...], obj: Object, q: Array, speed: Array, until: float
    ) -> None:
        self.hand, self.links, self.obj, self.q, self.speed, self.time = hand, links, obj, q.copy(), speed.copy(), 0.0
        self.until = until
        self.moves: Bools = hand.kinematics.find_moving_joints(np.array([t.support[0] for t in links]))
        self.balls = [bounding_balls([(s.geometry, s.rotation, s.translation) for s in t.shapes]) for t in links]
        self.sizes = [  # how far each link reaches from its frame, at most [m]
            max(float(np.linalg.norm(s.translation) + np.sqrt(3.0) * shape_size(s.geometry)) for s in t.shapes)
            for t in links
        ]
        C = hand.kinematics.coupling
        self.coupling = np.empty((0, 0)) if C is None else np.array(C)

    def close(self) -> None:
        """Turn the joints from touch to touch until nothing moves."""
        due = np.array([self._approach(k).earliest_touch for k in range(len(self.links))])
        for _ in range(_MAX_STEPS):
            self.speed[(self.speed != 0.0) & (self._range_left() <= 1e-12)] = 0.0
            if self.time >= self.until:
                self.speed[:] = 0.0
            moving = (self.moves & (self.speed != 0.0)).any(axis=1)
            if not moving.any():
                return
            due[~moving] = np.inf
            k, active = int(np.argmin(due)), self.speed != 0.0
            end = self.time + float((self._range_left()[active] / abs(self.speed[active])).min())  # of a joint's range
            end = min(end, self.until)
            if due[k] >= end:
                self._advance_to(end)
                continue
            before = self.time
            self._advance_to(max(float(due[k]), self.time + _MIN_TIME_STEP))
            near, nears, due[k] = self._approach(k)
            if near.gap <= _TOUCH_TOLERANCE and nears > 0.0:
                if near.gap < -_TOUCH_TOLERANCE:
                    self._step_back(k, before)
                self.speed[self.moves[k]] = 0.0
                due = np.array([self._approach(m).earliest_touch for m in range(len(self.links))])
        raise NotReached("obj", f"a hand that closes within {_MAX_STEPS} steps", {})

    def _advance_to(self, time: float) -> None:
        self.q = self.q + (time - self.time) * self.speed
        self.time = time

    def _step_back(self, k: int, before: float) -> None:
        """To when a link that has gone too far touched, by halving."""
        low, high = before, self.time
        while high - low > 1e-3 * _TOUCH_TOLERANCE:
            self._advance_to(0.5 * (low + high))
            near, _ = self.link_proximity(k)
            if abs(near.gap) <= _TOUCH_TOLERANCE:
                return
            low, high = (self.time, high) if near.gap > 0.0 else (low, self.time)

    def link_proximity(self, k: int) -> tuple[Proximity, Array]:
        """Where a link is nearest, of several shapes by balls around them; and where its frame is (3,)."""
        ((_, R, p),) = body_frames(HandPosture(self.hand, self.q), (self.links[k],))
        shapes = self.links[k].shapes
        if len(shapes) == 1:
            return nearest_proximity(shapes, p, R, self.obj), p
        (middles, radii), (Q, o) = self.balls[k], self.obj.frame
        away = point_distances((middles @ R.T + p - o) @ Q, self.obj)
        least = np.where(away > 0.0, away - radii, -np.inf)
        return search_nearest(least, lambda i: nearest_proximity(shapes[i : i + 1], p, R, self.obj)), p

    def _approach(self, k: int) -> _LinkApproach:
        """See there; a link that no joint moves now could touch never."""
        (near, p), active = self.link_proximity(k), self.moves[k] & (self.speed != 0.0)
        columns = self.hand.kinematics.frames_at(self.q, ())[1]
        support, axes = np.repeat(self.links[k].support, 2, axis=0), np.tile(np.eye(3), (2, 1, 1))
        points = np.array([near.tip_point, p])
        jacobians = contact_jacobian(columns.T, support, self.coupling, points, axes)
        at_point, at_frame = jacobians.reshape(2, 3, -1)
        nears = float(near.normal @ (at_point @ self.speed))
        if not active.any():
            return _LinkApproach(near, nears, np.inf)
        if near.gap <= _TOUCH_TOLERANCE:
            return _LinkApproach(near, nears, self.time if nears > 0.0 else self.time + 1e-3)
        levers = np.linalg.norm(at_frame, axis=0) + self.sizes[k]
        fastest = _LEVER_MARGIN * float(levers[active] @ abs(self.speed[active]))
        return _LinkApproach(near, nears, self.time + near.gap / fastest)

    def _range_left(self) -> Array:
        """(nv,) how far each joint may turn on."""
        return np.where(self.speed > 0.0, self.hand.upper - self.q, self.q - self.hand.lower)


# ----------------------------------------------------------------
# Closing the hand: each finger moves towards the object until its tip touches, within its joint ranges.


MAX_JOINT_STEP = 0.15  # of a joint in one iteration [rad, m]
MAX_ITERATIONS = 400
MAX_STALLED_ITERATIONS = 60  # iterations without progress before a finger counts as stuck
# [m/rad] if all joints of a finger move its tip along the surface only, they are bent by NUDGE
MIN_APPROACH_RATE = 1e-6
DEAD_POINT_NUDGE = 0.05  # [rad, m]


def close_fingertips(
    hand: HandModel, obj: Object, q0: Any = None, fingers: Any = None, squeeze: Any = 0.0, tolerance: float = 1e-6
) -> Array:
    """Flex fingers until their tips touch the object, as `Hand.close_on` documents.

    Each step is the smallest that closes the gap to first order, δq = gap · g / |g|² with g = nᵀ J, without the joints
    at the end of their range.
    """
    if not isinstance(obj, Object):
        raise InputError("obj", object_advice(obj), repr(obj)[:80])
    tolerance = check_number("tolerance", tolerance, above=0.0)
    tips = hand.tip_numbers("fingers", fingers)
    check_object_metres("obj", obj, HandPosture(hand, hand.neutral).tip_positions)
    depths = read_by_tip("squeeze", squeeze, [hand.fingertips[i] for i in tips]).tolist()
    q = np.clip(hand.kinematics.read_posture("q0", hand.neutral if q0 is None else q0), hand.lower, hand.upper)
    moves = hand.moving_joints
    alone = moves & (moves.sum(axis=0) == 1)
    pairs = zip(tips, depths, strict=True)
    all_fingers = [_ClosingFinger(hand, i, np.flatnonzero(alone[i]), depth) for i, depth in pairs]
    for _ in range(MAX_ITERATIONS):
        moving = [finger for finger in all_fingers if not finger.done]
        if not moving:
            break
        posture = HandPosture(hand, q.copy())
        for finger in moving:
            tip = finger.tip
            near = nearest_proximity(hand.tip_shapes(tip), posture.tip_positions[tip], posture.tip_rotations[tip], obj)
            J = posture.jacobian_at(near.tip_point[None], (tip,))[0][:, finger.joints]
            finger.step(q, near.gap + finger.depth, near.normal @ J, tolerance)
    if far := {hand.fingertips[f.tip]: f.gap for f in all_fingers if abs(f.gap) > tolerance}:
        expected = f"an object within reach of the fingers from q0 (touching within {tolerance * 1e6:.3g} µm)"
        expected += "".join([_describe_shared_joints(hand, hand.fingertips.index(name)) for name in far])
        lost = NotReached("obj", expected, far)
        lost.q = read_only(q)  # type: ignore[attr-defined]
        raise lost
    return read_only(q)


def _describe_shared_joints(hand: HandModel, tip: int) -> str:
    """Of a fingertip that no joint of its own moves: which others its joints move, too; "" of any other."""
    moves = hand.moving_joints
    others = [name for name, row in zip(hand.fingertips, moves, strict=True) if (row & moves[tip]).any()]
    own = moves[tip] & (moves.sum(axis=0) == 1)
    if own.any() or len(others) < 2:
        return ""
    others.remove(hand.fingertips[tip])
    return (
        f"; no joint moves {hand.fingertips[tip]} without {words.join_alternatives(others)}, so that they cannot be "
        "closed on the object one by one: close a hand with one fingertip a finger, or give the posture"
    )


class _ClosingFinger:
    """One finger that closes to a depth [m]; `done` once it is there, or is stuck, `gap` [m] away from there."""

    def __init__(self, hand: HandModel, tip: int, joints: Any, depth: float) -> None:
        self.tip, self.joints, self.depth = tip, joints, depth
        self.lower, self.upper = hand.lower[joints], hand.upper[joints]
        self.gap, self.longest = np.inf, MAX_JOINT_STEP
        self.smallest, self.stalled = np.inf, 0  # gap so far, and iterations since it last shrank
        self.done = False

    def step(self, q: Array, gap: float, rate: Array, tolerance: float) -> None:
        """Move this finger's joints in q. rate : by how much the gap shrinks per joint motion [m/rad]."""
        grown = abs(gap) > abs(self.gap)
        self.gap = gap
        self.longest = self.longest / 2 if grown else min(1.5 * self.longest, MAX_JOINT_STEP)
        if abs(gap) < 0.999 * self.smallest:
            self.smallest, self.stalled = abs(gap), 0
        else:
            self.stalled += 1
        self.done = abs(gap) <= tolerance or self.stalled > MAX_STALLED_ITERATIONS or not len(self.joints)
        if self.done:
            return
        at = q[self.joints]
        free = np.ones(len(at), dtype=bool)
        while True:  # until no joint would leave its range
            share = np.where(free, rate, 0.0)
            size = float(share @ share)
            if size <= MIN_APPROACH_RATE**2:
                if not free.all() or self.stalled:
                    self.done = True
                    return
                move = np.where(self.upper - at >= at - self.lower, DEAD_POINT_NUDGE, -DEAD_POINT_NUDGE)
                break
            move = gap * share / size
            blocked = free & (((at >= self.upper) & (move > 0)) | ((at <= self.lower) & (move < 0)))
            if not blocked.any():
                break
            free &= ~blocked
        largest = float(abs(move).max())
        if largest > self.longest:
            move *= self.longest / largest
        q[self.joints] = np.clip(at + move, self.lower, self.upper)
