"""`JointRow`: where the numbers of a hand came from, and what else its file states: rows for a description."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import coal
import numpy as np

from handlcp import words
from handlcp.actuation.joint_stiffness import Elasticity
from handlcp.actuation.motor import Drives, Motor
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array
from handlcp.robot.description import RobotDescription
from handlcp.robot.fingertip import TipShape
from handlcp.robot.joint import JointFacts, JointProperties
from handlcp.robot.servo_stiffness import ServoStiffness
from handlcp.words import MAX_TEXT_WIDTH, wrap_text

GIVEN_SOURCE, DEFAULT_SOURCE, NO_SOURCE = "given", "default", "nowhere"

# ---------------------------------------------------------------- The rows of a description, as plain data.


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


class JointRow(NamedTuple):
    """One independent joint of a hand's description.

    kind : "revolute", "continuous", "prismatic". lower, upper [rad, m] : ±inf: no end. torque_limit [N·m, N] : None
    where none is known. stiffness [N·m/rad] : its own, the diagonal of a matrix; None where none was said, or a
    transmission gives way in its place. fingertips : those that it moves.
    """

    name: str
    kind: str
    lower: float
    upper: float
    torque_limit: float | None
    stiffness: float | None
    fingertips: tuple[str, ...]


class TipRow(NamedTuple):
    """One fingertip, or what could be one. link : that carries it. point : on the link, in its frame [m]; None: at its
    origin. taken : whether it is a fingertip of the hand. reason : why.
    """

    name: str
    link: str
    point: tuple[float, float, float] | None
    taken: bool
    reason: str


class TouchRow(NamedTuple):
    """What may touch an object: a fingertip, or a link with collision geometry. shapes : its convex shapes, in words.

    pad (3, 3) : flexibility of its surface in its axes [m/N].
    """

    name: str
    shapes: tuple[str, ...]
    pad: Array


class CouplingRow(NamedTuple):
    """joint moves by factor × that of follows, plus offset [rad, m]."""

    joint: str
    follows: str
    factor: float
    offset: float


class TendonRow(NamedTuple):
    """One tendon of a hand's description.

    arms [m/rad, m/m] : by name of the joints that it moves. tension_limit [N] : that it bears and its motor holds for
    good; None: no limit. closes [N] : with which its motor draws it in; None: it has none.
    """

    name: str
    arms: dict[str, float]
    tension_limit: float | None
    closes: float | None


class LinkRow(NamedTuple):
    """One link of a hand's description. mass [kg] : 0 where the file says none. joint : that carries it, "" for the
    base. geometry : "collision", "visual" or "" for none; collision where it has both.
    """

    name: str
    mass: float
    joint: str
    geometry: str


# ---------------------------------------------------------------- Where numbers came from.


def file_origins(described: RobotDescription, joints: Sequence[str]) -> Iterator[OriginRow]:
    """Of what only a file says. joints : the independent ones."""
    if described.root is None:
        ranges = masses = "the Pinocchio model"
    else:
        ranges = "range of <joint>" if described.is_mjcf else "<limit lower upper>"
        masses = "<inertial>, or the geoms" if described.is_mjcf else "<inertial mass>"
    kinds = {f.name: f.kind for f in described.facts}
    yield OriginRow("range", tuple(j for j in joints if kinds[j] != "continuous"), ranges)
    followers = tuple(f.name for f in described.facts if f.mimic is not None)
    yield OriginRow("coupling", followers, "<equality><joint>" if described.is_mjcf else "<mimic>")
    yield OriginRow("mass", tuple(k for k, m in described.link_masses.items() if m), masses)


def _group_by_source(number: str, sources: Iterable[tuple[str, str]]) -> Iterator[OriginRow]:
    """One row a source of a number. sources : joint or tendon, and where its number is from."""
    found = defaultdict[str, list[str]](list)
    for name, source in sources:
        found[source].append(name)
    for source, names in found.items():
        yield OriginRow(number, tuple(names), source)


def limit_origins(
    facts: Mapping[str, JointFacts], joints: Sequence[str], given: Sequence[str] = (), drives: Drives | None = None
) -> Iterator[OriginRow]:
    """Where the torque limits of joints come from. given : the joints whose limit was passed."""
    motors = (None,) * len(joints) if drives is None else drives.motors

    def source(joint: str, motor: Motor | None) -> str:
        if motor is not None:
            return _motor_source(motor)
        known = 0 < facts[joint].effort < np.inf
        return GIVEN_SOURCE if joint in given else facts[joint].effort_source if known else NO_SOURCE

    return _group_by_source("torque limit", [(j, source(j, motor)) for j, motor in zip(joints, motors, strict=True)])


def drive_origins(stiffness: Elasticity, joints: Sequence[str]) -> Iterator[OriginRow]:
    """Where the stiffness of joints (nv,) comes from, and what tendons bear."""
    number = "stiffness"
    if isinstance(stiffness, ServoStiffness):
        by = [(bool(stiffness.rows[:, j].any()), bool(own.any())) for j, own in enumerate(stiffness.passive)]
        sources = [_STIFFNESS_SOURCES[both] for both in by]
        yield from _group_by_source(number, zip(joints, sources, strict=True))
        return
    springs = ""
    if isinstance(stiffness, TendonStiffness):
        springs = ", and springs of joints" if stiffness.cables.passive.any() else ""
        yield from _group_by_source("tension limit", _tension_sources(stiffness))
    tendons = f"kp of position actuators, along their tendons{springs}"
    yield OriginRow(number, tuple(joints), tendons if stiffness.is_from_file else GIVEN_SOURCE)


def _tension_sources(stiffness: TendonStiffness) -> Iterator[tuple[str, str]]:
    """Tendons that have a limit, and where it is from."""
    cables = stiffness.cables
    motors = (None,) * len(cables.names) if stiffness.drives is None else stiffness.drives.motors
    each = zip(cables.names, cables.limits.tolist(), stiffness.strength.tolist(), motors, strict=True)
    for name, limit, bears, motor in each:
        if limit < np.inf:
            said = "forcerange of its actuators" if stiffness.is_from_file else GIVEN_SOURCE
            yield name, _motor_source(motor) if motor is not None and limit < bears else said


def _motor_source(motor: Motor) -> str:
    return f"its motor, {motor.held_by} torque"


_STIFFNESS_SOURCES = {  # by whether servos and springs take part in the stiffness of a joint
    (True, True): "kp of position actuators, and springs of joints",
    (True, False): "kp of position actuators",
    (False, True): "springs of joints",
}


# ---------------------------------------------------------------- What else is stated.

_FRICTION_USE = 'read; used with joint_friction="file"'
_SPRING_USE = 'used with joint_stiffness="file"'
_REST_USE = 'used with joint_stiffness="file", of joints that servos turn'
_SLIDE_UNITS = {"N·m": "N", "N·m/rad": "N/m", "rad": "m", "kg·m²": "kg"}
# What, its tag in a URDF and in an MJCF file, its unit, its value, and what becomes of it
_STATED_PROPERTIES: tuple[tuple[str, str, str, str, Callable[[JointProperties], Any], str], ...] = (
    ("dry friction", "dynamics friction", "frictionloss", "N·m", lambda p: p.friction or None, _FRICTION_USE),
    ("spring at the joint", "", "stiffness", "N·m/rad", lambda p: p.stiffness or None, _SPRING_USE),
    ("rest of that spring", "", "springref", "rad", lambda p: p.rest if p.stiffness else None, _REST_USE),
    ("armature", "", "armature", "kg·m²", lambda p: p.armature or None, "ignored: nothing accelerates"),
    ("soft limits", "safety_controller", "", "rad", lambda p: p.soft_limits, "read; the range is the limit's"),
    ("reduction", "transmission", "", "", lambda p: p.reduction, "read; limits are the joint's"),
)


def stated_rows(described: RobotDescription) -> Iterator[StatedRow]:
    """Of every joint, those that follow others among them; without what the file leaves out or is no number."""
    for what, urdf, mjcf, unit, value, used in _STATED_PROPERTIES:
        for slides in (False, True):
            found = {f.name: value(f.properties) for f in described.facts if f.is_slide is slides}
            stated = {n: v for n, v in found.items() if v is not None and not (isinstance(v, float) and math.isnan(v))}
            if stated:
                own = _SLIDE_UNITS.get(unit, unit) if slides else unit
                yield StatedRow(what, mjcf if described.is_mjcf else urdf, own, stated, used)


def _format_values(row: StatedRow) -> str:
    """Such as "0.01 N·m, 24 joints", or "0.5 to 2 N·m, 3 joints"."""
    values, many = list(dict.fromkeys(row.values.values())), _format_count(len(row.values), "joint")
    if isinstance(values[0], tuple) and len(values) > 1:
        return many
    ends = values[0] if isinstance(values[0], tuple) else sorted({min(values), max(values)})
    return f"{' to '.join(f'{end:.4g}' for end in ends)}{f' {row.unit}' if row.unit else ''}, {many}"


# ---------------------------------------------------------------- A description of a hand, printed in 80 columns.

_COLUMNS = (
    ("from", "rad", 9),
    ("to", "rad", 9),
    ("limit", "N·m", 10),
    ("stiffness", "N·m/rad", 11),
)  # head, unit, width


def format_description(hand: Any) -> str:
    """Write a `HandDescription` as lines of text."""
    x, y, z = (f"{1e3 * s:.0f}" for s in hand.size)
    head = f"{hand.name} ({hand.source})" if hand.name != hand.source else hand.name
    taken, rest = ([t for t in hand.fingertips if t.taken is chosen] for chosen in (True, False))
    fingers = _format_count(len(taken), "fingertip") if taken else "no fingertips chosen"
    facts = f"{_format_count(len(hand.joints), 'joint')}, {fingers}, {hand.mass:.3g} kg, {x} × {y} × {z} mm"
    lines = [wrap_text(head, "    "), wrap_text(facts, "    "), *_section("Fingertips", map(_format_tip, taken))]
    title = "Could be fingertips too" if taken else "Candidates: pass fingertips=[...] with those meant"
    lines += _section(title, map(_format_tip, rest))
    alike = defaultdict[str, list[str]](list)  # those of equal shapes and pads together
    for row in hand.touching:
        alike[f"{' and '.join(row.shapes)}, {_format_pad(row.pad)}"].append(row.name)
    touching = [f"{', '.join(names)}: {text}" for text, names in alike.items()]
    lines += _section('What may touch, with links="all" of a grasp', touching)
    lines += ["", *_joint_lines(hand.joints), *_section("Tendons", map(_format_tendon, hand.tendons))]
    lines += _section("Joints that follow others", [_format_coupling(c, hand.chains) for c in hand.couplings])
    origins = [row for row in hand.origins if row.of]
    count = Counter(row.number for row in origins)
    who = [f" of {words.list_names(row.of)}" if count[row.number] > 1 else "" for row in origins]
    sources = [f"{row.number}{of}: {row.source}" for row, of in zip(origins, who, strict=True)]
    lines += _section("Where numbers come from", sources)
    stated = [f"{row.what}: {_format_values(row)} ({row.tag}; {row.used})" for row in hand.stated]
    lines += _section("Also stated by the file", stated)[1:]  # right below
    return "\n".join([*lines, "", _link_line(hand.links), wrap_text(f"Audit: {hand.audit.summary}", "    ")])


def _section(title: str, rows: Iterable[str]) -> list[str]:
    """A blank line, a heading, and its rows; nothing without rows."""
    wrapped = [wrap_text(row, "      ", "  ") for row in rows]
    return ["", title, *wrapped] if wrapped else []


def _format_tip(tip: TipRow) -> str:
    if tip.reason != "named":
        return f"{tip.name}: {tip.reason}"
    where = "" if tip.point is None else f", point ({', '.join(f'{1e3 * v:.1f}' for v in tip.point)}) mm"
    return f"{tip.name}: {f'on {tip.link}{where}' if tip.link != tip.name or where else 'the frame of this name'}"


def _format_coupling(c: CouplingRow, chains: Sequence[tuple[str, ...]]) -> str:
    shift = f" {'-' if c.offset < 0 else '+'} {abs(c.offset):g}" if c.offset else ""
    between = ", ".join(next((chain[1:-1] for chain in chains if chain[0] == c.joint), ()))
    return f"{c.joint} = {c.factor:g} × {c.follows}{shift}{f' (by {between})' if between else ''}"


def _format_tendon(tendon: TendonRow) -> str:
    """Which joints it moves, and with which tension."""
    said = [", ".join([f"{joint} by {words.format_length(arm)}" for joint, arm in tendon.arms.items()])]
    if tendon.tension_limit is not None:
        said.append(f"at most {words.format_force(tendon.tension_limit)} for good")
    if tendon.closes is not None:
        said.append(f"closes with {words.format_force(tendon.closes)}")
    return f"{tendon.name}: {'; '.join(said)}"


def _format_pad(pad: Array) -> str:
    """Write the flexibility of one pad, a block (3, 3) [m/N]."""
    if not pad.any():
        return "rigid"
    own = pad.diagonal()
    if abs(pad - own[0] * np.eye(3)).max() <= 1e-12 * abs(pad).max():
        return f"pad {words.format_length(float(own[0]))}/N"
    return f"pad up to {words.format_length(float(np.linalg.eigvalsh(pad)[-1]))}/N"


def describe_shape(shape: TipShape) -> str:
    """Such as "box 20 × 30 × 5 mm"; of a mesh its hull."""
    g = shape.geometry

    def size(*metres: float) -> str:
        return f"{' × '.join(f'{1e3 * x:.3g}' for x in metres)} mm"

    if isinstance(g, coal.Sphere):
        return f"ball of {size(g.radius)} radius"
    if isinstance(g, coal.Box):
        return f"box {size(*(2.0 * np.ravel(g.halfSide)).tolist())}"
    if isinstance(g, (coal.Cylinder, coal.Capsule)):
        return f"{type(g).__name__.lower()} of {size(g.radius)} radius, {size(2.0 * g.halfLength)} long"
    if isinstance(g, coal.Ellipsoid):
        return f"ellipsoid with half axes {size(*np.ravel(g.radii).tolist())}"
    return f"hull {size(*np.ptp(np.array(g.points()), axis=0).tolist())}"


def _joint_lines(joints: Sequence[JointRow]) -> Iterator[str]:
    """Tables of joints, those of one finger together."""
    columns = _COLUMNS if any(j.stiffness is not None for j in joints) else _COLUMNS[:3]
    width = min(max(len(j.name) for j in joints) + 2, MAX_TEXT_WIDTH - sum(wide for *_, wide in columns))
    yield "Joint".ljust(width) + "".join(head.rjust(wide) for head, _, wide in columns)
    yield " " * width + "".join(unit.rjust(wide) for _, unit, wide in columns)
    for fingertips, own in groupby(joints, lambda joint: joint.fingertips):
        yield wrap_text(f"moves {', '.join(fingertips) or 'no fingertip'}:", "    ")
        for j in own:
            most, k = j.torque_limit, j.stiffness
            limit = "unknown" if most is None else "none" if math.isinf(most) else f"{most:.4g}"
            spring = "–" if k is None else "rigid" if math.isinf(k) else f"{k:.3g}"
            cells = zip((_format_end(j.lower), _format_end(j.upper), limit, spring), columns, strict=False)
            numbers = "".join(cell.rjust(wide) for cell, (*_, wide) in cells)
            name = f"  {j.name}{' m, N' if j.kind == 'prismatic' else ''}"
            yield from [name.ljust(width) + numbers] if len(name) <= width else [name, " " * width + numbers]


def _format_end(x: float) -> str:
    return "no end" if math.isinf(x) else f"{x:.3f}" if abs(x) < 1e3 else f"{x:.3g}"


def _link_line(links: Sequence[LinkRow]) -> str:
    """How many links there are, and which lack geometry or mass."""
    moved = [k for k in links if k.joint]
    bare, light = sum(k.geometry != "collision" for k in moved), sum(not k.mass for k in moved)
    lacks = [f"{n} without {what}" for n, what in ((bare, "collision geometry"), (light, "mass")) if n]
    text = f"{_format_count(len(links), 'link')}, {len(moved)} of them moved by joints"
    return wrap_text(text + (f"; of these, {' and '.join(lacks)}" if lacks else ""), "    ")


def _format_count(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
