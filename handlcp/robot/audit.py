"""`Audit`: what may be wrong with a hand's description: doubts about its geometry, joints, ranges and limits."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, overload

import numpy as np

from handlcp import words
from handlcp.actuation.joint_stiffness import Elasticity
from handlcp.check import Array, check_call, check_method_calls
from handlcp.errors import HandLCPError, InputError
from handlcp.grasp.failure.reason import Reason, make_reason
from handlcp.record import Record
from handlcp.robot.description import COLLISION, VISUAL, RobotDescription, read_robot
from handlcp.robot.fingertip import choose_obvious_tips, find_tip_candidates
from handlcp.robot.joint import SEVERITIES, SHARED_LIMIT, Doubt
from handlcp.robot.joint_audit import (
    joint_doubts,
    motor_doubts,
    property_doubts,
    range_doubts,
    sag_doubts,
    slide_doubts,
    spring_doubts,
    unequal_doubts,
)
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.link_shape import shape_doubts
from handlcp.robot.servo_stiffness import has_servos, read_file_stiffness
from handlcp.robot.urdf import build_model
from handlcp.words import wrap_text

# ----------------------------------------------------------------
# The audit: every doubt about the numbers of a hand, the most serious first. A parser accepts all of them.

_SEVERITY_HEADS = {
    "serious": "Serious: can change a verdict",
    "minor": "Minor: changes numbers",
    "information": "Information",
}
_SAID_ELSEWHERE = ("limit unknown", "geometry")  # a verdict has warnings of its own about these


@check_method_calls
@dataclass(frozen=True, slots=True)
class Audit(Record, Sequence[Doubt]):
    """The doubts about one hand, the most serious first; a sequence that is empty (false) when there are none. Prints
    in lines of at most 80 columns.
    """

    entries = ("source", "summary", "doubts")

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

    @property
    def serious(self) -> tuple[Doubt, ...]:
        """The doubts that can change a verdict."""
        return tuple(d for d in self.doubts if d.severity == "serious")

    @property
    def summary(self) -> str:
        """How many of each severity, such as "1 serious, 2 minor"."""
        count = Counter(d.severity for d in self.doubts)
        return ", ".join(f"{count[s]} {s}" for s in SEVERITIES if count[s]) or "no doubts"

    def __str__(self) -> str:
        lines = [f"{self.source}: {self.summary}"]
        for severity in SEVERITIES:
            these = [d for d in self.doubts if d.severity == severity]
            lines += [_SEVERITY_HEADS[severity]] if these else []
            for d in these:
                lines.append(wrap_text(str(d), "      ", "  "))
        return "\n".join(lines)


def make_audit(source: str, doubts: Iterable[Doubt]) -> Audit:
    """The most serious doubts first, else in their order."""
    return Audit(source, tuple(sorted(doubts, key=lambda d: SEVERITIES.index(d.severity))))


@check_call()
def audit_urdf(path: Any, base: str | None = None, package_dirs: Any = None) -> Audit:
    """Audit a URDF or MJCF file (below link `base` if given) without building a hand from it.

    Raises URDFError for a file that is missing or not a URDF, UnknownName for an unknown base; Unsupported for an MJCF
    file without MuJoCo.
    """
    described, root, label = read_robot("path", path, base, package_dirs)
    try:
        kinematics = Kinematics(build_model("path", root, label), described.facts)
    except HandLCPError:  # what makes no hand has doubts, too
        kinematics = None
    described = replace(described, model=kinematics and kinematics.model)
    return make_audit(described.source, file_doubts(described, kinematics))


def file_doubts(described: RobotDescription, kinematics: Kinematics | None) -> Iterator[Doubt]:
    """Those about a file of which nothing else is known; of its stiffness, whether the file says it, and it can be."""
    yield from description_doubts(described, (), kinematics)
    try:
        stiffness = read_file_stiffness(described, kinematics) if kinematics is not None else None
    except InputError:
        stiffness = None
    if stiffness is None or kinematics is None:
        unit = words.unit_of_joints(words.stiffness_unit, [f.is_slide for f in described.facts] or [False])
        advice = f"joint_stiffness: {unit}, a number, a mapping by joint name or a matrix"
        yield Doubt("hand", "the file says nothing of joint stiffness", advice, "minor", "stiffness")
        return
    found = choose_obvious_tips(find_tip_candidates(described))
    tips = [(c.name, kinematics.model.getFrameId(c.link), c.point) for c in found]
    efforts = {f.name: f.effort for f in described.facts}
    limits = np.array([efforts[name] for name in kinematics.joint_names])
    yield from _spring_number_doubts(kinematics, stiffness, tips, limits)


def stiffness_doubts(hand: Any) -> Iterator[Doubt]:
    """Of the stiffness that a hand has: one number for all joints, or that of the file."""
    if hand.stiffness.uniform:
        where = "is not that of the file" if has_servos(hand.description) else "is in no file"
        unit = words.unit_of_joints(words.stiffness_unit, [name in hand.sliding for name in hand.joint_names])
        what = f"joint stiffness {where}: {hand.stiffness.stiffness_matrix[0, 0]:g} {unit} was passed for every joint"
        advice = "joint_stiffness as measured, by joint name or as a matrix"
        yield Doubt("hand", what, advice, "minor", "stiffness")
    tips = [(name, frame, None) for name, frame in zip(hand.fingertips, hand.tips.frames, strict=True)]
    yield from _spring_number_doubts(hand.kinematics, hand.stiffness, tips, hand.torque_limits)


def _spring_number_doubts(
    kinematics: Kinematics, stiffness: Elasticity, tips: Sequence[tuple[str, int, Any]], limits: Array
) -> Iterator[Doubt]:
    """Of springs of slides; and of those that a file states, which are often chosen for a simulation. Arguments as of
    `sag_doubts` and `spring_doubts`.
    """
    yield from slide_doubts(kinematics, stiffness)
    if stiffness.is_from_file:
        what = "joint stiffness is kp of the file's position actuators, often chosen for a simulation"
        yield Doubt("hand", what, "joint_stiffness as measured: stiffness_from", "minor", "stiffness")
        yield from sag_doubts(kinematics, tips, stiffness.contact_compliance(np.eye(kinematics.nv)))
        yield from spring_doubts(kinematics, stiffness, limits)


def description_doubts(
    described: RobotDescription, limits_given: Iterable[str] = (), kinematics: Kinematics | None = None
) -> tuple[Doubt, ...]:
    """The doubts about a robot as it was read, in no order of importance.

    limits_given : joints whose torque limit was passed; efforts don't count. kinematics : None where nothing but the
    file is known.
    """
    facts, given = described.facts, set(limits_given)
    own = [f for f in facts if f.name not in given]
    free = {f.name for f in own}
    read = [d for d in described.doubts if d.about != SHARED_LIMIT or free.intersection(d.joint.split(", "))]
    return (
        *joint_doubts(facts, given),
        *range_doubts(facts, kinematics),
        *property_doubts(facts),
        *motor_doubts(own),
        *unequal_doubts(own, described.servos, kinematics),
        *read,
        *geometry_doubts(described),
    )


def doubt_reasons(doubts: Iterable[Doubt]) -> Iterator[Reason]:
    """A warning for each serious doubt, to stand beside the verdict that rests on it; without limits of motors there is
    none.
    """
    for d in doubts:
        if d.severity != "serious" or d.about in _SAID_ELSEWHERE:
            continue
        joints = d.joint.split(", ")
        code = {"torque limit": "limit_doubtful", SHARED_LIMIT: "limit_shared"}.get(d.about, "hand_doubtful")
        severity = "decides" if d.about == SHARED_LIMIT else "warning"
        yield make_reason(code, severity, {"joints": joints}, doubt=d.sentence)


# ----------------------------------------------------------------
# Doubts about the geometry of links: what is missing, what that leaves unchecked, and sizes that cannot be.

_GEOMETRY_ADVICE = "a file with collision geometry, or tip_radius for the fingertips"


def geometry_doubts(described: RobotDescription) -> Iterator[Doubt]:
    """Of a robot's links."""
    solid, seen = described.links_with(COLLISION), described.links_with(VISUAL)
    if not solid:
        what = "no link has collision geometry: whether links are inside the object is not checked"
        yield Doubt("hand", what, _GEOMETRY_ADVICE, "serious", "geometry")
    elif bare := [name for name in seen if name not in solid]:
        what = "without collision geometry: not checked to be outside the object"
        yield Doubt(", ".join(bare), what, _GEOMETRY_ADVICE, "minor", "geometry")
    root = ET.Element("robot") if described.root is None else described.root
    for kind, severity in ((COLLISION, "serious"), (VISUAL, "information")):
        meshes = [mesh for mesh in root.iterfind(f"link/{kind}/geometry/mesh") if not described.has_mesh(mesh)]
        if missing := list(dict.fromkeys(mesh.get("filename", "") for mesh in meshes)):
            what = f"mesh files of {kind} geometry are not found: {words.list_names(missing)}"
            yield Doubt("hand", what, "package_dirs with the folder that holds them", severity, "geometry")
    if described.model is not None:
        yield from shape_doubts(described.collision_sizes, described.model)


def tip_doubts(hand: Any) -> Iterator[Doubt]:
    """Of the fingertips of a hand: what contacts are found on."""
    drawn = "nothing there collides, so contacts are found on what is drawn of it"
    bare = "its link has no geometry, so that no contact with an object can be found"
    for kind, what, advice, severity in (
        (VISUAL, drawn, "tip_radius, or a file with collision geometry", "minor"),
        ("", bare, "tip_radius", "serious"),
    ):
        if names := [name for i, name in enumerate(hand.fingertips) if hand.tip_kind(i) == kind]:
            yield Doubt(", ".join(names), what, advice, severity, "geometry")
