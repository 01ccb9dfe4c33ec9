"""The audit: every doubt about the numbers in a URDF, and what to pass instead. A parser accepts all of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, overload

from handlcp import words
from handlcp.grasp.answer.verdict import Reason
from handlcp.hand.robot.doubt import Doubt
from handlcp.hand.robot.joints import JointFacts, joint_facts
from handlcp.hand.robot.source.xml import robot_of

__all__ = ["Audit", "audit_urdf", "doubts_of", "limit_reasons"]

# An effort that all joints of a hand share is a placeholder if it is one of these numbers [N·m].
PLACEHOLDERS = frozenset({1.0, 5.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 1000.0, 10000.0})
LARGEST_TORQUE, LARGEST_FORCE = 20.0, 1000.0  # [N·m, N] no joint of a finger has more


@dataclass(frozen=True, slots=True)
class Audit(Sequence[Doubt]):
    """The doubts about one hand; a sequence that is empty (false) when there are none, and prints as a table."""

    source: str
    doubts: tuple[Doubt, ...]

    @overload
    def __getitem__(self, index: int) -> Doubt: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Doubt, ...]: ...
    def __getitem__(self, index: int | slice) -> Doubt | tuple[Doubt, ...]:
        return self.doubts[index]

    def __len__(self) -> int:
        return len(self.doubts)

    def about(self, joint: str) -> tuple[Doubt, ...]:
        """The doubts that name a joint."""
        return tuple(d for d in self.doubts if joint in d.joint.split(", "))

    def __str__(self) -> str:
        if not self.doubts:
            return f"{self.source}: no doubts"
        many = "1 doubt" if len(self) == 1 else f"{len(self)} doubts"
        return "\n".join([f"{self.source}: {many}", *(f"  {d}" for d in self.doubts)])

    def __rich__(self) -> Any:
        from rich.table import Table

        table = Table(title=str(self).splitlines()[0], title_justify="left", show_lines=True)
        for heading in ("joint", "doubt", "what to pass instead"):
            table.add_column(heading, overflow="fold")
        for d in self.doubts:
            table.add_row(d.joint, d.what, d.advice)
        return table


def audit_urdf(path: Any, base: str | None = None) -> Audit:
    """Audit a URDF file (below link `base` if given) without building a hand from it.

    Raises URDFError for a file that is missing or not a URDF, UnknownName for an unknown base.
    """
    root, file, _ = robot_of("path", path, base)
    what = "a URDF has no place for joint stiffness"
    advice = "joint_stiffness: N·m/rad, a number, a mapping by joint name or a matrix"
    return Audit(
        file.name if file else str(root.get("name")), (*doubts_of(joint_facts(root)), Doubt("hand", what, advice))
    )


def doubts_of(facts: Sequence[JointFacts], limits_given: Iterable[str] = ()) -> tuple[Doubt, ...]:
    """The doubts about joints as written. limits_given : joints whose torque limit was passed; efforts don't count."""
    given = set(limits_given)
    asked = [f for f in facts if f.mimic is None and f.name not in given]
    return (*_efforts(asked), *_ranges(facts), *_couplings(facts), *_bodies(facts))


def _together(facts: Iterable[JointFacts], what: str, advice: str) -> Iterator[Doubt]:
    """One doubt about all of these joints; none without joints."""
    if names := ", ".join(f.name for f in facts):
        yield Doubt(names, what, advice)


def _efforts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    advice = "torque_limits with the actuator's torque [N·m]"
    yield from _together((f for f in facts if f.effort == 0), "effort limit is zero, read as unknown", advice)
    endless = [f for f in facts if not math.isfinite(f.effort)]
    yield from _together(endless, "effort limit is absent or infinite, read as unknown", advice)
    yield from _together((f for f in facts if f.effort < 0), "effort limit is negative, read as unknown", advice)
    yield from _placeholders(facts)


