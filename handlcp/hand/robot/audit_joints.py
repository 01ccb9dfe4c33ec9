"""Doubts about joints: masses, limits that are placeholders, ranges that fingers cannot use; and about tendons."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.hand.elasticity.places import Pulley, Site
from handlcp.hand.elasticity.route import Route
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.robot.joints import Doubt, JointFacts
from handlcp.hand.robot.kinematics import Kinematics

# ----------------------------------------------------------------
# Doubts about what a file says of its joints one by one: efforts, couplings, axes, and the bodies that they move.

# An effort that all joints of a hand share is a placeholder if it is one of these numbers [N·m].
PLACEHOLDERS = frozenset({1.0, 5.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 1000.0, 10000.0})
LARGEST_TORQUE, LARGEST_FORCE = 20.0, 1000.0  # [N·m, N] no joint of a finger has more


def joint_doubts(facts: Sequence[JointFacts], limits_given: Iterable[str] = ()) -> Iterator[Doubt]:
    """limits_given : joints whose torque limit was passed; what their efforts are doesn't matter."""
    given = set(limits_given)
    yield from _efforts([f for f in facts if f.mimic is None and f.name not in given])
    yield from _couplings(facts)
    yield from _bodies(facts)


def together(
    facts: Iterable[JointFacts], what: str, advice: str, severity: str = "minor", about: str = ""
) -> Iterator[Doubt]:
    """One doubt about all of these joints; none without joints."""
    if names := ", ".join(f.name for f in facts):
        yield Doubt(names, what, advice, severity, about)


def _efforts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    unknown = ("serious", "limit unknown")
    for these, what in (
        ([f for f in facts if f.effort == 0], "effort limit is zero, read as unknown"),
        ([f for f in facts if not math.isfinite(f.effort)], "effort limit is absent or infinite, read as unknown"),
        ([f for f in facts if f.effort < 0], "effort limit is negative, read as unknown"),
    ):
        yield from together(these, what, f"torque_limits with {_of_actuator(these)} [{_unit(these)}]", *unknown)
    yield from _placeholders(facts)


def _unit(facts: Sequence[JointFacts]) -> str:
    """Of efforts of these joints."""
    return words.unit_of_joints(words.effort_unit, [f.slides for f in facts] or [False])


def _of_actuator(facts: Sequence[JointFacts]) -> str:
    slide = bool(facts) and all(f.slides for f in facts)
    return f"the actuator's {'force' if slide else 'torque'}"


