"""`JointFacts`: what a <robot> states of its drives: friction, springs, gears, soft limits, servos. Read as it is
written, used where its own page says so.

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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.actuation.motor import Drives
from handlcp.check import Array, NumbersByName, read_only
from handlcp.errors import InputError, URDFError
from handlcp.robot.urdf import LARGEST_NUMBER, joint_link

_REDUCTION_TAGS = ("mechanicalReduction", "mechanical_reduction")  # of ROS 1, and of ros2_control


@dataclass(frozen=True, slots=True)
class JointProperties:
    """What a file states of one joint besides its range and effort; 0 or None for what it does not.

    friction [N·m, N] : dry. stiffness [N·m/rad, N/m], rest [rad, m] : of a spring at the joint. armature [kg·m², kg].
    soft_limits (2,) [rad, m]. reduction : turns of the motor for one of the joint. servo_range (2,) [rad, m] : where
    its servo can be told to go. weaker_effort : effort to the side where it is smaller [N·m, N]. NaN is a number that
    cannot be read.
    """

    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    armature: float = 0.0
    soft_limits: tuple[float, float] | None = None
    reduction: float | None = None
    servo_range: tuple[float, float] | None = None
    weaker_effort: float | None = None


NO_PROPERTIES = JointProperties()


class Servo(NamedTuple):
    """A position actuator of the file. kp [N·m/rad, N/m] : its stiffness, with its gear. arms [1, 1/m] : how far it
    turns with each joint.
    """

    name: str
    kp: float
    arms: dict[str, float]


def check_friction(argument: str, root: ET.Element) -> None:
    """Raises URDFError for dry friction that is no finite number ≥ 0, naming the joint."""
    for joint in root.findall("joint"):
        if (tag := joint.find("dynamics")) is not None and not 0.0 <= read_number(tag, "friction", 0.0) < math.inf:
            expected = f"a finite number ≥ 0 in <dynamics friction=…> of joint {joint.get('name')!r}"
            raise URDFError(argument, expected, repr(tag.get("friction")))


def read_reductions(root: ET.Element) -> dict[str, float]:
    """Joint → reduction of its transmission; a joint's own tag, else that of the one actuator of one joint."""
    found = dict[str, float]()
    for transmission in root.iter("transmission"):
        joints = transmission.findall("joint")
        common = _read_reduction(transmission) if len(joints) == 1 else None
        for joint in joints:
            stated = _read_reduction(joint)
            if (value := common if stated is None else stated) is not None:
                found[joint.get("name", "")] = value
    return found


def _read_reduction(element: ET.Element) -> float | None:
    """The first that stands in an element; None where none does."""
    tag = next((e for e in element.iter() if e.tag in _REDUCTION_TAGS), None)
    try:
        return None if tag is None else float(tag.text or "nan")
    except ValueError:
        return math.nan


def read_servos(root: ET.Element) -> tuple[Servo, ...]:
    """The servos of a robot that was an MJCF file, those that pull joints that were cut off left out."""
    joints = {joint.get("name") for joint in root.findall("joint")}
    found = []
    for servo in root.findall("servo"):
        arms = {a.get("joint", ""): float(a.get("per_rad", 0.0)) for a in servo.findall("arm")}
        if arms.keys() <= joints:
            found.append(Servo(servo.get("name", ""), float(servo.get("kp", 0.0)), arms))
    return tuple(found)


def read_number(
    element: ET.Element | None, attribute: str, default: float = math.nan, absent: float = math.nan
) -> float:
    """An attribute as a number: NaN for what is none, `default` where it is left out, `absent` without an element."""
    if element is None:
        return absent
    try:
        return float(element.get(attribute, default))
    except ValueError:
        return math.nan


def _read_pair(element: ET.Element | None, low: str, high: str) -> tuple[float, float] | None:
    if element is None or (element.get(low) is None and element.get(high) is None):
        return None
    return read_number(element, low, 0.0), read_number(element, high, 0.0)


# ----------------------------------------------------------------
# What a URDF or a Pinocchio model says about each joint, as plain values; ranges and torque limits that follow.


