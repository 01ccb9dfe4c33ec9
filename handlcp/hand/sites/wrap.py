"""Closing the whole hand: joints bend from an open posture until what they move touches, and what lies beyond goes on.

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

from handlcp.check import Array, Bools, array, number, per_name, read_only
from handlcp.errors import InputError, NotReached
from handlcp.hand.objects.detect import Proximity, nearest, nearest_of
from handlcp.hand.objects.inside import distances
from handlcp.hand.objects.meshes import what_to_pass
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import ask_for_metres
from handlcp.hand.objects.solid import balls_of, size_of
from handlcp.hand.robot.kinematics import contact_jacobian
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.posture import Posture
from handlcp.hand.sites.sited import ask_for_outside, nearest_links, placed
from handlcp.hand.sites.touchers import ALL, Toucher, touchers

_BENDS = np.cos(np.pi / 4)
_PLAIN = 0.05  # of its speed: a tip that nears the object more slowly does not say which way a finger bends
_TOUCHES = 1e-6  # [m]
_LEAST = 1e-5  # of a unit of time: no step is shorter, and a step too far is taken back
_SLIDES = 0.05  # [m] that a joint that slides moves while others turn by a radian
_MARGIN = 1.5  # levers grow as fingers bend
_STEPS = 20_000


class Touched(NamedTuple):
    """A link that came to touch, and when: the angle [rad] by which bending joints had turned by then."""

    link: str
    at: float


class Wrapped(NamedTuple):
    """q (nv,) where the joints stopped, and the links in the order in which they touched."""

    q: Array
    touched: tuple[Touched, ...]


def wrap(
    hand: HandModel, obj: Object, q0: Any = None, rates: Any = True, until: float = np.inf, called: str = "obj"
) -> Wrapped:
    """From q0 (None: `neutral`), moved into the joints' ranges. rates : True; or how fast each joint turns, a mapping
    by joint name (others: 0) or (nv,), with its sign. until : when all stop. called : the object, in messages.

    Raises NotReached where no link comes to touch; InputError, UnknownName.
    """
    if not isinstance(obj, Object):
        raise InputError(called, what_to_pass(obj), repr(obj)[:80])
    ask_for_metres(called, obj, Posture(hand, hand.neutral).tip_positions)
    q = np.clip(hand.kinematics.posture("q0", hand.neutral if q0 is None else q0), hand.lower, hand.upper)
    links = touchers(hand, ALL)
    speed = bending(hand, q, obj) if rates is True else _given(rates, hand)
    closing = _Closing(hand, links, obj, q, speed, until)
    touched = closing.run()
    there = [(t, near.gap) for t, near in closing.final()]
    deepest, gap = min(there, key=lambda one: one[1])
    ask_for_outside(called, deepest.name, gap)
    if not any(gap <= 10 * _TOUCHES for _, gap in there):
        expected = "an object that links come to touch when the hand closes from q0"
        raise NotReached(called, expected, nearest_links(there))
    return Wrapped(read_only(closing.q), tuple(touched))


def _given(value: Any, hand: HandModel) -> Array:
    if isinstance(value, Mapping):
        named = per_name("wrap", value, hand.joint_names, "a joint")
        return np.array([number(f"wrap[{j!r}]", named[j]) if j in named else 0.0 for j in hand.joint_names])
    return array("wrap", value, (hand.nv,), what="True, a mapping of joints to speeds, or a speed for each joint")


def bending(hand: HandModel, q: Array, obj: Object) -> Array:
    """(nv,) ±1 of joints that bend fingers toward the object, less of those that slide; 0 of all others. Of tendons and
    synergies, what they make of that.
    """
    posture, speed, moves = Posture(hand, q), np.zeros(hand.nv), hand.moves
    alone = moves.sum(axis=0) == 1
    turning = posture.turning(hand.tips.every)
    for i in hand.tips.every:
        own = np.flatnonzero(moves[i] & alone) if (moves[i] & alone).any() else np.flatnonzero(moves[i])
        if not len(own):
            continue
        last, p = own[-1], posture.tip_positions[i]
        J = posture.jacobian_at(p[None], (i,))[0]
        toward = _toward(obj, p)
        if not turning[i, :, last].any():
            slides = [j for j in own if not turning[i, :, j].any()]
            speed[slides] = _SLIDES * np.sign(toward @ J[:, slides])
            continue
        axes = turning[i][:, own] / np.maximum(np.linalg.norm(turning[i][:, own], axis=0), 1e-12)
        along = axes[:, -1] @ axes
        bends = own[abs(along) >= _BENDS]
        signs = np.sign(along[abs(along) >= _BENDS])
        nears = float((toward @ J[:, bends]) @ signs)
        if abs(nears) < _PLAIN * float(np.linalg.norm(J[:, bends], axis=0).sum()):
            nears = float((hand.upper[bends] - q[bends] - q[bends] + hand.lower[bends]) @ signs)
        speed[bends] = signs * (1.0 if nears >= 0.0 else -1.0)
    if hand.stiffness.law[1]:  # a transmission moves its joints together
        commands = hand.stiffness.commands
        speed = commands @ (commands.T @ speed)
    return speed


def _toward(obj: Object, p: Array) -> Array:
    """(3,) direction from a point to the object's middle."""
    way = obj.center_of_mass - p
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-12))


class _Look(NamedTuple):
    """A link where it is: near, how fast it nears the object [m per unit of time], and the earliest time at which it
    could touch.
    """

    near: Proximity
    nears: float
    due: float


