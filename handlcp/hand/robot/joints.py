"""What a URDF or a Pinocchio model says about each joint, as plain values; ranges and torque limits that follow."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, array, dimensions, number, per_name, read_only
from handlcp.errors import InputError, URDFError
from handlcp.hand.elasticity.motor import Drives
from handlcp.hand.robot.source.stated import NOTHING_STATED, Stated, number_of, reductions_of, stated_of, vector_of
from handlcp.hand.robot.urdf import LARGEST_NUMBER, link_of


@dataclass(frozen=True, slots=True)
class Mimic:
    """q = multiplier · q[master] + offset. written : the name in the tag. master : the joint meant; None: no joint."""

    written: str
    master: str | None
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class JointFacts:
    """One movable joint as written. Positions in rad or m, efforts in N·m or N; NaN for numbers that are absent or
    cannot be read. mass : of the child link [kg]; NaN without <inertial>. axis : None where it is unknown.
    effort_said : where the effort is from; "" : nowhere. stated : friction, spring, gear, soft limits, as written.
    """

    name: str
    kind: str
    lower: float
    upper: float
    effort: float
    axis: tuple[float, float, float] | None
    mimic: Mimic | None = None
    mass: float = math.nan
    effort_said: str = ""
    stated: Stated = NOTHING_STATED

    @property
    def slides(self) -> bool:
        """Whether its positions are metres, and its efforts newtons."""
        return self.kind == "prismatic"


@dataclass(frozen=True, slots=True)
class Coupling:
    """q_full = C q + offset, over all movable joints; names : of the independent ones, those of q."""

    names: tuple[str, ...]
    C: Array
    offset: Array


def joint_facts(root: ET.Element) -> tuple[JointFacts, ...]:
    """The movable joints of a <robot>, in the file's order. Written for an MJCF file, its zero efforts are unknown."""
    no_effort = math.inf if root.get("format") == "mjcf" else 0.0
    masses = {link.get("name", ""): number_of(link.find("inertial/mass"), "value") for link in root.findall("link")}
    above = {link_of(j, "child"): (link_of(j, "parent"), j.get("name", "")) for j in root.findall("joint")}
    joints = [j for j in root.findall("joint") if j.get("type") not in (None, "fixed")]
    names = [j.get("name", "") for j in joints]
    gears, found = reductions_of(root), []
    for joint, name in zip(joints, names, strict=True):
        limit, axis, tag = joint.find("limit"), joint.find("axis"), joint.find("mimic")
        mimic = None
        if tag is not None:
            written = tag.get("joint", "")
            master = _master(written, name, names, _ancestors(joint, above))
            mimic = Mimic(written, master, number_of(tag, "multiplier", 1.0), number_of(tag, "offset", 0.0))
        lower, upper, effort = (
            number_of(limit, "lower", 0.0),
            number_of(limit, "upper", 0.0),
            number_of(limit, "effort") or no_effort,
        )
        way = (1.0, 0.0, 0.0) if axis is None else vector_of(axis.get("xyz", "1 0 0"))
        mass = masses.get(link_of(joint, "child"), math.nan)
        said = "" if limit is None else limit.get("said", "<limit effort>")
        stated = stated_of(joint, gears)
        found.append(JointFacts(name, joint.get("type", ""), lower, upper, effort, way, mimic, mass, said, stated))
    return tuple(found)


def model_facts(model: Any) -> tuple[JointFacts, ...]:
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


def couple(names: tuple[str, ...], facts: tuple[JointFacts, ...]) -> Coupling:
    """Resolve mimic tags, also chains of them. Raises URDFError for a tag that names no joint, or runs in a circle."""
    mimics = {f.name: f.mimic for f in facts if f.mimic is not None}
    independent = tuple(name for name in names if name not in mimics)
    C, offset = np.zeros((len(names), len(independent))), np.zeros(len(names))
    for i, name in enumerate(names):
        factor, shift, at, seen = 1.0, 0.0, name, {name}
        while (mimic := mimics.get(at)) is not None:
            if mimic.master is None:
                expected = f"<mimic> tags that name movable joints among [{', '.join(names)}]"
                raise URDFError("source", expected, f"{at!r} mimicking {mimic.written!r}")
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


def _ancestors(joint: ET.Element, above: Mapping[str, tuple[str, str]]) -> set[str]:
    """Names of the joints between this one and the base. above : link name to its parent link and joint."""
    found, link = set[str](), link_of(joint, "parent")
    while link in above and above[link][1] not in found:
        link, name = above[link]
        found.add(name)
    return found