@dataclass(frozen=True, slots=True)
class Mimic:
    """q = multiplier · q[master] + offset. written_master : the name in the tag. master : the joint meant; None: no
    joint.
    """

    written_master: str
    master: str | None
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class JointFacts:
    """One movable joint as written. Positions in rad or m, efforts in N·m or N; NaN for numbers that are absent or
    cannot be read. mass : of the child link [kg]; NaN without <inertial>. axis : None where it is unknown.
    effort_source : where the effort is from; "" : nowhere. properties : friction, spring, gear, soft limits, as
    written.
    """

    name: str
    kind: str
    lower: float
    upper: float
    effort: float
    axis: tuple[float, float, float] | None
    mimic: Mimic | None = None
    mass: float = math.nan
    effort_source: str = ""
    properties: JointProperties = NO_PROPERTIES

    @property
    def is_slide(self) -> bool:
        """Whether its positions are metres, and its efforts newtons."""
        return self.kind == "prismatic"


@dataclass(frozen=True, slots=True)
class Coupling:
    """q_full = C q + offset, over all movable joints; names : of the independent ones, those of q."""

    names: tuple[str, ...]
    C: Array
    offset: Array


def read_joint_facts(root: ET.Element) -> tuple[JointFacts, ...]:
    """The movable joints of a <robot>, in the file's order. Written for an MJCF file, its zero efforts are unknown."""
    no_effort = math.inf if root.get("format") == "mjcf" else 0.0
    masses = {link.get("name", ""): read_number(link.find("inertial/mass"), "value") for link in root.findall("link")}
    above = {joint_link(j, "child"): (joint_link(j, "parent"), j.get("name", "")) for j in root.findall("joint")}
    joints = [j for j in root.findall("joint") if j.get("type") not in (None, "fixed")]
    names = [j.get("name", "") for j in joints]
    gears, found = read_reductions(root), []
    for joint, name in zip(joints, names, strict=True):
        limit, axis, tag = joint.find("limit"), joint.find("axis"), joint.find("mimic")
        mimic = None
        if tag is not None:
            written = tag.get("joint", "")
            master = _find_master(written, joint, names, above)
            mimic = Mimic(written, master, read_number(tag, "multiplier", 1.0), read_number(tag, "offset", 0.0))
        lower, upper = read_number(limit, "lower", 0.0), read_number(limit, "upper", 0.0)
        effort = read_number(limit, "effort") or no_effort
        try:
            x, y, z = (1.0, 0.0, 0.0) if axis is None else (float(v) for v in axis.get("xyz", "1 0 0").split())
        except ValueError:  # other than three numbers
            x = y = z = math.nan
        mass = masses.get(joint_link(joint, "child"), math.nan)
        said = "" if limit is None else limit.get("said", "<limit effort>")
        spring, friction = joint.find("passive"), read_number(joint.find("dynamics"), "friction", 0.0, 0.0)
        stiffness, rest, armature = (read_number(spring, word, 0.0, 0.0) for word in ("stiffness", "rest", "armature"))
        soft = _read_pair(joint.find("safety_controller"), "soft_lower_limit", "soft_upper_limit")
        reach = _read_pair(joint.find("reach"), "lower", "upper")
        weaker = None if limit is None or limit.get("weaker") is None else read_number(limit, "weaker")
        stated = JointProperties(friction, stiffness, rest, armature, soft, gears.get(name), reach, weaker)
        kind = joint.get("type", "")
        found.append(JointFacts(name, kind, lower, upper, effort, (x, y, z), mimic, mass, said, stated))
    return tuple(found)


def read_model_facts(model: Any) -> tuple[JointFacts, ...]:
    """The same from a pinocchio.Model, which does not know mimic tags, missing inertials or the axes as written."""
    found = []
    for i, joint in enumerate(model.joints):
        if i and joint.nv == 1:
            slides = joint.shortname().startswith("JointModelP")
            kind, lower, upper = "continuous", math.nan, math.nan
            if joint.nq == 1:  # an angle without limits has two numbers, cos and sin
                kind = "prismatic" if slides else "revolute"
                lower, upper = (float(x[joint.idx_q]) for x in (model.lowerPositionLimit, model.upperPositionLimit))
            effort, mass = float(model.upperEffortLimit[joint.idx_v]), float(model.inertias[i].mass)
            found.append(JointFacts(model.names[i], kind, lower, upper, effort, None, None, mass, "the model"))
    return tuple(found)


