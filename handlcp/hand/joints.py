"""What a URDF (or a Pinocchio model) says about each joint, as plain values: the ground for limits, coupling and
audit.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import URDFError
from handlcp.hand.urdf import LARGEST_NUMBER

__all__ = ["Coupling", "JointFacts", "Mimic", "couple", "joint_facts", "model_facts", "movable_joints"]


@dataclass(frozen=True, slots=True)
class Mimic:
    """q = multiplier · q[master] + offset; `written` is the name in the tag, `master` the joint it means (None: none
    fits).
    """

    written: str
    master: str | None
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class JointFacts:
    """One movable joint as written. Numbers that are absent or no numbers are NaN; lengths in m or rad, efforts in
    N·m or N.
    """

    name: str
    kind: str
    lower: float
    upper: float
    effort: float
    axis: tuple[float, float, float] | None  # None: unknown
    mimic: Mimic | None = None
    mass: float = math.nan  # of the child link [kg]; NaN without <inertial>


@dataclass(frozen=True, slots=True)
class Coupling:
    """q_full = C q + offset, over the movable joints in Pinocchio's order; `independent` are the positions that stay
    free.
    """

    C: Array
    offset: Array
    independent: tuple[int, ...]
    identity: bool


def joint_facts(root: ET.Element) -> tuple[JointFacts, ...]:
    """The movable joints of a <robot>, in the file's order."""
    masses = {link.get("name", ""): _number(link.find("inertial/mass"), "value") for link in root.findall("link")}
    joints = [j for j in root.findall("joint") if j.get("type") not in (None, "fixed")]
    names = [j.get("name", "") for j in joints]
    above = {
        c.get("link"): (p.get("link"), j.get("name", ""))
        for j in root.findall("joint")
        if (c := j.find("child")) is not None and (p := j.find("parent")) is not None
    }

    def ancestors(joint: ET.Element) -> set[str]:
        found, link = set(), getattr(joint.find("parent"), "attrib", {}).get("link")
        while link in above and above[link][1] not in found:
            link, name = above[link]
            found.add(name)
        return found

    def facts(joint: ET.Element) -> JointFacts:
        name, limit, tag = joint.get("name", ""), joint.find("limit"), joint.find("mimic")
        axis_tag, child = joint.find("axis"), joint.find("child")
        axis = (1.0, 0.0, 0.0) if axis_tag is None else _vector(axis_tag.get("xyz", "1 0 0"))
        mimic = None
        if tag is not None:
            written = tag.get("joint", "")
            mimic = Mimic(
                written,
                _master(written, name, names, ancestors(joint)),
                _number(tag, "multiplier", 1.0),
                _number(tag, "offset", 0.0),
            )
        return JointFacts(
            name,
            joint.get("type", ""),
            _number(limit, "lower", 0.0),
            _number(limit, "upper", 0.0),
            _number(limit, "effort"),
            axis,
            mimic,
            masses.get("" if child is None else child.get("link", ""), math.nan),
        )

    return tuple(facts(joint) for joint in joints)


def model_facts(model: Any) -> tuple[JointFacts, ...]:
    """The same from a `pinocchio.Model`, which knows nothing of mimic tags, missing inertials or the axes as
    written.
    """
    found = []
    for i, joint in enumerate(model.joints):
        if i and joint.nv == 1:
            bounded = joint.nq == 1
            lower = float(model.lowerPositionLimit[joint.idx_q]) if bounded else math.nan
            upper = float(model.upperPositionLimit[joint.idx_q]) if bounded else math.nan
            kind = (
                "continuous"
                if not bounded
                else "prismatic"
                if joint.shortname().startswith("JointModelP")
                else "revolute"
            )
            effort = float(model.upperEffortLimit[joint.idx_v])
            found.append(
                JointFacts(model.names[i], kind, lower, upper, effort, None, None, float(model.inertias[i].mass))
            )
    return tuple(found)


def movable_joints(argument: str, model: Any) -> tuple[str, ...]:
    """Joint names in Pinocchio's order of velocities. Raises URDFError unless there is a joint and each has one
    degree of freedom.
    """
    joints = [
        (joint.idx_v, model.names[i], joint.nv, joint.shortname())
        for i, joint in enumerate(model.joints)
        if i and joint.nv
    ]
    wrong = [f"{name!r} ({kind}, {nv})" for _, name, nv, kind in joints if nv != 1]
    if wrong:
        raise URDFError(argument, "joints of one degree of freedom (revolute, continuous, prismatic)", ", ".join(wrong))
    if not joints:
        raise URDFError(argument, "a hand with movable joints", "none at all")
    return tuple(name for _, name, _, _ in sorted(joints))


def couple(argument: str, names: tuple[str, ...], facts: tuple[JointFacts, ...]) -> Coupling:
    """Resolve mimic tags, chains of them too. Raises URDFError for a tag that names no joint, or runs in a circle."""
    n = len(names)
    mimics = {f.name: f.mimic for f in facts if f.mimic is not None}
    independent = tuple(i for i, name in enumerate(names) if name not in mimics)
    C, offset = np.zeros((n, len(independent))), np.zeros(n)
    column = {i: k for k, i in enumerate(independent)}
    for i, name in enumerate(names):
        factor, shift, at, seen = 1.0, 0.0, name, {name}
        while (mimic := mimics.get(at)) is not None:
            if mimic.master is None:
                raise URDFError(
                    argument,
                    f"<mimic> tags that name movable joints among [{', '.join(names)}]",
                    f"{at!r} mimicking {mimic.written!r}",
                )
            if mimic.master in seen:
                raise URDFError(argument, "<mimic> tags that end at a free joint", f"a circle through {at!r}")
            shift += factor * mimic.offset
            factor *= mimic.multiplier
            at = mimic.master
            seen.add(at)
        if not (abs(factor) <= LARGEST_NUMBER and abs(shift) <= LARGEST_NUMBER):  # NaN fails too
            expected = f"<mimic> tags with finite numbers up to {LARGEST_NUMBER:g}, chains of them multiplied"
            raise URDFError(argument, expected, f"{name!r}: {factor:g} × {at} {shift:+g}")
        C[i, column[names.index(at)]] = factor
        offset[i] = shift
    return Coupling(read_only(C), read_only(offset), independent, not mimics)


def _master(written: str, name: str, names: list[str], ancestors: set[str]) -> str | None:
    """The joint a tag means. Prefixed copies of a hand often keep the unprefixed name in the tag ("Left_index_q2"
    mimics "index_q1"): then it is the one joint that ends in the name, the one further up the same finger if there
    are several.
    """
    if written in names:
        return written
    if not written:
        return None
    ends = [other for other in names if other.endswith(written) and other != name]
    if len(ends) > 1:
        ends = [other for other in ends if other in ancestors]
    return ends[0] if len(ends) == 1 else None


def _number(element: ET.Element | None, attribute: str, default: float = math.nan) -> float:
    if element is None:
        return math.nan
    try:
        return float(element.get(attribute, default))
    except ValueError:
        return math.nan


def _vector(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(v) for v in text.split())
    except ValueError:
        return (math.nan, math.nan, math.nan)
    return (x, y, z)
