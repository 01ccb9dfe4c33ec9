"""Doubts about the ranges of joints: as written, and as narrowed by joints that follow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from handlcp.hand.robot.audit.joints import together
from handlcp.hand.robot.doubt import Doubt
from handlcp.hand.robot.joints import JointFacts
from handlcp.hand.robot.kinematics import Kinematics

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
        what = f"the joint cannot move: both limits are {f.lower:g}"
        advice, severity = "a URDF with a range, or a fixed joint", "minor"
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
            what = (
                f"its range [{low:.4g}, {high:.4g}] is narrowed to [{lower:.4g}, {upper:.4g}] by the limits of "
                f"{_who(facts, name)}"
            )
            yield Doubt(name, what, "a URDF whose limits fit its <mimic> tags", "minor", "range")


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