def _placeholders(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    """Of efforts that are numbers, but hardly those of a motor."""
    efforts, unit = {f.effort for f in facts}, _unit(facts)
    size = "force" if unit == "N" else "torque"
    advice, serious = f"torque_limits with the {size} of each actuator [{unit}]", ("serious", "torque limit")
    if len(facts) > 1 and len(efforts) == 1 and efforts <= PLACEHOLDERS:
        what = f"every effort limit is {efforts.pop():g} {unit}: one round number for all joints is often a placeholder"
        yield from together(facts, what, advice, *serious)
        return
    large = [f for f in facts if (LARGEST_FORCE if f.slides else LARGEST_TORQUE) < f.effort < math.inf]
    for effort, slides in dict.fromkeys((f.effort, f.slides) for f in large):
        what = f"an effort limit of {effort:g} {words.effort_unit(slides)} is more than the joint of a finger has"
        yield from together([f for f in large if (f.effort, f.slides) == (effort, slides)], what, advice, *serious)
    alike = len(facts) > 1 and len(efforts) == 1 and not large
    if alike and 0 < (effort := efforts.pop()) < math.inf:
        what = f"every effort limit is {effort:g} {unit}, though joints of a hand seldom have equal motors"
        yield from together(facts, what, advice, "minor", "torque limit")


def _couplings(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    own = "torque limits and stiffness belong to the joint it follows"
    right = [f for f in facts if f.mimic is not None and f.mimic.master == f.mimic.written]
    what = "follow other joints, as their tags say, and are no joints of their own"
    advice = "torque limits and stiffness for the joints they follow; describe() lists the factors"
    yield from together(right, what, advice, "information", "coupling")
    for f in facts:
        m = f.mimic
        if m is None:
            continue
        law = f"{m.multiplier:g} × {m.master} {m.offset:+g}"
        if m.master is None:
            what = f"mimics {m.written!r}, which is no movable joint"
            yield Doubt(f.name, what, "a URDF whose <mimic> names a joint", "serious", "coupling")
        elif m.master != m.written:
            what = f"mimics {m.written!r}, which does not exist; read as {law}"
            advice = f"a URDF that names {m.master!r}, if that is meant; {own}"
            yield Doubt(f.name, what, advice, "minor", "coupling")


def _bodies(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    light = "a URDF with <inertial>; finger_weight=True counts this link as weightless"
    for these, what in (
        ([f for f in facts if math.isnan(f.mass)], "the link it moves has no <inertial>"),
        ([f for f in facts if f.mass <= 0], "the link it moves has a mass that is not positive"),
    ):
        yield from together(these, what, light, "minor", "mass")
    for f in facts:
        length = 1.0 if f.axis is None else math.hypot(*f.axis)
        if not 0 < length < math.inf:
            what = "the axis is zero or no number: the joint moves nothing, or everything to NaN"
            yield Doubt(f.name, what, "a URDF with a unit axis", "serious", "axis")
        elif abs(length - 1) > 1e-3:
            yield Doubt(f.name, f"the axis has the length {length:.4g}", "a URDF with a unit axis", "minor", "axis")


# ----------------------------------------------------------------
# Doubts about the ranges of joints: as written, and as narrowed by joints that follow.

_NARROWER = 1e-3  # of a joint's own range: less is rounding in the file


def range_doubts(facts: Sequence[JointFacts], kinematics: Kinematics | None = None) -> Iterator[Doubt]:
    """Of ranges; without kinematics, nothing of what joints that follow do to them."""
    for f in facts:
        if f.kind != "continuous":
            yield from _written(f)
    wide = (f for f in facts if f.kind == "revolute" and f.upper - f.lower >= 2 * math.pi)
    what = "the range is a full turn or more, wider than a finger's"
    yield from together(wide, what, "a URDF with the real limits", "minor", "range")
    if kinematics is not None:
        yield from _narrowed(facts, kinematics)


def _written(f: JointFacts) -> Iterator[Doubt]:
    severity = "serious"
    if math.isnan(f.lower) or math.isnan(f.upper):
        what, advice = "position limits are absent or no numbers", "a URDF with <limit lower= upper=>"
    elif f.lower > f.upper:
        what = f"lower limit {f.lower:g} lies above the upper limit {f.upper:g}"
        advice = "a URDF with its limits in order"
    elif f.lower == f.upper:
        what = f"the joint cannot move: both limits are {_end(f.lower)}"
        advice, severity = "a URDF with a range, or a fixed joint", "serious" if f.mimic is None else "minor"
    elif not f.lower <= 0 <= f.upper and f.mimic is None:
        what = f"the neutral posture 0 lies outside the limits [{f.lower:g}, {f.upper:g}]"
        advice, severity = "q0 inside the limits (hand.neutral is)", "information"
    else:
        return
    yield Doubt(f.name, what, advice, severity, "range")


def _narrowed(facts: Sequence[JointFacts], kinematics: Kinematics) -> Iterator[Doubt]:
    """Of independent joints whose range is smaller than written, because a joint that follows reaches its end first."""
    own = {f.name: f for f in facts}
    for name, lower, upper in zip(kinematics.joint_names, kinematics.lower, kinematics.upper, strict=True):
        f = own[name]
        low, high = (f.lower, f.upper) if f.kind != "continuous" else (-math.inf, math.inf)
        if math.isnan(low) or math.isnan(high) or low > high:
            continue
        if lower > upper:
            what = f"no position is within its own limits and those of the joints that follow it: {_who(facts, name)}"
            yield Doubt(name, what, "a URDF whose limits fit its <mimic> tags", "serious", "range")
        elif lower > low + _narrower(low, high) or upper < high - _narrower(low, high):
            by = f"by the limits of {_who(facts, name)}"
            cut = f"its range [{low:.4g}, {high:.4g}] is narrowed to"
            what, severity = f"{cut} [{_end(lower)}, {_end(upper)}] {by}", "minor"
            if upper - lower <= _narrower(low, high):
                what, severity = f"it cannot move: {cut} {_end(lower)} {by}", "serious"
            yield Doubt(name, what, "a URDF whose limits fit its <mimic> tags", severity, "range")


def _end(value: float) -> str:
    """An end of a range, without the sign of zero."""
    return f"{value + 0.0:.4g}"


def _narrower(low: float, high: float) -> float:
    """What is more than rounding of a range [rad, m]."""
    return _NARROWER * (high - low) if math.isfinite(high - low) else 0.0


def _who(facts: Sequence[JointFacts], master: str) -> str:
    """The joints that follow one, also through others."""
    found, grown = {master}, True
    while grown:
        more = {f.name for f in facts if f.mimic is not None and f.mimic.master in found} - found
        found, grown = found | more, bool(more)
    return ", ".join(f.name for f in facts if f.name in found - {master})


# ----------------------------------------------------------------
# Doubts about tendons: arms and places that are hardly in metres, and tendons that move nothing.

_LONGEST, _FARTHEST = 0.2, 2.0  # [m] an arm at a joint that turns; a place from the frame of its link


def tendon_doubts(hand: Any) -> Iterator[Doubt]:
    """Of a hand that tendons move, as it is in its neutral posture."""
    kinematics = hand.kinematics
    stiffness = hand.stiffness.at(kinematics, kinematics.neutral)
    if not isinstance(stiffness, TendonStiffness):
        return
    turns = np.array([name not in hand.sliding for name in hand.joint_names])
    arms = dict(zip(stiffness.names, abs(stiffness.arms), strict=True))
    longest = {name: float(row[turns].max(initial=0.0)) for name, row in arms.items()}
    away = {name: _away(route) for name, route in stiffness.routes.items()}
    advice = "Tendons in metres"
    for what, most, lengths in (
        ("a moment arm of {:.3g} m", _LONGEST, longest),
        ("a place {:.3g} m from the frame of its link", _FARTHEST, away),
    ):
        if long := [name for name, length in lengths.items() if length > most]:
            said = f"{what.format(max(lengths[name] for name in long))}, as if millimetres were taken for metres"
            yield Doubt(", ".join(long), said, advice, "serious", "tendon arms")
    if still := [name for name, row in arms.items() if not row.any()]:
        what = "moves no joint: all its moment arms are 0 in the neutral posture"
        yield Doubt(", ".join(still), what, "Tendons whose arms or routes reach over a joint", "minor", "tendon arms")


def _away(route: Route) -> float:
    """[m] The largest distance of a place from the frame of its link."""
    places = [p for p in route.places if not isinstance(p, Pulley)]
    points = [p.point if isinstance(p, Site) else p.placement[0] for p in places]
    return float(np.linalg.norm(points, axis=1).max())