class _Closing:
    """Joints at q that turn at `speed`; those that have stopped have speed 0."""

    def __init__(
        self, hand: HandModel, links: tuple[Toucher, ...], obj: Object, q: Array, speed: Array, until: float
    ) -> None:
        self.hand, self.links, self.obj, self.q, self.speed, self.time = hand, links, obj, q.copy(), speed.copy(), 0.0
        self.until = until
        self.moves: Bools = hand.kinematics.moved_by(np.array([t.support[0] for t in links]))
        self.balls = [balls_of([(s.geometry, s.rotation, s.translation) for s in t.shapes]) for t in links]
        self.sizes = [  # how far each link reaches from its frame, at most [m]
            max(float(np.linalg.norm(s.translation) + np.sqrt(3.0) * size_of(s.geometry)) for s in t.shapes)
            for t in links
        ]
        C = hand.kinematics.coupling
        self.coupling = np.empty((0, 0)) if C is None else np.array(C)

    def run(self) -> list[Touched]:
        """Until nothing moves."""
        found = list[Touched]()
        due = np.array([self._look(k).due for k in range(len(self.links))])
        for _ in range(_STEPS):
            self._stop_at_ends()
            moving = (self.moves & (self.speed != 0.0)).any(axis=1)
            if not moving.any():
                return found
            due[~moving] = np.inf
            k, end = int(np.argmin(due)), self._first_end()
            if due[k] >= end:
                self._go(end)
                continue
            before = self.time
            self._go(max(float(due[k]), self.time + _LEAST))
            near, nears, due[k] = self._look(k)
            if near.gap <= _TOUCHES and nears > 0.0:
                if near.gap < -_TOUCHES:
                    self._back(k, before)
                found.append(Touched(self.links[k].name, self.time))
                self.speed[self.moves[k]] = 0.0
                due = np.array([self._look(m).due for m in range(len(self.links))])
        raise NotReached("obj", f"a hand that closes within {_STEPS} steps", {})

    def final(self) -> list[tuple[Toucher, Proximity]]:
        """Each link and how near it is."""
        return [(t, self._near(k, *self._frame(k))) for k, t in enumerate(self.links)]

    def _go(self, time: float) -> None:
        self.q = self.q + (time - self.time) * self.speed
        self.time = time

    def _back(self, k: int, before: float) -> None:
        """To when a link that has gone too far touched, by halving."""
        low, high = before, self.time
        while high - low > 1e-3 * _TOUCHES:
            self._go(0.5 * (low + high))
            near = self._near(k, *self._frame(k))
            if abs(near.gap) <= _TOUCHES:
                return
            low, high = (self.time, high) if near.gap > 0.0 else (low, self.time)

    def _frame(self, k: int) -> tuple[Array, Array]:
        """Rotation and position of a link's frame."""
        ((_, R, p),) = placed(Posture(self.hand, self.q), (self.links[k],))
        return R, p

    def _near(self, k: int, R: Array, p: Array) -> Proximity:
        """Where a link is nearest; of several shapes by balls around them."""
        shapes = self.links[k].shapes
        if len(shapes) == 1:
            return nearest(shapes, p, R, self.obj)
        (middles, radii), (Q, o) = self.balls[k], self.obj.frame
        away = distances((middles @ R.T + p - o) @ Q, self.obj)
        least = np.where(away > 0.0, away - radii, -np.inf)
        return nearest_of(least, lambda i: nearest(shapes[i : i + 1], p, R, self.obj))

    def _look(self, k: int) -> _Look:
        """See there; a link that no joint moves now could touch never."""
        R, p = self._frame(k)
        near, active = self._near(k, R, p), self.moves[k] & (self.speed != 0.0)
        at_point, at_frame = self._jacobian(k, np.array([near.tip_point, p]))
        nears = float(near.normal @ (at_point @ self.speed))
        if not active.any():
            return _Look(near, nears, np.inf)
        if near.gap <= _TOUCHES:
            return _Look(near, nears, self.time if nears > 0.0 else self.time + 1e-3)
        levers = np.linalg.norm(at_frame, axis=0) + self.sizes[k]
        fastest = _MARGIN * float(levers[active] @ abs(self.speed[active]))
        return _Look(near, nears, self.time + near.gap / fastest)

    def _jacobian(self, k: int, points: Array) -> Array:
        """(m, 3, nv) of points (m, 3) of a link, world axes."""
        columns = self.hand.kinematics.frames_at(self.q, ())[1]
        m = len(points)
        support, axes = np.repeat(self.links[k].support, m, axis=0), np.tile(np.eye(3), (m, 1, 1))
        return contact_jacobian(columns.T, support, self.coupling, points, axes).reshape(m, 3, -1)

    def _first_end(self) -> float:
        """When the next joint comes to the end of its range."""
        ends = np.where(self.speed > 0.0, self.hand.upper - self.q, self.q - self.hand.lower)
        active = self.speed != 0.0
        if not active.any():
            return self.time
        return min(self.time + float((ends[active] / abs(self.speed[active])).min()), self.until)

    def _stop_at_ends(self) -> None:
        ends = np.where(self.speed > 0.0, self.hand.upper - self.q, self.q - self.hand.lower)
        self.speed[(self.speed != 0.0) & (ends <= 1e-12)] = 0.0
        if self.time >= self.until:
            self.speed[:] = 0.0