def movable_joints(model: Any) -> tuple[str, ...]:
    """Joint names in Pinocchio's order of velocities. Raises URDFError for none, or for several degrees of freedom."""
    joints = [(model.names[i], joint) for i, joint in enumerate(model.joints) if i and joint.nv]
    if wrong := [f"{name!r} ({joint.shortname()}, {joint.nv})" for name, joint in joints if joint.nv != 1]:
        raise URDFError("source", "joints of one degree of freedom (revolute, continuous, prismatic)", ", ".join(wrong))
    if not joints:
        raise URDFError("source", "a hand with movable joints", "none at all")
    return tuple(name for name, _ in sorted(joints, key=lambda named: named[1].idx_v))


def resolve_mimics(names: tuple[str, ...], facts: tuple[JointFacts, ...]) -> Coupling:
    """Resolve mimic tags, also chains of them. Raises URDFError for a tag that names no joint, or runs in a circle."""
    mimics = {f.name: f.mimic for f in facts if f.mimic is not None}
    independent = tuple(name for name in names if name not in mimics)
    C, offset = np.zeros((len(names), len(independent))), np.zeros(len(names))
    for i, name in enumerate(names):
        factor, shift, at, seen = 1.0, 0.0, name, {name}
        while (mimic := mimics.get(at)) is not None:
            if mimic.master is None:
                expected = f"<mimic> tags that name movable joints among [{', '.join(names)}]"
                raise URDFError("source", expected, f"{at!r} mimicking {mimic.written_master!r}")
            if mimic.master in seen:
                raise URDFError("source", "<mimic> tags that end at a free joint", f"a circle through {at!r}")
            shift += factor * mimic.offset
            factor *= mimic.multiplier
            at = mimic.master
            seen.add(at)
        if not (abs(factor) <= LARGEST_NUMBER and abs(shift) <= LARGEST_NUMBER):  # also where one is NaN
            expected = f"<mimic> tags with finite numbers up to {LARGEST_NUMBER:g}, chains of them multiplied"
            raise URDFError("source", expected, f"{name!r}: {factor:g} × {at} {shift:+g}")
        C[i, independent.index(at)] = factor
        offset[i] = shift
    return Coupling(independent, read_only(C), read_only(offset))


def _find_master(
    written: str, joint: ET.Element, names: Sequence[str], above: Mapping[str, tuple[str, str]]
) -> str | None:
    """The joint that a tag means. Copies of a hand with prefixed names often keep the old name in the tag
    ("Left_index_q2" mimics "index_q1"). It then means the one joint whose name ends with it; of several, the one
    nearer to the base on the same finger. above : link name to its parent link and joint.
    """
    if written in names or not written:
        return written or None
    ends = [other for other in names if other.endswith(written) and other != joint.get("name")]
    if len(ends) > 1:
        ancestors, link = set[str](), joint_link(joint, "parent")
        while link in above and above[link][1] not in ancestors:
            link, name = above[link]
            ancestors.add(name)
        ends = [other for other in ends if other in ancestors]
    return ends[0] if len(ends) == 1 else None


# ---------------------------------------------------------------- One doubt about a hand, and how much it weighs.

SEVERITIES = ("serious", "minor", "information")  # most important first
SHARED_LIMIT = "shared limit"  # what a doubt is about that leaves open what the motors hold


@dataclass(frozen=True, slots=True)
class Doubt:
    """What an audit does not believe of a joint or link (or several, or "hand"), and what to pass instead.

    severity : "serious": it can change a verdict, beside which it is said again; "minor": it changes numbers;
    "information": nothing is wrong, and something was read in a way worth knowing. about : a word for what it is
    about, such as "torque limit", "range", "coupling", "geometry".
    """

    joint: str
    what: str
    advice: str
    severity: str = "minor"
    about: str = ""

    @property
    def sentence(self) -> str:
        """For a verdict, where many joints are shortened to four."""
        who = words.list_names(self.joint.split(", "))
        if self.about == "torque limit":
            return f"the torque limits of {who} are doubtful: {self.what}; torque_limits= confirms or corrects them"
        return f"{who}: {self.what}; pass {self.advice}"

    def __str__(self) -> str:
        return f"{self.joint}: {self.what} → {self.advice}"


# ----------------------------------------------------------------
# Ranges and torque limits of the independent joints: the URDF's, and what the user passes over them.


