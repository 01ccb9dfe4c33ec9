"""The audit: every doubt about the numbers in a URDF, and what to pass instead. Nothing here trusts a parser's
silence.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, overload

from handlcp.hand.joints import JointFacts, joint_facts
from handlcp.hand.urdf import read_urdf

__all__ = ["Audit", "Doubt", "audit_urdf", "doubts_of"]

# An effort this large on every joint of a hand is a placeholder even if it is no round number [N·m].
PLACEHOLDERS = frozenset({1.0, 5.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 1000.0, 10000.0})


@dataclass(frozen=True, slots=True)
class Doubt:
    """One doubt: the joint (or joints, or "hand"), what is doubtful, and what to pass instead."""

    joint: str
    what: str
    advice: str

    def __str__(self) -> str:
        """One line."""
        return f"{self.joint}: {self.what} → {self.advice}"


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
        """The doubt at a position."""
        return self.doubts[index]

    def __len__(self) -> int:
        """How many doubts."""
        return len(self.doubts)

    def __iter__(self) -> Iterator[Doubt]:
        """The doubts in order."""
        return iter(self.doubts)

    def about(self, joint: str) -> tuple[Doubt, ...]:
        """The doubts that name a joint."""
        return tuple(d for d in self.doubts if joint in d.joint.split(", "))

    def __str__(self) -> str:
        """All doubts, one a line."""
        if not self.doubts:
            return f"{self.source}: no doubts"
        many = "1 doubt" if len(self) == 1 else f"{len(self)} doubts"
        return "\n".join([f"{self.source}: {many}", *(f"  {d}" for d in self.doubts)])

    def __rich__(self) -> Any:
        """A table for rich."""
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
    root, file = read_urdf("path", path, base)
    stiffness = Doubt(
        "hand",
        "a URDF has no place for joint stiffness",
        "joint_stiffness: N·m/rad, a number, a mapping by joint name or a matrix",
    )
    return Audit(file.name, (*doubts_of(joint_facts(root)), stiffness))


def doubts_of(facts: Sequence[JointFacts], limits_given: Iterable[str] = ()) -> tuple[Doubt, ...]:
    """The doubts about joints as written; efforts of joints whose limit the user gave are not doubted."""
    return (*_efforts(facts, set(limits_given)), *_ranges(facts), *_couplings(facts), *_bodies(facts))


def _efforts(facts: Sequence[JointFacts], given: set[str]) -> Iterator[Doubt]:
    asked = [f for f in facts if f.mimic is None and f.name not in given]
    yield from _grouped(
        (f.name for f in asked if f.effort == 0),
        "effort limit is zero, read as unknown",
        "torque_limits with the actuator's torque [N·m]",
    )
    yield from _grouped(
        (f.name for f in asked if not math.isfinite(f.effort)),
        "effort limit is absent or infinite, read as unknown",
        "torque_limits with the actuator's torque [N·m]",
    )
    yield from _grouped(
        (f.name for f in asked if f.effort < 0),
        "effort limit is negative, read as unknown",
        "torque_limits with the actuator's torque [N·m]",
    )
    values = {f.effort for f in asked}
    if len(asked) > 1 and len(values) == 1 and (value := values.pop()) in PLACEHOLDERS:
        yield Doubt(
            ", ".join(f.name for f in asked),
            f"every effort limit is {value:g} N·m: a placeholder, not a measurement",
            "torque_limits with the torque of each actuator [N·m]",
        )


def _ranges(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    for f in facts:
        if f.kind == "continuous":
            continue
        if math.isnan(f.lower) or math.isnan(f.upper):
            yield Doubt(f.name, "position limits are absent or no numbers", "a URDF with <limit lower= upper=>")
        elif f.lower > f.upper:
            yield Doubt(
                f.name,
                f"lower limit {f.lower:g} lies above the upper limit {f.upper:g}",
                "a URDF with its limits in order",
            )
        elif f.lower == f.upper:
            yield Doubt(
                f.name, f"the joint cannot move: both limits are {f.lower:g}", "a URDF with a range, or a fixed joint"
            )
        elif not f.lower <= 0 <= f.upper and f.mimic is None:
            yield Doubt(
                f.name,
                f"the neutral posture 0 lies outside the limits [{f.lower:g}, {f.upper:g}]",
                "q0 inside the limits (hand.neutral is)",
            )
    wide = [f for f in facts if f.kind == "revolute" and f.upper - f.lower >= 2 * math.pi]
    yield from _grouped(
        (f.name for f in wide), "the range is a full turn or more, wider than a finger's", "a URDF with the real limits"
    )


def _couplings(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    for f in facts:
        m = f.mimic
        if m is None:
            continue
        law = f"{m.multiplier:g} × {m.master} {m.offset:+g}"
        own = "torque limits and stiffness belong to the joint it follows"
        if m.master is None:
            yield Doubt(
                f.name, f"mimics {m.written!r}, which is no movable joint", "a URDF whose <mimic> names a joint"
            )
        elif m.master != m.written:
            yield Doubt(
                f.name,
                f"mimics {m.written!r}, which does not exist; read as {law}",
                f"a URDF that names {m.master!r}, if that is meant; {own}",
            )
        else:
            yield Doubt(
                f.name,
                f"a mimic joint (Pinocchio ignores the tag): q = {law} is built in, and it is no joint of its own",
                own,
            )


def _bodies(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    light = "a URDF with <inertial>; finger_weight=True counts this link as weightless"
    yield from _grouped((f.name for f in facts if math.isnan(f.mass)), "the link it moves has no <inertial>", light)
    yield from _grouped(
        (f.name for f in facts if f.mass <= 0), "the link it moves has a mass that is not positive", light
    )
    for f in facts:
        length = 1.0 if f.axis is None else math.hypot(*f.axis)
        if not 0 < length < math.inf:
            yield Doubt(
                f.name,
                "the axis is zero or no number: the joint moves nothing, or everything to NaN",
                "a URDF with a unit axis",
            )
        elif abs(length - 1) > 1e-3:
            yield Doubt(f.name, f"the axis has the length {length:.4g}", "a URDF with a unit axis")


def _grouped(names: Iterable[str], what: str, advice: str) -> Iterator[Doubt]:
    listed = ", ".join(names)
    if listed:
        yield Doubt(listed, what, advice)
