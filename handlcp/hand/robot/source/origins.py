"""Where the numbers of a hand came from, and what else its file states: rows for a description."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.elasticity.motor import Drives, Motor
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.robot.joints import JointFacts
from handlcp.hand.robot.source.description import Description
from handlcp.hand.robot.source.servos import ServoStiffness
from handlcp.text_table import wrapped

GIVEN, DEFAULT, NOWHERE = "given", "default", "nowhere"
_MODEL = "the Pinocchio model"


class OriginRow(NamedTuple):
    """One kind of number. of : the joints, fingertips or links that have it. source : "given" to the hand, "default",
    "nowhere", or where the file says it.
    """

    number: str
    of: tuple[str, ...]
    source: str


class StatedRow(NamedTuple):
    """What a file states besides. tag : where. unit : of the values, by joint. used : what becomes of it."""

    what: str
    tag: str
    unit: str
    values: dict[str, Any]
    used: str


# ---------------------------------------------------------------- Where numbers came from.


def file_origins(described: Description, joints: Sequence[str]) -> Iterator[OriginRow]:
    """Of what only a file says. joints : the independent ones."""
    if described.root is None:
        ranges = masses = _MODEL
    else:
        ranges = "range of <joint>" if described.mjcf else "<limit lower upper>"
        masses = "<inertial>, or the geoms" if described.mjcf else "<inertial mass>"
    kinds = {f.name: f.kind for f in described.facts}
    yield OriginRow("range", tuple(j for j in joints if kinds[j] != "continuous"), ranges)
    followers = tuple(f.name for f in described.facts if f.mimic is not None)
    yield OriginRow("coupling", followers, "<equality><joint>" if described.mjcf else "<mimic>")
    yield OriginRow("mass", tuple(k for k, m in described.masses.items() if m), masses)


def limit_origins(
    facts: Mapping[str, JointFacts], joints: Sequence[str], given: Sequence[str] = (), drives: Drives | None = None
) -> Iterator[OriginRow]:
    """Of torque limits. given : the joints whose limit was passed. drives : motors, where joints have some."""
    found = dict[str, list[str]]()
    motors = (None,) * len(joints) if drives is None else drives.of
    for joint, motor in zip(joints, motors, strict=True):
        known = 0 < facts[joint].effort < np.inf
        source = GIVEN if joint in given else facts[joint].effort_said if known else NOWHERE
        found.setdefault(source if motor is None else _of_motor(motor), []).append(joint)
    for source, names in found.items():
        yield OriginRow("torque limit", tuple(names), source)


def tension_origins(stiffness: TendonStiffness) -> Iterator[OriginRow]:
    """Of limits of tendons, where they have any."""
    found, cables = dict[str, list[str]](), stiffness.cables
    motors = (None,) * len(cables.names) if stiffness.drives is None else stiffness.drives.of
    each = zip(cables.names, cables.limits.tolist(), stiffness.bears.tolist(), motors, strict=True)
    for name, limit, bears, motor in each:
        if limit < np.inf:
            said = "forcerange of its actuators" if stiffness.stated else GIVEN
            found.setdefault(_of_motor(motor) if motor is not None and limit < bears else said, []).append(name)
    for source, names in found.items():
        yield OriginRow("tension limit", tuple(names), source)


def _of_motor(motor: Motor) -> str:
    return f"its motor, {motor.held_by} torque"


def stiffness_origins(stiffness: Elasticity, joints: Sequence[str]) -> Iterator[OriginRow]:
    """Of the stiffness of joints (nv,)."""
    if isinstance(stiffness, ServoStiffness):
        found = dict[str, list[str]]()
        for j, joint in enumerate(joints):
            by = bool(stiffness.rows[:, j].any()), bool(stiffness.passive[j].any())
            found.setdefault(_SAID[by], []).append(joint)
        for source, names in found.items():
            yield OriginRow("stiffness", tuple(names), source)
        return
    own = isinstance(stiffness, TendonStiffness) and stiffness.cables.passive.any()
    tendons = f"kp of position actuators, along their tendons{', and springs of joints' if own else ''}"
    yield OriginRow("stiffness", tuple(joints), tendons if stiffness.stated else GIVEN)


_SAID = {  # by whether servos and springs take part in the stiffness of a joint
    (True, True): "kp of position actuators, and springs of joints",
    (True, False): "kp of position actuators",
    (False, True): "springs of joints",
}


# ---------------------------------------------------------------- What else is stated.

_Value = Callable[[JointFacts], Any]
_RUBS = 'read; used with joint_friction="file"'
_SPRINGS = 'used with joint_stiffness="file"'
_RESTS = 'used with joint_stiffness="file", of joints that servos turn'
_OF_SLIDES = {"N·m": "N", "N·m/rad": "N/m", "rad": "m", "kg·m²": "kg"}
_STATED: tuple[tuple[str, str, str, str, _Value, str], ...] = (
    ("dry friction", "dynamics friction", "frictionloss", "N·m", lambda f: f.stated.friction or None, _RUBS),
    ("spring at the joint", "", "stiffness", "N·m/rad", lambda f: f.stated.stiffness or None, _SPRINGS),
    ("rest of that spring", "", "springref", "rad", lambda f: f.stated.rest if f.stated.stiffness else None, _RESTS),
    ("armature", "", "armature", "kg·m²", lambda f: f.stated.armature or None, "ignored: nothing accelerates"),
    ("soft limits", "safety_controller", "", "rad", lambda f: f.stated.soft, "read; the range is the limit's"),
    ("reduction", "transmission", "", "", lambda f: f.stated.reduction, "read; limits are the joint's"),
)  # fmt: skip


def stated_rows(described: Description) -> Iterator[StatedRow]:
    """Of every joint, those that follow others among them; without what the file leaves out or is no number."""
    for what, urdf, xml, unit, value, used in _STATED:
        for slides in (False, True):
            facts = [f for f in described.facts if f.slides is slides]
            found = {f.name: v for f in facts if (v := value(f)) is not None}
            values = {name: v for name, v in found.items() if not isinstance(v, float) or not math.isnan(v)}
            if values:
                own = _OF_SLIDES.get(unit, unit) if slides else unit
                yield StatedRow(what, xml if described.mjcf else urdf, own, values, used)


# ---------------------------------------------------------------- Both, printed.


def origin_lines(origins: Sequence[OriginRow], stated: Sequence[StatedRow]) -> Iterator[str]:
    """In lines of at most 80 columns."""
    rows = [row for row in origins if row.of]
    if rows:
        yield "Where numbers come from"
    for row in rows:
        several = sum(other.number == row.number for other in rows) > 1
        who = f" of {words.listed(row.of)}" if several else ""
        yield wrapped(f"{row.number}{who}: {row.source}", "      ", "  ")
    if stated:
        yield "Also stated by the file"
    for s in stated:
        yield wrapped(f"{s.what}: {_values(s)} ({s.tag}; {s.used})", "      ", "  ")


def _values(row: StatedRow) -> str:
    """Such as "0.01 N·m, 24 joints", or "0.5 to 2 N·m, 3 joints"."""
    values = list(dict.fromkeys(row.values.values()))
    unit, count = f" {row.unit}" if row.unit else "", len(row.values)
    many = f"{count} joint{'' if count == 1 else 's'}"
    if isinstance(values[0], tuple):
        return many if len(values) > 1 else f"{values[0][0]:.4g} to {values[0][1]:.4g}{unit}, {many}"
    if len(values) == 1:
        return f"{values[0]:.4g}{unit}, {many}"
    return f"{min(values):.4g} to {max(values):.4g}{unit}, {many}"
