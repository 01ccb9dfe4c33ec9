"""`split_cylinder`: a cylinder of two halves, in a pinch and in a power grasp closed with all the hand's torque."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, array, number, several
from handlcp.errors import HandLCPError, InputError, NoGraspFound, shown
from handlcp.geometry import Cylinder
from handlcp.geometry.shape import check_object_metres
from handlcp.grasp.failure.failure_mode import UNDECIDED
from handlcp.hand import Hand, find_grasp
from handlcp.hand.torque_check import MIN_TORQUE_SHARE
from handlcp.keywords import helped
from handlcp.progress import told
from handlcp.study.grip_strength.across import Around
from handlcp.study.grip_strength.full_torque import Closed, ask_for_limits, closed
from handlcp.study.grip_strength.result import Grip, SplitCylinder

POWER, PINCH = "power", "pinch"
_LONG = 3.0  # diameters: a cylinder's length, unless said otherwise
_TRIED = 4  # pinch grasps that are closed, of which the strongest counts
_WEIGHTLESS = (0.0, 0.0, 0.0)


@helped()
def split_cylinder(
    hand: Hand,
    diameter: Any,
    *,
    length: Any = None,
    friction: Any = None,
    normal: Any = None,
    grasps: Sequence[str] = (POWER, PINCH),
    fingers: Sequence[str] | None = None,
    placement: Any = None,
) -> SplitCylinder:
    """The internal force [N] that a cylinder of two halves with a load cell between them measures in a power and in a
    pinch grasp, as in NIST's and ASTM's tests of grasp strength (NIST SP 1227, ASTM WK83863).

    diameter : of the cylinder [m]. length : [m]; None: three diameters. It weighs nothing. friction : of all contacts,
        as in `state.grasp`.
    normal : (3,) of the split, world axes; None: across which the contacts press most in all, from thumb or palm to
        the fingers. The forces across all other splits through the axis are in the answer, too.
    grasps : "power", "pinch", or both. fingers : names of those that pinch; None: all.
    placement : of the cylinder in the power grasp, its axis along z, for the hand that closes from its neutral posture;
        None: where `find_grasp` finds one.

    Pinch: the fingertips alone, where `find_grasp` places the cylinder. Of its best grasps, four at most, the one that
    presses hardest counts, of those that `check()` calls HELD if there are any. The grip, in the shares that it plans,
    grows until a joint is at its torque limit or the end of its range, hand and object followed; or the object is lost
    before, which is said. Power: the links wrap around the cylinder, and every joint closes with its torque limit.

    A hand that makes only one of the two has None for the other, with the reason in `missing`. Raises InputError,
    UnknownName; InputError for a hand whose torque limits are not all known; NoGraspFound where there is neither.
    """
    if not isinstance(hand, Hand):
        raise InputError("hand", "a Hand", repr(hand)[:80])
    wide = number("diameter", diameter, above=0.0)
    long = _LONG * wide if length is None else number("length", length, above=0.0)
    both = '"power", "pinch", or both, in a sequence'
    grasps = several("grasps", grasps, both)
    if not grasps or not all(isinstance(kind, str) and kind in (POWER, PINCH) for kind in grasps):
        raise InputError("grasps", both, shown(grasps))
    split = None if normal is None else array("normal", normal, (3,))
    ask_for_limits(hand)
    cylinder = Cylinder(0.5 * wide, long, placement, mass=0.0)
    check_object_metres("diameter", cylinder, hand.at(hand.neutral).tip_positions)
    missing = dict[str, str]()

    def made(kind: str, make: Callable[[], Closed]) -> Grip | None:
        try:
            return _grip(kind, make(), split)
        except InputError:
            raise
        except HandLCPError as error:
            missing[kind] = str(error)
            return None

    with told("closing the hand on a split cylinder"):
        pinch = made(PINCH, lambda: _pinched(hand, cylinder, friction, fingers)) if PINCH in grasps else None
        whole = placement is not None
        power = made(POWER, lambda: _wrapped(hand, cylinder, friction, whole)) if POWER in grasps else None
    if power is None and pinch is None:
        raise NoGraspFound("; ".join([f"no {kind} grasp: {why}" for kind, why in missing.items()]), {})
    return SplitCylinder(wide, long, power, pinch, missing)


def _pinched(hand: Hand, cylinder: Cylinder, friction: Any, fingers: Sequence[str] | None) -> Closed:
    """Raises NoGraspFound, InputError, UnknownName."""
    found = find_grasp(hand, cylinder, friction=friction, gravity=_WEIGHTLESS, fingers=fingers)
    tried = []
    for candidate in list(found)[:_TRIED]:
        planned: Any = candidate.grasp.spec.asked
        share = float(np.nanmax(candidate.solution.torque_check.utilisation))
        if share == 0.0:  # it only touches: no torque is in proportion to nothing
            continue
        tried.append(closed(candidate.grasp, np.array(planned.grip_force), share))
        if tried[-1].binds[0].kind == UNDECIDED:  # a path that is given up has taken long, and so would the next
            break
    if not tried:
        raise NoGraspFound(f"of {len(found)} grasps none presses on the cylinder", {})
    return max(tried, key=lambda one: (one.verdict.ok, _around(one).largest[0]))


def _wrapped(hand: Hand, cylinder: Cylinder, friction: Any, placed: bool) -> Closed:
    """All links that touch, every joint that bends closing with its torque limit. Raises NotReached, NoGraspFound."""
    if placed:
        state = hand.at(hand.neutral)
        grasp = state.grasp(
            cylinder,
            friction,
            gravity=_WEIGHTLESS,
            links="all",
            closing_torque=hand.torques.peak_limits,
            hold_object=True,
        )
    else:
        found = find_grasp(hand, cylinder, kind=POWER, friction=friction, gravity=_WEIGHTLESS)
        grasp = found[0].grasp.replace(closing_torque=hand.torques.peak_limits)
    path = grasp.follow(order=("squeeze",))
    return Closed(grasp, path, (), _left_of(grasp, path.last.stretched))


def _left_of(grasp: Any, torque: Array) -> str:
    """What fingers hold of their torque, (nv,) [N·m], once the cylinder has been let go."""
    pulling, shares = grasp.mechanism.motor_pull(grasp.spec, torque)
    text, short = "every finger closes until a joint of it pulls with all its torque", pulling.weakest_joints(shares)
    if not short:
        return text
    least = words.percent(max(float(shares[short].min()), 0.0))
    few = f"{len(short)} of {len(pulling.finger_numbers)} keep less than {words.percent(MIN_TORQUE_SHARE)} of it"
    return f"{text}, but once the cylinder is let go {few}, down to {least}"


def _around(one: Closed) -> Around:
    """The contacts around the cylinder's axis, where it has come to."""
    target = one.grasp.target
    assert target is not None  # the cylinder
    (axes, middle), (turned, moved) = target.frame, one.path.last.where.pose
    return Around.of(one.path.solution, turned @ axes[:, 2], turned @ middle + moved)


def _grip(kind: str, one: Closed, normal: Any) -> Grip:
    around, solution = _around(one), one.path.solution
    split = around.closing if normal is None else normal
    around.across(split)  # raises InputError for a normal along the axis
    return Grip(kind, split, one.binds, one.says, one.verdict.word, one.grasp, solution, around)  # type: ignore[arg-type]  # a hand's
