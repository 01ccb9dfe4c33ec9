"""What a <robot> states of its drives: friction, springs, gears, soft limits, servos. Read as it is written, used where
its own page says so.

| of a joint | URDF | MJCF |
| --- | --- | --- |
| friction | dynamics friction | frictionloss |
| spring, rest, armature | | stiffness, springref, armature |
| soft limits | safety_controller | |
| reduction | transmission, that of ros2_control too: mechanicalReduction | |
| reach: where a servo can be told to go | | ctrlrange of a position actuator |
| weaker: effort to the side where it is smaller | | the smaller end of forcerange |
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import NamedTuple

from handlcp.errors import URDFError

_REDUCTION = ("mechanicalReduction", "mechanical_reduction")  # of ROS 1, and of ros2_control


@dataclass(frozen=True, slots=True)
class Stated:
    """What a file states of one joint besides its range and effort; 0 or None for what it does not.

    friction [N·m, N] : dry. stiffness [N·m/rad, N/m], rest [rad, m] : of a spring at the joint. armature [kg·m², kg].
    soft (2,) [rad, m] : soft limits. reduction : turns of the motor for one of the joint. reach (2,) [rad, m] : where
    its servo can be told to go. weaker : effort to the side where it is smaller [N·m, N]. NaN : a number that cannot be
    read.
    """

    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    armature: float = 0.0
    soft: tuple[float, float] | None = None
    reduction: float | None = None
    reach: tuple[float, float] | None = None
    weaker: float | None = None


NOTHING_STATED = Stated()


class Servo(NamedTuple):
    """A position actuator. kp [N·m/rad, N/m] : with its gear. arms : how far it turns with each joint [1, 1/m]."""

    name: str
    kp: float
    arms: dict[str, float]


def stated_of(joint: ET.Element, reductions: dict[str, float]) -> Stated:
    """Of a <joint>. reductions : of all joints, by name."""
    spring, reach, limit = (joint.find(tag) for tag in ("passive", "reach", "limit"))
    return Stated(
        number_of(joint.find("dynamics"), "friction", 0.0, 0.0),
        number_of(spring, "stiffness", 0.0, 0.0),
        number_of(spring, "rest", 0.0, 0.0),
        number_of(spring, "armature", 0.0, 0.0),
        _pair(joint.find("safety_controller"), "soft_lower_limit", "soft_upper_limit"),
        reductions.get(joint.get("name", "")),
        _pair(reach, "lower", "upper"),
        None if limit is None or limit.get("weaker") is None else number_of(limit, "weaker"),
    )


def check_friction(argument: str, root: ET.Element) -> None:
    """Raises URDFError for dry friction that is no finite number ≥ 0, naming the joint."""
    for joint in root.findall("joint"):
        if (tag := joint.find("dynamics")) is not None and not 0.0 <= number_of(tag, "friction", 0.0) < math.inf:
            expected = f"a finite number ≥ 0 in <dynamics friction=…> of joint {joint.get('name')!r}"
            raise URDFError(argument, expected, repr(tag.get("friction")))


def reductions_of(root: ET.Element) -> dict[str, float]:
    """Joint → reduction of its transmission; a joint's own tag, else that of the one actuator of one joint."""
    found = dict[str, float]()
    for transmission in root.iter("transmission"):
        joints = transmission.findall("joint")
        common = _reduction(transmission) if len(joints) == 1 else None
        for joint in joints:
            stated = _reduction(joint)
            if (value := common if stated is None else stated) is not None:
                found[joint.get("name", "")] = value
    return found


def _reduction(element: ET.Element) -> float | None:
    """The first that stands in an element; None where none does."""
    tag = next((e for e in element.iter() if e.tag in _REDUCTION), None)
    try:
        return None if tag is None else float(tag.text or "nan")
    except ValueError:
        return math.nan


def servos_of(root: ET.Element) -> tuple[Servo, ...]:
    """The servos of a robot that was an MJCF file, those that pull joints that were cut off left out."""
    joints = {joint.get("name") for joint in root.findall("joint")}
    found = []
    for servo in root.findall("servo"):
        arms = {a.get("joint", ""): float(a.get("per_rad", 0.0)) for a in servo.findall("arm")}
        if arms.keys() <= joints:
            found.append(Servo(servo.get("name", ""), float(servo.get("kp", 0.0)), arms))
    return tuple(found)


def number_of(element: ET.Element | None, attribute: str, default: float = math.nan, absent: float = math.nan) -> float:
    """An attribute as a number: NaN for what is none, `default` where it is left out, `absent` without an element."""
    if element is None:
        return absent
    try:
        return float(element.get(attribute, default))
    except ValueError:
        return math.nan


def vector_of(text: str) -> tuple[float, float, float]:
    """Three numbers; NaN for a text that has others."""
    try:
        x, y, z = (float(v) for v in text.split())
    except ValueError:
        return (math.nan, math.nan, math.nan)
    return (x, y, z)


def _pair(element: ET.Element | None, low: str, high: str) -> tuple[float, float] | None:
    if element is None or (element.get(low) is None and element.get(high) is None):
        return None
    return number_of(element, low, 0.0), number_of(element, high, 0.0)