def read_ranges(names: Sequence[str], facts: Mapping[str, JointFacts], coupling: Coupling) -> tuple[Array, Array]:
    """(nv,) lower and upper positions of the independent joints [rad, m], narrowed by joints that follow; ±inf: none.

    names : of all movable joints, in the order of the coupling's rows.
    """
    lower, upper = np.full(len(coupling.names), -np.inf), np.full(len(coupling.names), np.inf)
    for i, name in enumerate(names):
        fact = facts[name]
        k = int(np.argmax(abs(coupling.C[i])))
        factor, offset = float(coupling.C[i, k]), float(coupling.offset[i])  # Python's floats divide without a warning
        if fact.kind == "continuous" or factor == 0.0 or np.isnan(fact.lower) or np.isnan(fact.upper):
            continue
        ends = sorted(((fact.lower - offset) / factor, (fact.upper - offset) / factor))
        if fact.lower > fact.upper:  # the audit reports it, and nothing corrects it
            ends.reverse()
        lower[k], upper[k] = max(lower[k], ends[0]), min(upper[k], ends[1])
    return read_only(lower), read_only(upper)


@dataclass(frozen=True, slots=True)
class TorqueLimits:
    """What torques the joints of a hand bear, and who says so.

    limits (nv,) : what the joints hold for good [N·m], inf for none. known : nv booleans. given : the joints whose
    limit the user passed. drives : motors, where joints have some. without_motors : the limits without them, else None.
    """

    limits: Array
    known: tuple[bool, ...]
    given: tuple[str, ...]
    drives: Drives | None = None
    without_motors: TorqueLimits | None = None

    @property
    def closing_limits(self) -> Array:
        """(nv,) what motors give while they close, dry friction included [N·m]; inf where no motor says it."""
        free = np.full(len(self.limits), np.inf)
        return read_only(free) if self.drives is None else self.drives.peak_limits(free)

    @property
    def peak_limits(self) -> Array:
        """(nv,) the largest torque with which a joint can be asked to close [N·m]: the peak of its motor, or its
        limit.
        """
        return self.limits if self.drives is None else self.drives.peak_limits(self.limits)

    def with_motors(self, drives: Drives | None, joints: Sequence[str]) -> TorqueLimits:
        """With these motors in place of earlier ones; of joints that have one, the limit is what it holds for good."""
        bare = self if self.without_motors is None else self.without_motors
        if drives is None:
            return bare
        own = drives.motor_joints(joints)
        known = tuple([k or joint in own for k, joint in zip(bare.known, joints, strict=True)])
        given = tuple(dict.fromkeys((*bare.given, *own)))
        return TorqueLimits(drives.holding_limits(bare.limits), known, given, drives, bare)


TORQUE_LIMITS = NumbersByName("joint", above=0.0, finite=False, rest=np.inf)
JOINT_FRICTION = NumbersByName("joint", minimum=0.0)


def read_torque_limits(
    value: Any, joints: Sequence[str], facts: Mapping[str, JointFacts], drives: Drives | None = None
) -> TorqueLimits:
    """From None (the URDF's efforts), a number, a mapping by joint name (over the URDF's), or (nv,) [N·m]; and from
    motors, which give the limits of their joints.

    A URDF effort that is zero, negative, infinite or absent is unknown. An inf that the user passes is known: no limit.
    Raises InputError for limits that are not positive, and for a limit by name of a joint that has a motor;
    UnknownName.
    """
    passed = [] if value is None else TORQUE_LIMITS.read("torque_limits", value, joints).tolist()
    given = dict(zip(joints, passed, strict=False))
    if isinstance(value, Mapping):
        given = {joint: given[joint] for joint in value}
        if both := [] if drives is None else [joint for joint in drives.motor_joints(joints) if joint in value]:
            raise InputError("torque_limits", "no limit of a joint with a motor, which gives it", ", ".join(both))
    known = {joint: facts[joint].effort for joint in joints if 0 < facts[joint].effort < np.inf} | given
    limits = read_only(np.array([known.get(joint, np.inf) for joint in joints]))
    return TorqueLimits(limits, tuple(joint in known for joint in joints), tuple(given)).with_motors(drives, joints)


def read_joint_friction(value: Any, joints: Sequence[str], facts: Mapping[str, JointFacts]) -> Array:
    """(nv,) from None (none), "file" (what the file states), a number, a mapping by joint name (others: none), or (nv,)
    [N·m]. Raises InputError for what is negative or not finite, also in a file; UnknownName.
    """
    argument = "joint_friction"
    if value is None:
        return read_only(np.zeros(len(joints)))
    if isinstance(value, str):
        if value != "file":
            raise InputError(argument, 'a number, a mapping by joint name, or "file"', repr(value))
        value = {joint: facts[joint].properties.friction for joint in joints}
    return JOINT_FRICTION.read(argument, value, joints)
