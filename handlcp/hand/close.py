"""Closing the hand: each finger moves along the shortest way to the object until it touches, within its joint
ranges.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.check import Array, number, read_only
from handlcp.errors import InputError, NotReached
from handlcp.hand.detect import nearest
from handlcp.hand.objects import Object

if TYPE_CHECKING:
    from handlcp.hand.hand import Hand

__all__ = ["close_on"]

LONGEST_STEP = 0.15  # of a joint in one iteration [rad, m]
ITERATIONS = 400
STALL = 60  # iterations without progress before a finger counts as stuck
DEAD_POINT = 1e-6  # [m/rad] a finger whose joints all move the tip along the surface: bend it a little


def close_on(
    hand: Hand,
    obj: Any,
    q0: Any,
    *,
    fingers: Sequence[str] | None = None,
    squeeze: float = 0.0,
    tolerance: float = 1e-6,
) -> Array:
    """Flex each finger from q0 until its tip touches the object; the posture (nv,), read-only. Deterministic.

    Only joints that move one fingertip alone take part, each within its range (q0 is moved into it first):
    Gauss–Newton steps δq = gap · g / |g|² with g = nᵀJ, joints at the end of their range left out. Only fingertips
    are looked at: links and the palm may pass.

    squeeze [m]: how far the tips end up inside the object (a preload). tolerance [m]: on the gap, at the end. Raises
    NotReached for fingers that end elsewhere: `gaps` by finger [m], and the posture reached as `q`.
    """
    if not isinstance(obj, Object):
        raise InputError("obj", "a Box, Sphere, Cylinder, Ellipsoid or Mesh", repr(obj))
    squeeze, tolerance = number("squeeze", squeeze, minimum=0.0), number("tolerance", tolerance, above=0.0)
    tips = hand.tip_numbers("fingers", fingers)
    q = np.clip(hand.kinematics.posture("q0", q0), hand.lower, hand.upper)
    moves = hand.moves
    alone = moves & (moves.sum(axis=0) == 1)
    open_fingers = [_Finger(hand, i, np.flatnonzero(alone[i])) for i in tips]
    for _ in range(ITERATIONS):
        state, going = hand.at(q), False
        for finger in open_fingers:
            if not finger.done:
                near = nearest(
                    hand.tip_shapes(finger.tip), state.tip_positions[finger.tip], state.tip_rotations[finger.tip], obj
                )
                J = state.jacobian_at(near.tip_point[None], (finger.tip,))[0][:, finger.joints]
                finger.step(q, near.gap + squeeze, near.normal @ J, tolerance)
                going |= not finger.done
        if not going:
            break
    far = {hand.fingertips[f.tip]: f.gap for f in open_fingers if abs(f.gap) > tolerance}
    if far:
        lost = NotReached(
            "obj", f"an object within reach of the fingers from q0 (touching within {tolerance * 1e6:.3g} µm)", far
        )
        lost.q = read_only(q)  # type: ignore[attr-defined]
        raise lost
    return read_only(q)


class _Finger:
    """One finger on its way."""

    def __init__(self, hand: Hand, tip: int, joints: Any) -> None:
        self.tip, self.joints = tip, joints
        self.lower, self.upper = hand.lower[joints], hand.upper[joints]
        self.gap, self.best, self.since, self.longest = np.inf, np.inf, 0, LONGEST_STEP
        self.done = False

    def step(self, q: Array, gap: float, rate: Array, tolerance: float) -> None:
        """Move this finger's joints in q; `rate` is what one radian of each takes off the gap [m/rad]."""
        grown = abs(gap) > abs(self.gap)
        self.gap = gap
        self.longest = self.longest / 2 if grown else min(1.5 * self.longest, LONGEST_STEP)
        if abs(gap) < 0.999 * self.best:
            self.best, self.since = abs(gap), 0
        else:
            self.since += 1
        self.done = abs(gap) <= tolerance or self.since > STALL or not len(self.joints)
        if self.done:
            return
        at = q[self.joints]
        free = np.ones(len(at), dtype=bool)
        while True:  # joints that would leave their range stay at its end
            share = np.where(free, rate, 0.0)
            size = float(share @ share)
            if size <= DEAD_POINT**2:
                if not free.all() or self.since:
                    self.done = True
                    return
                move = np.where(self.upper - at >= at - self.lower, 0.05, -0.05)
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
