"""`property_doubts`: doubts about joints, their masses, limits and ranges; and about tendons."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.actuation.joint_stiffness import Elasticity
from handlcp.actuation.route import Pulley, Site
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.robot.joint import Doubt, JointFacts, Servo
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.mjcf_cable import spring_preload

# ----------------------------------------------------------------
# Doubts about what a file says of its joints one by one: efforts, couplings, axes, and the bodies that they move.

# An effort that all joints of a hand share is a placeholder if it is one of these numbers [N·m].
PLACEHOLDER_EFFORTS = frozenset(
    {1.0, 5.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 1000.0, 10000.0}
)
LARGEST_TORQUE, LARGEST_FORCE = 20.0, 1000.0  # [N·m, N] no joint of a finger has more


def joint_doubts(facts: Sequence[JointFacts], limits_given: Iterable[str] = ()) -> Iterator[Doubt]:
    """What is doubtful about the joints of a file.

    limits_given : joints whose torque limit was passed; what their efforts are doesn't matter.
    """
    given = set(limits_given)
    yield from _effort_doubts([f for f in facts if f.mimic is None and f.name not in given])
    yield from _coupling_doubts(facts)
    light = "a URDF with <inertial>; finger_weight=True counts this link as weightless"
    massless = [f for f in facts if math.isnan(f.mass)]
    yield from group_doubt(massless, "the link it moves has no <inertial>", light, about="mass")
    weightless = [f for f in facts if f.mass <= 0]
    yield from group_doubt(weightless, "the link it moves has a mass that is not positive", light, about="mass")
    for f in facts:
        length = 1.0 if f.axis is None else math.hypot(*f.axis)
        if not 0 < length < math.inf:
            what = "the axis is zero or no number: the joint moves nothing, or everything to NaN"
            yield Doubt(f.name, what, "a URDF with a unit axis", "serious", "axis")
        elif abs(length - 1) > 1e-3:
            yield Doubt(f.name, f"the axis has the length {length:.4g}", "a URDF with a unit axis", "minor", "axis")


def group_doubt(
    facts: Iterable[JointFacts], what: str, advice: str, severity: str = "minor", about: str = ""
) -> Iterator[Doubt]:
    """One doubt about all of these joints; none without joints."""
    if names := ", ".join(f.name for f in facts):
        yield Doubt(names, what, advice, severity, about)


def _effort_doubts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    """Of efforts that are unknown, and of numbers that are hardly those of a motor."""
    for which, these in (
        ("zero", [f for f in facts if f.effort == 0]),
        ("absent or infinite", [f for f in facts if not math.isfinite(f.effort)]),
        ("negative", [f for f in facts if f.effort < 0]),
    ):
        size = "force" if all(f.is_slide for f in these) else "torque"
        advice = f"torque_limits with the actuator's {size} [{_effort_unit(these)}]"
        yield from group_doubt(these, f"effort limit is {which}, read as unknown", advice, "serious", "limit unknown")
    efforts, unit = {f.effort for f in facts}, _effort_unit(facts)
    advice = f"torque_limits with the {'force' if unit == 'N' else 'torque'} of each actuator [{unit}]"
    if len(facts) > 1 and len(efforts) == 1 and efforts <= PLACEHOLDER_EFFORTS:
        what = f"every effort limit is {efforts.pop():g} {unit}: one round number for all joints is often a placeholder"
        yield from group_doubt(facts, what, advice, "serious", "torque limit")
        return
    large = defaultdict[tuple[float, bool], list[JointFacts]](list)
    for f in facts:
        if (LARGEST_FORCE if f.is_slide else LARGEST_TORQUE) < f.effort < math.inf:
            large[f.effort, f.is_slide].append(f)
    for (effort, slides), these in large.items():
        what = f"an effort limit of {effort:g} {words.effort_unit(slides)} is more than the joint of a finger has"
        yield from group_doubt(these, what, advice, "serious", "torque limit")
    alike = len(facts) > 1 and len(efforts) == 1 and not large
    if alike and 0 < (effort := efforts.pop()) < math.inf:
        what = f"every effort limit is {effort:g} {unit}, though joints of a hand seldom have equal motors"
        yield from group_doubt(facts, what, advice, "minor", "torque limit")


def _effort_unit(facts: Sequence[JointFacts]) -> str:
    return words.unit_of_joints(words.effort_unit, [f.is_slide for f in facts] or [False])


def _coupling_doubts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    right = [f for f in facts if f.mimic is not None and f.mimic.master == f.mimic.written_master]
    what = "follow other joints, as their tags say, and are no joints of their own"
    advice = "torque limits and stiffness for the joints they follow; describe() lists the factors"
    yield from group_doubt(right, what, advice, "information", "coupling")
    for f in facts:
        if (m := f.mimic) is None:
            continue
        if m.master is None:
            what = f"mimics {m.written_master!r}, which is no movable joint"
            yield Doubt(f.name, what, "a URDF whose <mimic> names a joint", "serious", "coupling")
        elif m.master != m.written_master:
            law = f"{m.multiplier:g} × {m.master} {m.offset:+g}"
            what = f"mimics {m.written_master!r}, which does not exist; read as {law}"
            own = "torque limits and stiffness belong to the joint it follows"
            advice = f"a URDF that names {m.master!r}, if that is meant; {own}"
            yield Doubt(f.name, what, advice, "minor", "coupling")


# ----------------------------------------------------------------
# Doubts about the ranges of joints: as written, and as narrowed by joints that follow.

_RANGE_ROUNDING = 1e-3  # of a joint's own range: less is rounding in the file


def range_doubts(facts: Sequence[JointFacts], kinematics: Kinematics | None = None) -> Iterator[Doubt]:
    """Of ranges; without kinematics, nothing of what joints that follow do to them."""
    for f in facts:
        severity = "serious"
        if f.kind == "continuous":
            continue
        if math.isnan(f.lower) or math.isnan(f.upper):
            what, advice = "position limits are absent or no numbers", "a URDF with <limit lower= upper=>"
        elif f.lower > f.upper:
            what = f"lower limit {f.lower:g} lies above the upper limit {f.upper:g}"
            advice = "a URDF with its limits in order"
        elif f.lower == f.upper:
            what = f"the joint cannot move: both limits are {_format_range_end(f.lower)}"
            advice, severity = "a URDF with a range, or a fixed joint", "serious" if f.mimic is None else "minor"
        elif not f.lower <= 0 <= f.upper and f.mimic is None:
            what = f"the neutral posture 0 lies outside the limits [{f.lower:g}, {f.upper:g}]"
            advice, severity = "q0 inside the limits (hand.neutral is)", "information"
        else:
            continue
        yield Doubt(f.name, what, advice, severity, "range")
    wide = (f for f in facts if f.kind == "revolute" and f.upper - f.lower >= 2 * math.pi)
    what = "the range is a full turn or more, wider than a finger's"
    yield from group_doubt(wide, what, "a URDF with the real limits", "minor", "range")
    if kinematics is not None:
        yield from _narrowed_range_doubts(facts, kinematics)


def _narrowed_range_doubts(facts: Sequence[JointFacts], kinematics: Kinematics) -> Iterator[Doubt]:
    """Of independent joints whose range is smaller than written, because a joint that follows reaches its end first."""
    own, advice = {f.name: f for f in facts}, "a URDF whose limits fit its <mimic> tags"
    for name, lower, upper in zip(kinematics.joint_names, kinematics.lower, kinematics.upper, strict=True):
        f = own[name]
        low, high = (f.lower, f.upper) if f.kind != "continuous" else (-math.inf, math.inf)
        if math.isnan(low) or math.isnan(high) or low > high:
            continue
        rounding = _RANGE_ROUNDING * (high - low) if math.isfinite(high - low) else 0.0  # [rad, m]
        if lower > upper:
            followers = _list_followers(facts, name)
            what = f"no position is within its own limits and those of the joints that follow it: {followers}"
            yield Doubt(name, what, advice, "serious", "range")
        elif lower > low + rounding or upper < high - rounding:
            by = f"by the limits of {_list_followers(facts, name)}"
            cut = f"its range [{low:.4g}, {high:.4g}] is narrowed to"
            what, severity = f"{cut} [{_format_range_end(lower)}, {_format_range_end(upper)}] {by}", "minor"
            if upper - lower <= rounding:
                what, severity = f"it cannot move: {cut} {_format_range_end(lower)} {by}", "serious"
            yield Doubt(name, what, advice, severity, "range")


def _format_range_end(value: float) -> str:
    """An end of a range, without the sign of zero."""
    return f"{value + 0.0:.4g}"


def _list_followers(facts: Sequence[JointFacts], master: str) -> str:
    """The joints that follow one, also through others."""
    found, grown = {master}, True
    while grown:
        more = {f.name for f in facts if f.mimic is not None and f.mimic.master in found} - found
        found, grown = found | more, bool(more)
    return ", ".join(f.name for f in facts if f.name in found - {master})


# ----------------------------------------------------------------
# Doubts about tendons: arms and places that are hardly in metres, and tendons that move nothing.

_MAX_ARM, _MAX_PLACE_DISTANCE = 0.2, 2.0  # [m] an arm at a joint that turns; a place from the frame of its link


def tendon_doubts(hand: Any) -> Iterator[Doubt]:
    """Of a hand that tendons move, as it is in its neutral posture."""
    kinematics = hand.kinematics
    stiffness = hand.stiffness.in_posture(kinematics, kinematics.neutral)
    if not isinstance(stiffness, TendonStiffness):
        return
    turns = np.array([name not in hand.sliding for name in hand.joint_names])
    arms = dict(zip(stiffness.names, abs(stiffness.arms), strict=True))
    longest = {name: float(row[turns].max(initial=0.0)) for name, row in arms.items()}
    away = dict[str, float]()
    for name, route in stiffness.routes.items():
        places = [p for p in route.places if not isinstance(p, Pulley)]
        points = [p.point if isinstance(p, Site) else p.placement[0] for p in places]
        away[name] = float(np.linalg.norm(points, axis=1).max())
    for what, most, lengths in (
        ("a moment arm of {:.3g} m", _MAX_ARM, longest),
        ("a place {:.3g} m from the frame of its link", _MAX_PLACE_DISTANCE, away),
    ):
        if long := {name: length for name, length in lengths.items() if length > most}:
            said = f"{what.format(max(long.values()))}, as if millimetres were taken for metres"
            yield Doubt(", ".join(long), said, "Tendons in metres", "serious", "tendon arms")
    if still := [name for name, row in arms.items() if not row.any()]:
        what = "moves no joint: all its moment arms are 0 in the neutral posture"
        yield Doubt(", ".join(still), what, "Tendons whose arms or routes reach over a joint", "minor", "tendon arms")


# ----------------------------------------------------------------
# Doubts about what a file states of drives: soft limits, servos, springs too weak, joints unlike their like.

_MIN_LEFT_OUT_SHARE = 1e-2  # of a range: a soft limit or a servo that leaves out less is not worth a word
_MAX_SAG = 1e-3  # [m] by its own weight
_UNLIMITED_FORCE = 1e30  # [N] a tendon that bears as much has no limit
_MOTION_ROUNDING = 1e-9  # of a motion of length 1: less is rounding
_MIN_SPRING_SHARE = 0.1  # of the torque limit: springs that pull with less are not worth a word
_MAX_WEAKER_SHARE = 0.5  # of the effort to the other side: with less, the direction matters
_MAX_FRICTION_SHARE = 0.25  # of the effort limit: no good drive has as much
_GRAVITY = 9.81  # [m/s²]
MIN_SLIDE_STIFFNESS = 200.0  # [N/m] a drive gives way by less than 5 mm under 1 N
_EQUAL_SHARE = 0.05  # of the larger number: less is rounding

# ---------------------------------------------------------------- One joint at a time.


def property_doubts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    """Of soft limits and servos that leave out a part of the range, and numbers that cannot be."""
    for f in facts:
        soft, servo, reduction = f.properties.soft_limits, f.properties.servo_range, f.properties.reduction
        if soft is not None and _is_range_cut(f, *soft):
            what = f"its soft limits [{soft[0]:.4g}, {soft[1]:.4g}] are narrower than its range, which is used"
            yield Doubt(f.name, what, "a URDF with the soft limits as <limit>, if they count", "minor", "range")
        if servo is not None and _is_range_cut(f, *servo):
            told = f"its actuator is told no more than [{servo[0]:.4g}, {servo[1]:.4g}]"
            what = f"{told}: the rest of its range is not reached"
            yield Doubt(f.name, what, "an MJCF file whose ctrlrange fits the range", "minor", "range")
        if not 0.0 <= f.properties.friction < math.inf:
            what = f"its dry friction is {f.properties.friction:g}, which is no number ≥ 0"
            advice = f"a file with the friction of the drive [{words.effort_unit(f.is_slide)}]"
            yield Doubt(f.name, what, advice, "minor", "friction")
        if reduction is not None and not 0.0 < abs(reduction) < math.inf:
            said = "no number" if math.isnan(reduction) else f"{reduction:g}"
            what = f"the reduction of its transmission is {said}"
            yield Doubt(f.name, what, "a file with turns of the motor for one of the joint", "minor", "gear")


def _is_range_cut(f: JointFacts, lower: float, upper: float) -> bool:
    """Whether a part of a range is narrower; equal ends are no limits, but a form that was not filled in."""
    if not lower < upper or not f.lower < f.upper or f.kind == "continuous":
        return False
    return max(lower - f.lower, f.upper - upper) > _MIN_LEFT_OUT_SHARE * (f.upper - f.lower)


def motor_doubts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    """Of friction that takes much of what the motor has; and of joints that are driven to one side alone, or much
    harder than to the other.
    """
    driven = [f for f in facts if f.mimic is None and f.effort < math.inf]
    if high := [f for f in driven if f.effort > 0.0 and f.properties.friction > _MAX_FRICTION_SHARE * f.effort]:
        worst = max(f.properties.friction / f.effort for f in high)
        what = f"dry friction of the file takes up to {words.format_percent(worst)} of the effort limit"
        yield from group_doubt(high, what, "a file with measured friction", "minor", "friction")
    alike = defaultdict[tuple[float, float, bool], list[JointFacts]](list)
    for f in driven:
        weaker = f.properties.weaker_effort
        if weaker is not None and weaker < _MAX_WEAKER_SHARE * f.effort:
            alike[weaker, f.effort, f.is_slide].append(f)
    for (weaker, effort, slides), these in alike.items():
        other = f"with {weaker:g} alone" if weaker else "not at all"
        what = (
            f"actuators of the file drive the joint with {effort:g} to one side and {other} to the other; the larger "
            "side is the limit for both, also where the joint closes to the other"
        )
        advice = f"torque_limits with what closes the hand [{words.effort_unit(slides)}]"
        yield from group_doubt(these, what, advice, "serious", "torque limit")


# ----------------------------------------------------------------
# Joints whose names differ by a side, a finger or a number alone should have equal motors. Thumbs are unlike fingers,
# and numbers along one finger count its joints, so that these are not compared.

_SIDE_WORD = re.compile(r"(?<![a-z])(left|right|lh|rh|l|r)(?![a-z])", re.IGNORECASE)
_FINGER_WORD = re.compile(r"(?<![a-z])(index|middle|ring|little|pinky|(?:ff|mf|rf|lf|if)(?=[_\d]|j\d))", re.IGNORECASE)
_NUMBER_WORD = re.compile(r"\d+")


def unequal_doubts(
    facts: Sequence[JointFacts], servos: Sequence[Servo], kinematics: Kinematics | None
) -> Iterator[Doubt]:
    """Of sides that differ, and of one among three or more like fingers that does."""
    efforts = {f.name: f.effort for f in facts if f.mimic is None and 0.0 < f.effort < math.inf}
    kp = {next(iter(s.arms)) if len(s.arms) == 1 else s.name: s.kp for s in servos}
    for what, advice, values in (("effort limit", "torque_limits", efforts), ("kp", "joint_stiffness", kp)):
        for names in _group_like_names(values, _SIDE_WORD, 2):
            if len(names) == 2 and not _is_equal(*(values[n] for n in names)):
                one, two = names
                said = f"{what} {values[one]:g} and {values[two]:g}, though they differ by their side alone"
                yield Doubt(f"{one}, {two}", said, f"{advice} by joint name", "minor", "unlike")
        for names in (*_group_like_names(values, _FINGER_WORD, 3), *_group_like_names(values, _NUMBER_WORD, 3)):
            odd = [n for n in names if sum(not _is_equal(values[n], values[m]) for m in names) == len(names) - 1]
            rest = [values[n] for n in names if n not in odd]
            alike = all(_is_equal(rest[0], value) for value in rest)
            if len(odd) == 1 and alike and _is_side_by_side(names, kinematics):
                said = f"{what} {values[odd[0]]:g}, where its like on other fingers have {rest[0]:g}"
                yield Doubt(odd[0], said, f"{advice} by joint name", "minor", "unlike")


def _group_like_names(values: Mapping[str, float], part: re.Pattern[str], least: int) -> list[list[str]]:
    """Names that are the same but for one such part, of `least` or more."""
    found = defaultdict[tuple[str, str], list[str]](list)
    for name in values:
        for at in part.finditer(name):
            found[name[: at.start()], name[at.end() :]].append(name)
    return [names for names in found.values() if len(names) >= least]


def _is_equal(one: float, two: float) -> bool:
    return abs(one - two) <= _EQUAL_SHARE * max(abs(one), abs(two))


def _is_side_by_side(names: Sequence[str], kinematics: Kinematics | None) -> bool:
    """Whether no joint carries another. A name of no joint is that of a tendon."""
    if kinematics is None:
        return False
    model = kinematics.model
    numbers = {model.getJointId(name) for name in names if model.existJointName(name)}
    return all(len(numbers & set(model.supports[j])) == 1 for j in numbers)


# ---------------------------------------------------------------- Springs too weak for a finger.


def sag_doubts(kinematics: Kinematics, tips: Sequence[tuple[str, int, Any]], compliance: Array) -> Iterator[Doubt]:
    """Of fingertips that sag by more than a millimetre under their own finger's weight, in the worst direction of
    gravity, in the neutral posture. tips : name, frame, point in it [m] or None. compliance (nv, nv).
    """
    if not tips:
        return
    model, q, C = kinematics.model, kinematics.neutral, kinematics.all_joints.C
    places, J = kinematics.frames_at(q, [frame for _, frame, _ in tips])
    J = J.copy()
    weight = np.column_stack([kinematics.gravity_torque(q, _GRAVITY * axis) for axis in np.eye(3)])
    support = np.zeros((len(tips), len(C)))
    for row, (_, frame, _) in zip(support, tips, strict=True):
        row[[model.joints[j].idx_v for j in model.supports[model.frames[frame].parentJoint] if j]] = 1.0
    moves = kinematics.find_moving_joints(support)
    sags = dict[str, float]()
    for (name, _, point), place, row, moved in zip(tips, places, support, moves, strict=True):
        own = np.flatnonzero(moved & (moves.sum(axis=0) == 1))
        p = place[:3, 3] if point is None else place[:3, :3] @ np.asarray(point) + place[:3, 3]
        tip = ((J[:3] + np.cross(J[3:], p, axis=0)) * row) @ C
        motion = tip[:, own] @ compliance[np.ix_(own, own)] @ weight[own]
        if (sag := float(np.linalg.norm(motion, 2)) if len(own) else 0.0) > _MAX_SAG:
            sags[name] = sag
    if sags:
        worst = list(sags)[words.first_largest_index(np.array(list(sags.values())))]
        far = words.format_length(sags[worst])
        what = f"kp of the file is so small that a finger's own weight moves its tip by {far} ({worst})"
        yield Doubt(", ".join(sags), what, "joint_stiffness as measured: stiffness_from", "minor", "stiffness")


def slide_doubts(kinematics: Kinematics, stiffness: Elasticity) -> Iterator[Doubt]:
    """Of slides as soft as no drive is: numbers of N·m/rad for N/m."""
    slides = {f.name for f in kinematics.facts if f.is_slide}
    try:
        own = np.diagonal(stiffness.stiffness_matrix).tolist() if slides else []
    except Unsupported:  # a transmission that leaves some joints loose
        return
    each = zip(kinematics.joint_names, own, strict=False)
    if soft := {name: k for name, k in each if name in slides and 0.0 < k < MIN_SLIDE_STIFFNESS}:
        least = min(soft.values())
        what = (
            f"joint stiffness of {least:g} N/m lets a slide give way by {words.format_length(1.0 / least)} under 1 N, "
            "as if N·m/rad were taken for N/m"
        )
        yield Doubt(", ".join(soft), what, "joint_stiffness of slides in N/m, 1e4 say", "serious", "slide")


# ---------------------------------------------------------------- Springs whose rest angle is far from the posture.


def spring_doubts(kinematics: Kinematics, stiffness: Elasticity, limits: Array) -> Iterator[Doubt]:
    """Of springs of the file that pull with much of what drives give in the middle of the range and are in no torque,
    and of joints that nothing but a spring holds. limits (nv,) torque limits [N·m].
    """
    joints = kinematics.joint_names
    if isinstance(stiffness, TendonStiffness):
        most = abs(stiffness.arms) * np.minimum(stiffness.cables.limits, _UNLIMITED_FORCE)[:, None]
        limits = np.minimum(limits, most.sum(axis=0))
    shares = abs(spring_preload(kinematics)) / np.where(limits > 0.0, limits, np.inf)
    shares[stiffness.springs_with_rest > 0.0] = 0.0
    if much := [name for name, share in zip(joints, shares, strict=True) if share > _MIN_SPRING_SHARE]:
        what = (
            f"springs of the file pull with up to {words.format_percent(float(shares.max()))} of what drives give "
            "in the middle of the range; torques and tensions here leave out what drives give against them"
        )
        yield Doubt(", ".join(much), what, "limits that are lower by that", "minor", "spring")
    turned = np.asarray((abs(stiffness.command_directions) > _MOTION_ROUNDING).any(axis=1))
    if idle := [name for name, turns in zip(joints, turned, strict=True) if not turns]:
        what = "no actuator turns it, and its spring is taken to be at rest in the posture of a grasp"
        yield Doubt(", ".join(idle), what, "postures with it where its spring is at rest", "minor", "spring")
