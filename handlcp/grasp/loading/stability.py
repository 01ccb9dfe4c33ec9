"""Whether a held object stays where it is: pushed a little, does it return?

A step takes the geometry of its contacts where it looks at them, and ends where springs and friction balance the load.
At the end of a path it ends where it looked. Looked at from a little beside that, it ends beside it by M times as much:
forces turn with contacts that are pushed aside, and the springs answer. Where M has an eigenvalue above 1, every look
leads further away: the springs do not hold what forces push on, as in a column that buckles. Power iteration finds it.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.loading.geometry import Where, between
from handlcp.grasp.loading.state import STILL, State
from handlcp.grasp.loading.step import Stepper

__all__ = ["STABLE", "growth", "last_stable"]

STABLE = 1.01  # growth up to which an object stays: one that may roll freely stays where it is pushed, which is 1
_PUSH = 1e-5  # of the contacts' radii, and in radians
_LOOKS, _FEW = 24, 2  # at most, and as many as are enough where a push comes to little
_REST = 6  # looks in which a state has to come to rest
_LITTLE, _SETTLED = 0.3, 0.02
_ELSEWHERE = 50.0  # times as far as pushed: that is another equilibrium


def last_stable(stepper: Stepper, states: list[State]) -> tuple[int, float, Array] | None:
    """The number of the last of a path's states that stays where it is, by bisection; the share of the step after it
    that it takes to reach a growth of 1; and the motion (6,) in which the object then leaves. None where the last state
    of all stays.
    """
    low, high, back = 0, len(states) - 1, 1
    value, motion = growth(stepper, states[high])
    while value != value and high > 0:  # NaN, as at the very end of a path that is lost: what is known a little before?
        high, back = max(high - back, 0), 2 * back
        value, motion = growth(stepper, states[high])
    if not value > STABLE or high == 0:
        return None
    below = np.nan
    while high - low > 1:
        middle = (low + high) // 2
        found, toward = growth(stepper, states[middle])
        if found > STABLE:
            high, value, motion = middle, found, toward
        else:
            low, below = middle, found
    share = (1.0 - below) / (value - below)
    return low, min(max(share, 0.0), 1.0) if share == share else 1.0, motion


def growth(stepper: Stepper, state: State) -> tuple[float, Array]:
    """By how much a small push grows from look to look: the largest eigenvalue of M, below 0 where a push swings back;
    and the object's motion (6,) in that push. 0 where contacts do not move, because then no force turns. NaN where it
    is not known: a push found no answer, or another equilibrium far away, or it swings.
    """
    geometry = stepper.geometry
    if not geometry.follows:
        return 0.0, STILL
    size = _PUSH * float(state.look.radius.min())
    if (still := _settled(stepper, state, size)) is None:
        return np.nan, STILL
    freedom = stepper.solver.laws.freedom  # in a plane, motions in it
    push = np.random.default_rng(0).normal(size=len(freedom)) @ freedom * ([size] * 3 + [_PUSH] * 3)
    pushed = geometry.moved(still.pose, push, state.look.reference, still.pose)[0]
    beside = Where(still.q, still.give, still.turn, pushed)
    last, length = np.inf, float(np.sqrt(push @ push))
    before = _between(stepper, still, beside)
    for count in range(1, _LOOKS + 1):
        if (end := stepper.settled(state, beside)) is None:
            break
        after = _between(stepper, still, end)
        grown, reached = float(after @ before / (before @ before)), float(np.sqrt(after @ after))
        if reached > _ELSEWHERE * length:
            break
        near = abs(grown) < _LITTLE and reached < _LITTLE * length and count >= _FEW
        if near or reached <= 1e-6 * length or abs(grown - last) <= _SETTLED * abs(grown):
            return grown, before[-6:]
        last, beside = grown, between(geometry, still, end, length / reached)
        before = _between(stepper, still, beside)
    return np.nan, STILL


def _settled(stepper: Stepper, state: State, size: float) -> Where | None:
    """Where the state ends if it is looked at again and again, to a hundredth of a push of this size [m]."""
    at = state.where
    for _ in range(_REST):
        if (end := stepper.settled(state, at)) is None:
            return None
        moved = _between(stepper, at, end)
        at = end
        if float(np.sqrt(moved @ moved)) <= 0.01 * size:
            return at
    return None


def _between(stepper: Stepper, a: Where, b: Where) -> Array:
    """All that differs: joints, pads and the object's pose."""
    displacement = stepper.geometry.displacement
    return np.concatenate(
        [b.q - a.q, (b.give - a.give).ravel(), b.turn - a.turn, displacement(b.pose) - displacement(a.pose)]
    )