def _master(written: str, name: str, names: Sequence[str], ancestors: set[str]) -> str | None:
    """The joint that a tag means. Copies of a hand with prefixed names often keep the old name in the tag
    ("Left_index_q2" mimics "index_q1"). It then means the one joint whose name ends with it; of several, the one
    nearer to the base on the same finger.
    """
    if written in names:
        return written
    if not written:
        return None
    ends = [other for other in names if other.endswith(written) and other != name]
    if len(ends) > 1:
        ends = [other for other in ends if other in ancestors]
    return ends[0] if len(ends) == 1 else None


# ---------------------------------------------------------------- One doubt about a hand, and how much it weighs.

SEVERITIES = ("serious", "minor", "information")  # most important first
TOGETHER = "shared limit"  # what a doubt is about that leaves open what the motors hold


@dataclass(frozen=True, slots=True)
class Doubt:
    """One doubt: the joint or link (or several, or "hand"), what is doubtful, and what to pass instead.

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
        who = words.listed(self.joint.split(", "))
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
    """limits : (nv,) what the joints hold for good [N·m], inf for none. known : nv booleans. given : the joints whose
    limit the user passed. drives : motors, where joints have some; without : the limits without them, else None.
    """

    limits: Array
    known: tuple[bool, ...]
    given: tuple[str, ...]
    drives: Drives | None = None
    without: TorqueLimits | None = None

    @property
    def closes(self) -> Array:
        """(nv,) what motors give while they close, dry friction included [N·m]; inf where no motor says it."""
        free = np.full(len(self.limits), np.inf)
        return read_only(free) if self.drives is None else self.drives.pulls(free)

    @property
    def pulls(self) -> Array:
        """(nv,) the largest torque with which a joint can be asked to close [N·m]: the peak of its motor, or its
        limit.
        """
        return self.limits if self.drives is None else self.drives.pulls(self.limits)

    def driven(self, drives: Drives | None, joints: Sequence[str]) -> TorqueLimits:
        """With these motors in place of earlier ones; of joints that have one, the limit is what it holds for good."""
        bare = self if self.without is None else self.without
        if drives is None:
            return bare
        own = drives.names(joints)
        known = tuple([k or joint in own for k, joint in zip(bare.known, joints, strict=True)])
        given = tuple(dict.fromkeys((*bare.given, *own)))
        return TorqueLimits(drives.holds(bare.limits), known, given, drives, bare)


def read_torque_limits(
    value: Any, joints: Sequence[str], facts: Mapping[str, JointFacts], drives: Drives | None = None
) -> TorqueLimits:
    """From None (the URDF's efforts), a number, a mapping by joint name (over the URDF's), or (nv,) [N·m]; and from
    motors, which give the limits of their joints.

    A URDF effort that is zero, negative, infinite or absent is unknown. An inf that the user passes is known: no limit.
    Raises InputError for limits that are not positive, and for a limit by name of a joint that has a motor;
    UnknownName.
    """
    bare = _passed_limits(value, joints, facts)
    if drives is not None and isinstance(value, Mapping) and (both := [j for j in drives.names(joints) if j in value]):
        raise InputError("torque_limits", "no limit of a joint with a motor, which gives it", ", ".join(both))
    return bare.driven(drives, joints)


def _passed_limits(value: Any, joints: Sequence[str], facts: Mapping[str, JointFacts]) -> TorqueLimits:
    argument, named = "torque_limits", dict[str, Any]()
    if isinstance(value, Mapping):
        named = per_name(argument, value, joints, "a joint")
    elif dimensions(value) == 1 and len(value) == len(joints):
        named = dict(zip(joints, value, strict=True))
    elif dimensions(value):
        raise InputError(argument, f"{len(joints)} values, one for each of {', '.join(joints)}", repr(value))
    elif value is not None:
        named = dict.fromkeys(joints, number(argument, value, above=0.0, finite=False))
    given = {joint: number(f"{argument}[{joint!r}]", v, above=0.0, finite=False) for joint, v in named.items()}
    known = {joint: facts[joint].effort for joint in joints if 0 < facts[joint].effort < np.inf} | given
    limits = np.array([known.get(joint, np.inf) for joint in joints])
    return TorqueLimits(read_only(limits), tuple(joint in known for joint in joints), tuple(given))


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
        value = {joint: facts[joint].stated.friction for joint in joints}
    if isinstance(value, Mapping):
        named = per_name(argument, value, joints, "a joint")
        return read_only(np.array([number(f"{argument}[{j!r}]", named.get(j, 0.0), minimum=0.0) for j in joints]))
    if dimensions(value) == 0:
        return read_only(np.full(len(joints), number(argument, value, minimum=0.0)))
    given = array(argument, value, (len(joints),))
    return read_only(np.array([number(f"{argument}[{k}]", x, minimum=0.0) for k, x in enumerate(given.tolist())]))
