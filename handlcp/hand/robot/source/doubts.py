"""Doubts about what a file states of drives: soft limits, servos, springs too weak, joints unlike their like."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.robot.joints import Doubt, JointFacts
from handlcp.hand.robot.kinematics import Kinematics
from handlcp.hand.robot.source.passive import preload
from handlcp.hand.robot.source.stated import Servo

_SHORT = 1e-2  # of a range: a soft limit or a servo that leaves out less is not worth a word
_SAGS = 1e-3  # [m] by its own weight
_NONE = 1e30  # [N] a tendon that bears as much has no limit
_TURNS = 1e-9  # of a motion of length 1: less is rounding
_PULLS = 0.1  # of the torque limit: springs that pull with less are not worth a word
_LOPSIDED = 0.5  # of the effort to the other side: with less, the direction matters
_RUBS = 0.25  # of the effort limit: no good drive has as much
_GRAVITY = 9.81  # [m/s²]
MIN_SLIDE_STIFFNESS = 200.0  # [N/m] a drive gives way by less than 5 mm under 1 N
_UNLIKE = 0.05  # of the larger number: less is rounding

# ---------------------------------------------------------------- One joint at a time.


def stated_doubts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    """Of soft limits and servos that leave out a part of the range, and numbers that cannot be."""
    for f in facts:
        stated = f.stated
        if _leaves_out(f, stated.soft):
            assert stated.soft is not None
            what = f"its soft limits [{_ends(stated.soft)}] are narrower than its range, which is used"
            yield Doubt(f.name, what, "a URDF with the soft limits as <limit>, if they count", "minor", "range")
        if _leaves_out(f, stated.reach):
            assert stated.reach is not None
            what = f"its actuator is told no more than [{_ends(stated.reach)}]: the rest of its range is not reached"
            yield Doubt(f.name, what, "an MJCF file whose ctrlrange fits the range", "minor", "range")
        if not 0.0 <= stated.friction < math.inf:
            what = f"its dry friction is {stated.friction:g}, which is no number ≥ 0"
            advice = f"a file with the friction of the drive [{words.effort_unit(f.slides)}]"
            yield Doubt(f.name, what, advice, "minor", "friction")
        if stated.reduction is not None and not 0.0 < abs(stated.reduction) < math.inf:
            said = "no number" if math.isnan(stated.reduction) else f"{stated.reduction:g}"
            what = f"the reduction of its transmission is {said}"
            yield Doubt(f.name, what, "a file with turns of the motor for one of the joint", "minor", "gear")


def _leaves_out(f: JointFacts, part: tuple[float, float] | None) -> bool:
    """Whether a part of a range is narrower; equal ends are no limits, but a form that was not filled in."""
    if part is None or not part[0] < part[1] or not f.lower < f.upper or f.kind == "continuous":
        return False
    return max(part[0] - f.lower, f.upper - part[1]) > _SHORT * (f.upper - f.lower)


def _ends(pair: tuple[float, float]) -> str:
    return f"{pair[0]:.4g}, {pair[1]:.4g}"


def friction_doubts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    """Of friction that takes much of what the motor has."""
    high = [f for f in facts if f.mimic is None and 0.0 < f.effort < math.inf and f.stated.friction > _RUBS * f.effort]
    if high:
        worst = max(f.stated.friction / f.effort for f in high)
        what = f"dry friction of the file takes up to {words.percent(worst)} of the effort limit"
        yield Doubt(", ".join(f.name for f in high), what, "a file with measured friction", "minor", "friction")


def side_doubts(facts: Sequence[JointFacts]) -> Iterator[Doubt]:
    """Of joints that are driven to one side alone, or much harder than to the other."""
    alike = defaultdict[tuple[float, float, bool], list[str]](list)
    for f in facts:
        if f.mimic is None and f.stated.weaker is not None and f.stated.weaker < _LOPSIDED * f.effort < math.inf:
            alike[f.stated.weaker, f.effort, f.slides].append(f.name)
    for (weaker, effort, slides), names in alike.items():
        other = f"with {weaker:g} alone" if weaker else "not at all"
        what = (
            f"actuators of the file drive the joint with {effort:g} to one side and {other} to the other; the larger "
            "side is the limit for both, also where the joint closes to the other"
        )
        advice = f"torque_limits with what closes the hand [{words.effort_unit(slides)}]"
        yield Doubt(", ".join(names), what, advice, "serious", "torque limit")


# ----------------------------------------------------------------
# Joints whose names differ by a side, a finger or a number alone should have equal motors. Thumbs are unlike fingers,
# and numbers along one finger count its joints, so that these are not compared.

_SIDE = re.compile(r"(?<![a-z])(left|right|lh|rh|l|r)(?![a-z])", re.IGNORECASE)
_FINGER = re.compile(r"(?<![a-z])(index|middle|ring|little|pinky|(?:ff|mf|rf|lf|if)(?=[_\d]|j\d))", re.IGNORECASE)
_NUMBER = re.compile(r"\d+")


def unlike_doubts(
    facts: Sequence[JointFacts], servos: Sequence[Servo], kinematics: Kinematics | None
) -> Iterator[Doubt]:
    """Of sides that differ, and of one among three or more like fingers that does."""
    efforts = {f.name: f.effort for f in facts if f.mimic is None and 0.0 < f.effort < math.inf}
    kp = {next(iter(s.arms)) if len(s.arms) == 1 else s.name: s.kp for s in servos}
    for what, advice, values in (("effort limit", "torque_limits", efforts), ("kp", "joint_stiffness", kp)):
        for names in _groups(values, _SIDE, 2):
            if len(names) == 2 and not _same(*(values[n] for n in names)):
                one, two = names
                said = f"{what} {values[one]:g} and {values[two]:g}, though they differ by their side alone"
                yield Doubt(f"{one}, {two}", said, f"{advice} by joint name", "minor", "unlike")
        for names in (*_groups(values, _FINGER, 3), *_groups(values, _NUMBER, 3)):
            odd = [n for n in names if sum(not _same(values[n], values[m]) for m in names) == len(names) - 1]
            if len(odd) == 1 and _alike_but(odd[0], names, values) and _side_by_side(names, kinematics):
                usual = next(values[n] for n in names if n != odd[0])
                said = f"{what} {values[odd[0]]:g}, where its like on other fingers have {usual:g}"
                yield Doubt(odd[0], said, f"{advice} by joint name", "minor", "unlike")


def _groups(values: Mapping[str, float], part: re.Pattern[str], least: int) -> list[list[str]]:
    """Names that are the same but for one such part, of `least` or more."""
    found = defaultdict[tuple[str, str], list[str]](list)
    for name in values:
        for at in part.finditer(name):
            found[name[: at.start()], name[at.end() :]].append(name)
    return [names for names in found.values() if len(names) >= least]


def _same(one: float, two: float) -> bool:
    return abs(one - two) <= _UNLIKE * max(abs(one), abs(two))


def _alike_but(odd: str, names: Sequence[str], values: Mapping[str, float]) -> bool:
    rest = [values[n] for n in names if n != odd]
    return all(_same(rest[0], value) for value in rest)


def _side_by_side(names: Sequence[str], kinematics: Kinematics | None) -> bool:
    """Whether no joint carries another. A name of no joint is that of a tendon."""
    if kinematics is None:
        return False
    model = kinematics.model
    numbers = {model.getJointId(name) for name in names if model.existJointName(name)}
    return all(len(numbers & set(model.supports[j])) == 1 for j in numbers)


# ---------------------------------------------------------------- Springs too weak for a finger.


def weak_doubts(kinematics: Kinematics, tips: Sequence[tuple[str, int, Any]], compliance: Array) -> Iterator[Doubt]:
    """Of fingertips that sag by more than a millimetre under their own finger's weight, in the worst direction of
    gravity, in the neutral posture. tips : name, frame, point in it [m] or None. compliance (nv, nv).
    """
    if not tips:
        return
    model, q = kinematics.model, kinematics.neutral
    places, J = kinematics.frames_at(q, [frame for _, frame, _ in tips])
    J = J.copy()
    weight = np.column_stack([kinematics.gravity_torque(q, _GRAVITY * axis) for axis in np.eye(3)])
    C = np.eye(kinematics.nv) if kinematics.coupling is None else kinematics.coupling
    support = np.zeros((len(tips), len(C)))
    for row, (_, frame, _) in zip(support, tips, strict=True):
        row[[model.joints[j].idx_v for j in model.supports[model.frames[frame].parentJoint] if j]] = 1.0
    moves = kinematics.moved_by(support)
    sags = dict[str, float]()
    for (name, _, point), place, row, moved in zip(tips, places, support, moves, strict=True):
        own = np.flatnonzero(moved & (moves.sum(axis=0) == 1))
        p = place[:3, 3] if point is None else place[:3, :3] @ np.asarray(point) + place[:3, 3]
        tip = ((J[:3] + np.cross(J[3:], p, axis=0)) * row) @ C
        motion = tip[:, own] @ compliance[np.ix_(own, own)] @ weight[own]
        if (sag := float(np.linalg.norm(motion, 2)) if len(own) else 0.0) > _SAGS:
            sags[name] = sag
    if sags:
        worst = list(sags)[words.first_largest(np.array(list(sags.values())))]
        far = words.length(sags[worst])
        what = f"kp of the file is so small that a finger's own weight moves its tip by {far} ({worst})"
        yield Doubt(", ".join(sags), what, "joint_stiffness as measured: stiffness_from", "minor", "stiffness")


def slide_doubts(facts: Sequence[JointFacts], stiffness: Mapping[str, float]) -> Iterator[Doubt]:
    """Of slides as soft as no drive is: numbers of N·m/rad for N/m. stiffness : of each joint, by name."""
    slides = {f.name for f in facts if f.slides}
    soft = {name: k for name, k in stiffness.items() if name in slides and 0.0 < k < MIN_SLIDE_STIFFNESS}
    if soft:
        least = min(soft.values())
        what = (
            f"joint stiffness of {least:g} N/m lets a slide give way by {words.length(1.0 / least)} under 1 N, "
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
        most = abs(stiffness.arms) * np.minimum(stiffness.cables.limits, _NONE)[:, None]
        limits = np.minimum(limits, most.sum(axis=0))
    shares = abs(preload(kinematics)) / np.where(limits > 0.0, limits, np.inf)
    shares[stiffness.beside > 0.0] = 0.0
    if much := [name for name, share in zip(joints, shares, strict=True) if share > _PULLS]:
        what = (
            f"springs of the file pull with up to {words.percent(float(shares.max()))} of what drives give "
            "in the middle of the range; torques and tensions here leave out what drives give against them"
        )
        yield Doubt(", ".join(much), what, "limits that are lower by that", "minor", "spring")
    turned = np.asarray((abs(stiffness.commands) > _TURNS).any(axis=1))
    if idle := [name for name, turns in zip(joints, turned, strict=True) if not turns]:
        what = "no actuator turns it, and its spring is taken to be at rest in the posture of a grasp"
        yield Doubt(", ".join(idle), what, "postures with it where its spring is at rest", "minor", "spring")
