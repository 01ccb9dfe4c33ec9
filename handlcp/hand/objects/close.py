"""Closing the hand: each finger moves towards the object until its tip touches, within its joint ranges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, number, read_only
from handlcp.errors import InputError, NotReached
from handlcp.hand.objects.detect import nearest
from handlcp.hand.objects.meshes import what_to_pass
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import ask_for_metres
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.posture import Posture
from handlcp.hand.squeeze import by_tip

LONGEST_STEP = 0.15  # of a joint in one iteration [rad, m]
ITERATIONS = 400
STALL = 60  # iterations without progress before a finger counts as stuck
DEAD_POINT = 1e-6  # [m/rad] if all joints of a finger move its tip along the surface only, they are bent by NUDGE
NUDGE = 0.05  # [rad, m]


def close_on(
    hand: HandModel, obj: Object, q0: Any = None, fingers: Sequence[str] | None = None, squeeze: Any = 0.0,
    tolerance: float = 1e-6,
) -> Array:  # fmt: skip
    """See `Hand.close_on`. Each step is the smallest that closes the gap to first order, δq = gap · g / |g|² with
    g = nᵀ J, without the joints at the end of their range.
    """
    if not isinstance(obj, Object):
        raise InputError("obj", what_to_pass(obj), repr(obj)[:80])
    tolerance = number("tolerance", tolerance, above=0.0)
    tips = hand.tip_numbers("fingers", fingers)
    ask_for_metres("obj", obj, Posture(hand, hand.neutral).tip_positions)
    depths = by_tip("squeeze", squeeze, [hand.fingertips[i] for i in tips]).tolist()
    q = np.clip(hand.kinematics.posture("q0", hand.neutral if q0 is None else q0), hand.lower, hand.upper)
    moves = hand.moves
    alone = moves & (moves.sum(axis=0) == 1)
    all_fingers = [_Finger(hand, i, np.flatnonzero(alone[i]), depth) for i, depth in zip(tips, depths, strict=True)]
    for _ in range(ITERATIONS):
        moving = [finger for finger in all_fingers if not finger.done]
        if not moving:
            break
        posture = Posture(hand, q.copy())
        for finger in moving:
            tip = finger.tip
            near = nearest(hand.tip_shapes(tip), posture.tip_positions[tip], posture.tip_rotations[tip], obj)
            J = posture.jacobian_at(near.tip_point[None], (tip,))[0][:, finger.joints]
            finger.step(q, near.gap + finger.depth, near.normal @ J, tolerance)
    if far := {hand.fingertips[f.tip]: f.gap for f in all_fingers if abs(f.gap) > tolerance}:
        expected = f"an object within reach of the fingers from q0 (touching within {tolerance * 1e6:.3g} µm)"
        expected += "".join([_on_one_finger(hand, f.tip) for f in all_fingers if hand.fingertips[f.tip] in far])
        lost = NotReached("obj", expected, far)
        lost.q = read_only(q)  # type: ignore[attr-defined]
        raise lost
    return read_only(q)


def _on_one_finger(hand: HandModel, tip: int) -> str:
    """Of a fingertip that no joint of its own moves: which others its joints move, too; "" of any other."""
    moves = hand.moves
    others = [name for name, row in zip(hand.fingertips, moves, strict=True) if (row & moves[tip]).any()]
    own = moves[tip] & (moves.sum(axis=0) == 1)
    if own.any() or len(others) < 2:
        return ""
    others.remove(hand.fingertips[tip])
    return (
        f"; no joint moves {hand.fingertips[tip]} without {words.either(others)}, "
        "so that they cannot be closed on the object one by one: close a hand with one fingertip a finger, or give "
        "the posture"
    )


class _Finger:
    """One finger that closes: its joints, how deep it shall go, how far from there it is [m], whether it is done (it
    is there, or is stuck).
    """

    def __init__(self, hand: HandModel, tip: int, joints: Any, depth: float) -> None:
        self.tip, self.joints, self.depth = tip, joints, depth
        self.lower, self.upper = hand.lower[joints], hand.upper[joints]
        self.gap, self.longest = np.inf, LONGEST_STEP
        self.smallest, self.stalled = np.inf, 0  # gap so far, and iterations since it last shrank
        self.done = False

    def step(self, q: Array, gap: float, rate: Array, tolerance: float) -> None:
        """Move this finger's joints in q. rate : by how much the gap shrinks per joint motion [m/rad]."""
        grown = abs(gap) > abs(self.gap)
        self.gap = gap
        self.longest = self.longest / 2 if grown else min(1.5 * self.longest, LONGEST_STEP)
        if abs(gap) < 0.999 * self.smallest:
            self.smallest, self.stalled = abs(gap), 0
        else:
            self.stalled += 1
        self.done = abs(gap) <= tolerance or self.stalled > STALL or not len(self.joints)
        if self.done:
            return
        at = q[self.joints]
        free = np.ones(len(at), dtype=bool)
        while True:  # until no joint would leave its range
            share = np.where(free, rate, 0.0)
            size = float(share @ share)
            if size <= DEAD_POINT**2:
                if not free.all() or self.stalled:
                    self.done = True
                    return
                move = np.where(self.upper - at >= at - self.lower, NUDGE, -NUDGE)
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