def _placeholders(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    """Of efforts that are numbers, but hardly those of a motor."""
    efforts, advice = {f.effort for f in facts}, "torque_limits with the torque of each actuator [N·m]"
    if len(facts) > 1 and len(efforts) == 1 and efforts <= PLACEHOLDERS:
        what = f"every effort limit is {efforts.pop():g} N·m: a placeholder, not a measurement"
        yield from _together(facts, what, advice)
        return
    most = {f.name: LARGEST_FORCE if f.kind == "prismatic" else LARGEST_TORQUE for f in facts}
    large = [f for f in facts if most[f.name] < f.effort < math.inf]
    for effort in dict.fromkeys(f.effort for f in large):
        what = f"an effort limit of {effort:g} is more than the joint of a finger has"
        yield from _together((f for f in large if f.effort == effort), what, advice)


def limit_reasons(facts: Sequence[JointFacts], limits_given: Iterable[str] = ()) -> Iterator[Reason]:
    """A warning for torque limits that the audit doubts; arguments as of `doubts_of`."""
    given = set(limits_given)
    for d in _placeholders([f for f in facts if f.mimic is None and f.name not in given]):
        joints = d.joint.split(", ")
        text = f"the torque limits of {words.listed(joints)} are doubtful: {d.what}; pass torque_limits"
        yield Reason("limit_doubtful", "warning", text, {"joints": joints})


def _ranges(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    for f in facts:
        if f.kind == "continuous":
            continue
        if math.isnan(f.lower) or math.isnan(f.upper):
            what, advice = "position limits are absent or no numbers", "a URDF with <limit lower= upper=>"
        elif f.lower > f.upper:
            what = f"lower limit {f.lower:g} lies above the upper limit {f.upper:g}"
            advice = "a URDF with its limits in order"
        elif f.lower == f.upper:
            what = f"the joint cannot move: both limits are {f.lower:g}"
            advice = "a URDF with a range, or a fixed joint"
        elif not f.lower <= 0 <= f.upper and f.mimic is None:
            what = f"the neutral posture 0 lies outside the limits [{f.lower:g}, {f.upper:g}]"
            advice = "q0 inside the limits (hand.neutral is)"
        else:
            continue
        yield Doubt(f.name, what, advice)
    wide = (f for f in facts if f.kind == "revolute" and f.upper - f.lower >= 2 * math.pi)
    what = "the range is a full turn or more, wider than a finger's"
    yield from _together(wide, what, "a URDF with the real limits")


def _couplings(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    own = "torque limits and stiffness belong to the joint it follows"
    for f in facts:
        m = f.mimic
        if m is None:
            continue
        law = f"{m.multiplier:g} × {m.master} {m.offset:+g}"
        if m.master is None:
            what = f"mimics {m.written!r}, which is no movable joint"
            advice = "a URDF whose <mimic> names a joint"
        elif m.master != m.written:
            what = f"mimics {m.written!r}, which does not exist; read as {law}"
            advice = f"a URDF that names {m.master!r}, if that is meant; {own}"
        else:
            what = f"a mimic joint (Pinocchio ignores the tag): q = {law} is built in, and it is no joint of its own"
            advice = own
        yield Doubt(f.name, what, advice)


def _bodies(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    light = "a URDF with <inertial>; finger_weight=True counts this link as weightless"
    yield from _together((f for f in facts if math.isnan(f.mass)), "the link it moves has no <inertial>", light)
    yield from _together((f for f in facts if f.mass <= 0), "the link it moves has a mass that is not positive", light)
    for f in facts:
        length = 1.0 if f.axis is None else math.hypot(*f.axis)
        if not 0 < length < math.inf:
            what = "the axis is zero or no number: the joint moves nothing, or everything to NaN"
            yield Doubt(f.name, what, "a URDF with a unit axis")
        elif abs(length - 1) > 1e-3:
            yield Doubt(f.name, f"the axis has the length {length:.4g}", "a URDF with a unit axis")
