"""The tests of makers, computed from a hand's file: an interval over what is not stated and what is doubted.

    fingertip   `finger_strength`, with the finger's bending joints at 20, 50 and 80 % of their ranges, where the
                posture is not stated
    pinch       `split_cylinder` between fingertips, 25 mm wide; friction 0.4, 0.6, 1.0
    power       `split_cylinder` with the whole hand, 50 mm wide unless said otherwise; friction 0.4, 0.6, 1.0
                (both across every split through the axis: makers do not say how theirs lies)
    payload     a cylinder of that width in a power grasp; friction 0.4, 0.6, 1.0

Torque limits count as they are in the file, and half and twice that where the audit doubts them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from handlcp.design.hardware.stated import FINGERTIP, PAYLOAD, PINCH, POWER, Stated
from handlcp.design.table.doubts import FRICTION, LEAST_FRICTION, MOST_FRICTION
from handlcp.errors import HandLCPError, InputError
from handlcp.hand.find.find import find_grasp
from handlcp.hand.hand import Hand
from handlcp.hand.objects.shapes import Cylinder, Sphere
from handlcp.hand.sites.wrap import bending
from handlcp.study.grip_strength.measure import split_cylinder
from handlcp.study.published.finger_strength import finger_strength

COMPUTED = (FINGERTIP, PINCH, POWER, PAYLOAD)
_SHARES = (0.2, 0.5, 0.8)  # of the ranges of bending joints
_WIDE, _NARROW = 0.05, 0.025  # [m]
_FRICTIONS = (LEAST_FRICTION, FRICTION, MOST_FRICTION)
_ROOM = 0.01  # of their ranges: as far from the ends other joints stay
_SEEN = 0.01  # [m] radius of what fingers close around, for the way they bend
_MASS = 0.2  # [kg] for which a payload's grasp is found


class Computed(NamedTuple):
    """low, high : the interval [N, kg]. nominal : with the file's limits, friction 0.6 and the middle posture. over :
    what it is an interval over, in words. limits : the least and the largest of the torque limits that count, as
    shares of those in the file.
    """

    low: float
    nominal: float
    high: float
    over: str
    limits: tuple[float, float]


def computed(hand: Hand, asked: Stated) -> Computed:
    """Raises InputError for a hand whose torque limits are not known, HandLCPError where nothing is gripped."""
    tips = asked.fingers or tuple(hand.fingertips)
    used = [j for j in range(hand.nv) if any(hand.moves[hand.tip_numbers("fingers", [tip])[0], j] for tip in tips)]
    if unknown := [hand.joint_names[j] for j in used if not np.isfinite(hand.torque_limits[j])]:
        raise InputError("hand", "torque limits in its file", f"none of {', '.join(unknown[:3])}")
    values = list(_fingertip(hand, tips[0]) if asked.test == FINGERTIP else _gripped(hand, asked))
    if not values:
        raise InputError("hand", "a grasp for this test", "none was found")
    over = f"postures from {_SHARES[0]:.0%} to {_SHARES[-1]:.0%} closed"
    if asked.test != FINGERTIP:
        over = f"friction {LEAST_FRICTION:g} to {MOST_FRICTION:g}"
        over += ", the split in any direction" if asked.test in (PINCH, POWER) else ""
    nominal, scales = values[len(values) // 2], [1.0]
    if any(doubt.about == "torque limit" for doubt in hand.audit().serious):
        scales, over = [0.5, 2.0], f"{over}, torque limits half to twice the file's"
    # Forces at a torque limit are in proportion to it; so is what grips are made of
    return Computed(min(scales) * min(values), nominal, max(scales) * max(values), over, (min(scales), max(scales)))


def _fingertip(hand: Hand, tip: str) -> list[float]:
    """The largest force [N] in each posture."""
    way = bending(hand, hand.neutral, Sphere(_SEEN, hand.at(hand.neutral).tip_positions.mean(axis=0)))
    room = _ROOM * (hand.upper - hand.lower)
    rest = np.clip(hand.neutral, hand.lower + room, hand.upper - room)
    start, end = np.where(way >= 0.0, hand.lower, hand.upper), np.where(way >= 0.0, hand.upper, hand.lower)
    closed = {f"{s:.0%}": np.where(way != 0.0, start + s * (end - start), rest) for s in _SHARES}
    return [row.force for row in finger_strength(hand, [tip], postures=closed).rows]


def _gripped(hand: Hand, asked: Stated) -> Iterator[float]:
    """Force [N] or mass [kg] with each friction with which there is a grasp."""
    wide = asked.diameter or (_NARROW if asked.test == PINCH else _WIDE)
    for friction in _FRICTIONS:
        try:
            if asked.test == PAYLOAD:
                found = find_grasp(hand, Cylinder(0.5 * wide, 3.0 * wide, mass=_MASS), kind=POWER, friction=friction)
                yield found[0].grasp.payload().mass
                continue
            fingers = asked.fingers if asked.test == PINCH and asked.fingers else None
            (grip,) = split_cylinder(hand, wide, friction=friction, grasps=(asked.test,), fingers=fingers).grips
            # Makers do not say how their split lies; across what nothing presses there is a force of rounding
            yield from (max(grip.least, 0.0), grip.force, grip.largest)
        except InputError:
            raise
        except HandLCPError:  # no grasp with this friction
            continue
