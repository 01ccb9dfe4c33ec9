"""`close_with_full_torque`: the hardest grip with which no joint is beyond its limit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, check_array, check_call, check_number, check_sequence
from handlcp.errors import HandLCPError, InputError, NoGraspFound, shorten_repr
from handlcp.geometry import Cylinder
from handlcp.geometry.shape import check_object_metres
from handlcp.grasp import Loading, Verdict
from handlcp.grasp.failure.failure_mode import (
    EQUILIBRIUM,
    OBJECT,
    UNDECIDED,
    FailureMode,
    StateLimits,
    find_binding,
    limit_shares,
    state_limits,
)
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.path.state import State
from handlcp.hand import Hand, HandGrasp, find_grasp
from handlcp.hand.torque_check import MIN_TORQUE_SHARE
from handlcp.lazy_property import lazy_property
from handlcp.progress import track_progress
from handlcp.robot.hand_model import HandModel
from handlcp.studies.grip_strength.result import ContactsAroundAxis, Grip, SplitCylinder

_SQUEEZE_ORDER, _FULL_ORDER = ("squeeze",), ("squeeze", "load")
_SEARCH_FACTOR = 1.25  # times the grip that small motions ask for: how far a path goes that looks for a limit
_MAX_ROUNDS = 4  # of paths, each from where the one before has led
_BACKOFF_FACTOR = 0.999  # of the last grip with which the object rests, where it is lost before a joint gives out
_TORQUE_MARGIN = 1e-7  # relative, by which the torque at the end stays below its limit
_BINDING_TOLERANCE = 1e-3  # relative: joints that are as near to their limits bind, too


@dataclass(frozen=True, eq=False)
class FullTorqueGrasp:
    """A grasp that is closed as hard as its joints can.

    grasp : as it is commanded then. path : how it is squeezed and loaded. binds : what gives out with a harder grip.
    says : the same in words.
    """

    grasp: HandGrasp
    path: Loading
    binds: tuple[FailureMode, ...]
    says: str

    @lazy_property
    def verdict(self) -> Verdict:
        """The word of `check()` on the grasp."""
        return self.grasp.check()


def require_torque_limits(hand: HandModel) -> None:
    """Raises InputError unless the torque of every joint is limited."""
    limits = zip(hand.joint_names, hand.torques.peak_limits, strict=True)
    if unknown := [name for name, most in limits if not np.isfinite(most)]:
        expected = "a hand with a torque limit for each joint: hand.replace(torque_limits=...)"
        raise InputError("hand", expected, f"none for {', '.join(unknown)}")


def close_with_full_torque(grasp: HandGrasp, force: Array, share: float) -> FullTorqueGrasp:
    """Close a grasp with the largest multiple of these grip forces that its joints can make.

    force (k,) : of the fingers [N]. share : of a torque limit that `force` needs where motions are small; there torques
    are proportional to the grip, and hand and object are followed from there.
    """
    limits, factor = state_limits(grasp.spec, nominal=grasp.state.q), 1.0 / share
    ends, lost = tuple[FailureMode, ...](), None
    for _ in range(_MAX_ROUNDS):
        path = grasp.replace(grip_force=_SEARCH_FACTOR * factor * force).follow(order=_SQUEEZE_ORDER)
        within, ends = _share_within_limits(limits, path)
        factor *= _SEARCH_FACTOR * within
        if ends or not path.reached:
            lost = path
            break
    if not ends:
        factor *= _BACKOFF_FACTOR
    for _ in range(_MAX_ROUNDS):
        made = grasp.replace(grip_force=factor * force)
        path = made.follow(order=_FULL_ORDER)
        most = largest_limit_share(limits, path.last)
        if most <= 1.0:
            break
        factor *= (1.0 - _TORQUE_MARGIN) / most
    if ends:
        return FullTorqueGrasp(made, path, ends, describe_failures(ends, grasp.spec))
    if lost is None or lost.outcome.is_given_up:
        says = "a harder grip was not followed to its end"
        return FullTorqueGrasp(made, path, (FailureMode(UNDECIDED, OBJECT),), says)
    why = lost.why.partition(": ")[2] or lost.why
    return FullTorqueGrasp(made, path, (FailureMode(EQUILIBRIUM, OBJECT),), f"a harder grip is not held: {why}")


def _share_within_limits(limits: StateLimits, path: Loading) -> tuple[float, tuple[FailureMode, ...]]:
    """The share of the squeeze up to which no joint is beyond a limit, and what is at one; () where none is."""
    states, shares = path.steps.states, path.steps.share
    most = np.array([largest_limit_share(limits, state) for state in states])
    over = np.flatnonzero(most > 1.0)
    if not len(over):
        return float(shares[-1]), ()
    k, share = int(over[0]), 0.0
    if k > 0:
        part = (1.0 - most[k - 1]) / (most[k] - most[k - 1])
        share = float(shares[k - 1] + part * (shares[k] - shares[k - 1]))
    return share, find_binding(limits, states[k].efforts, states[k].where.q, near=_BINDING_TOLERANCE)


def largest_limit_share(limits: StateLimits, state: State) -> float:
    """The largest share of a joint limit that is used in a state; 0 where none is known."""
    return float(np.nanmax(limit_shares(limits, state.efforts, state.where.q), initial=0.0))


# ----------------------------------------------------------------
# `split_cylinder`: a cylinder of two halves, in a pinch and in a power grasp closed with all the hand's torque.


POWER, PINCH = "power", "pinch"
_LENGTH_IN_DIAMETERS = 3.0  # diameters: a cylinder's length, unless said otherwise
_MAX_PINCH_GRASPS = 4  # pinch grasps that are closed, of which the strongest counts
_NO_GRAVITY = (0.0, 0.0, 0.0)


@check_call()
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
    wide = check_number("diameter", diameter, above=0.0)
    long = _LENGTH_IN_DIAMETERS * wide if length is None else check_number("length", length, above=0.0)
    both = '"power", "pinch", or both, in a sequence'
    grasps = check_sequence("grasps", grasps, both)
    if not grasps or not all(isinstance(kind, str) and kind in (POWER, PINCH) for kind in grasps):
        raise InputError("grasps", both, shorten_repr(grasps))
    split = None if normal is None else check_array("normal", normal, (3,))
    require_torque_limits(hand)
    cylinder = Cylinder(0.5 * wide, long, placement, mass=0.0)
    check_object_metres("diameter", cylinder, hand.at(hand.neutral).tip_positions)
    missing = dict[str, str]()

    def try_grip(kind: str, make: Callable[[], FullTorqueGrasp]) -> Grip | None:
        try:
            one = make()
            around, solution = _contacts_around_axis(one), one.path.solution
            n = around.closing_normal if split is None else split
            around.split_force(n)  # raises InputError for a normal along the axis
            return Grip(kind, n, one.binds, one.says, one.verdict.word, one.grasp, solution, around)  # type: ignore[arg-type]  # a hand's
        except InputError:
            raise
        except HandLCPError as error:
            missing[kind] = str(error)
            return None

    with track_progress("closing the hand on a split cylinder"):
        pinch = try_grip(PINCH, lambda: _close_pinch(hand, cylinder, friction, fingers)) if PINCH in grasps else None
        whole = placement is not None
        power = try_grip(POWER, lambda: _close_power(hand, cylinder, friction, whole)) if POWER in grasps else None
    if power is None and pinch is None:
        raise NoGraspFound("; ".join([f"no {kind} grasp: {why}" for kind, why in missing.items()]), {})
    return SplitCylinder(wide, long, power, pinch, missing)


def _close_pinch(hand: Hand, cylinder: Cylinder, friction: Any, fingers: Sequence[str] | None) -> FullTorqueGrasp:
    """Raises NoGraspFound, InputError, UnknownName."""
    found = find_grasp(hand, cylinder, friction=friction, gravity=_NO_GRAVITY, fingers=fingers)
    tried = []
    for candidate in list(found)[:_MAX_PINCH_GRASPS]:
        planned: Any = candidate.grasp.spec.asked
        share = float(np.nanmax(candidate.solution.torque_check.utilisation))
        if share == 0.0:  # it only touches: no torque is in proportion to nothing
            continue
        tried.append(close_with_full_torque(candidate.grasp, np.array(planned.grip_force), share))
        if tried[-1].binds[0].kind == UNDECIDED:  # a path that is given up has taken long, and so would the next
            break
    if not tried:
        raise NoGraspFound(f"of {len(found)} grasps none presses on the cylinder", {})
    return max(tried, key=lambda one: (one.verdict.ok, _contacts_around_axis(one).largest[0]))


def _close_power(hand: Hand, cylinder: Cylinder, friction: Any, placed: bool) -> FullTorqueGrasp:
    """All links that touch, every joint that bends closing with its torque limit. Raises NotReached, NoGraspFound."""
    if placed:
        closing: dict[str, Any] = {"links": "all", "closing_torque": hand.torques.peak_limits, "hold_object": True}
        grasp = hand.at(hand.neutral).grasp(cylinder, friction, gravity=_NO_GRAVITY, **closing)
    else:
        found = find_grasp(hand, cylinder, kind=POWER, friction=friction, gravity=_NO_GRAVITY)
        grasp = found[0].grasp.replace(closing_torque=hand.torques.peak_limits)
    path = grasp.follow(order=("squeeze",))
    return FullTorqueGrasp(grasp, path, (), _describe_released_torque(grasp, path.last.stretched))


def _describe_released_torque(grasp: Any, torque: Array) -> str:
    """What fingers hold of their torque, (nv,) [N·m], once the cylinder has been let go."""
    pulling, shares = grasp.mechanism.motor_pull(grasp.spec, torque)
    text, short = "every finger closes until a joint of it pulls with all its torque", pulling.weakest_joints(shares)
    if not short:
        return text
    least = words.format_percent(max(float(shares[short].min()), 0.0))
    few = f"{len(short)} of {len(pulling.finger_numbers)} keep less than {words.format_percent(MIN_TORQUE_SHARE)} of it"
    return f"{text}, but once the cylinder is let go {few}, down to {least}"


def _contacts_around_axis(one: FullTorqueGrasp) -> ContactsAroundAxis:
    """The contacts around the cylinder's axis, where it has come to."""
    target = one.grasp.target
    assert target is not None  # the cylinder
    (axes, middle), (turned, moved) = target.frame, one.path.last.where.pose
    return ContactsAroundAxis.from_solution(one.path.solution, turned @ axes[:, 2], turned @ middle + moved)
