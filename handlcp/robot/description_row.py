"""`JointRow`: where the numbers of a hand came from, and what else its file states: rows for a description."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from handlcp.robot.joint import JointFacts
from handlcp.robot.servo_stiffness import ServoStiffness
from handlcp.words import MAX_TEXT_WIDTH, wrap_text

GIVEN_SOURCE, DEFAULT_SOURCE, NO_SOURCE = "given", "default", "nowhere"
_MODEL_SOURCE = "the Pinocchio model"


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


def file_origins(described: RobotDescription, joints: Sequence[str]) -> Iterator[OriginRow]:
    """Of what only a file says. joints : the independent ones."""
    if described.root is None:
        ranges = masses = _MODEL_SOURCE
    else:
        ranges = "range of <joint>" if described.is_mjcf else "<limit lower upper>"
        masses = "<inertial>, or the geoms" if described.is_mjcf else "<inertial mass>"
    kinds = {f.name: f.kind for f in described.facts}
    yield OriginRow("range", tuple(j for j in joints if kinds[j] != "continuous"), ranges)
    followers = tuple(f.name for f in described.facts if f.mimic is not None)
    yield OriginRow("coupling", followers, "<equality><joint>" if described.is_mjcf else "<mimic>")
    yield OriginRow("mass", tuple(k for k, m in described.link_masses.items() if m), masses)


def limit_origins(
    facts: Mapping[str, JointFacts], joints: Sequence[str], given: Sequence[str] = (), drives: Drives | None = None
) -> Iterator[OriginRow]:
    """Where the torque limits of joints come from, one row a source.

    given : the joints whose limit was passed.
    drives : motors, where joints have some.
    """
    found = dict[str, list[str]]()
    motors = (None,) * len(joints) if drives is None else drives.motors
    for joint, motor in zip(joints, motors, strict=True):
        known = 0 < facts[joint].effort < np.inf
        source = GIVEN_SOURCE if joint in given else facts[joint].effort_source if known else NO_SOURCE
        found.setdefault(source if motor is None else _motor_source(motor), []).append(joint)
    for source, names in found.items():
        yield OriginRow("torque limit", tuple(names), source)


def tension_origins(stiffness: TendonStiffness) -> Iterator[OriginRow]:
    """Of limits of tendons, where they have any."""
    found, cables = dict[str, list[str]](), stiffness.cables
    motors = (None,) * len(cables.names) if stiffness.drives is None else stiffness.drives.motors
    each = zip(cables.names, cables.limits.tolist(), stiffness.strength.tolist(), motors, strict=True)
    for name, limit, bears, motor in each:
        if limit < np.inf:
            said = "forcerange of its actuators" if stiffness.is_from_file else GIVEN_SOURCE
            found.setdefault(_motor_source(motor) if motor is not None and limit < bears else said, []).append(name)
    for source, names in found.items():
        yield OriginRow("tension limit", tuple(names), source)


def _motor_source(motor: Motor) -> str:
    return f"its motor, {motor.held_by} torque"


def stiffness_origins(stiffness: Elasticity, joints: Sequence[str]) -> Iterator[OriginRow]:
    """Of the stiffness of joints (nv,)."""
    if isinstance(stiffness, ServoStiffness):
        found = dict[str, list[str]]()
        for j, joint in enumerate(joints):
            by = bool(stiffness.rows[:, j].any()), bool(stiffness.passive[j].any())
            found.setdefault(_STIFFNESS_SOURCES[by], []).append(joint)
        for source, names in found.items():
            yield OriginRow("stiffness", tuple(names), source)
        return
    own = isinstance(stiffness, TendonStiffness) and stiffness.cables.passive.any()
    tendons = f"kp of position actuators, along their tendons{', and springs of joints' if own else ''}"
    yield OriginRow("stiffness", tuple(joints), tendons if stiffness.is_from_file else GIVEN_SOURCE)


_STIFFNESS_SOURCES = {  # by whether servos and springs take part in the stiffness of a joint
    (True, True): "kp of position actuators, and springs of joints",
    (True, False): "kp of position actuators",
    (False, True): "springs of joints",
}


# ---------------------------------------------------------------- What else is stated.

_JointValue = Callable[[JointFacts], Any]
_FRICTION_USE = 'read; used with joint_friction="file"'
_SPRING_USE = 'used with joint_stiffness="file"'
_REST_USE = 'used with joint_stiffness="file", of joints that servos turn'
_SLIDE_UNITS = {"N·m": "N", "N·m/rad": "N/m", "rad": "m", "kg·m²": "kg"}
_STATED_PROPERTIES: tuple[tuple[str, str, str, str, _JointValue, str], ...] = (
    (
        "dry friction",
        "dynamics friction",
        "frictionloss",
        "N·m",
        lambda f: f.properties.friction or None,
        _FRICTION_USE,
    ),
    ("spring at the joint", "", "stiffness", "N·m/rad", lambda f: f.properties.stiffness or None, _SPRING_USE),
    (
        "rest of that spring",
        "",
        "springref",
        "rad",
        lambda f: f.properties.rest if f.properties.stiffness else None,
        _REST_USE,
    ),
    ("armature", "", "armature", "kg·m²", lambda f: f.properties.armature or None, "ignored: nothing accelerates"),
    (
        "soft limits",
        "safety_controller",
        "",
        "rad",
        lambda f: f.properties.soft_limits,
        "read; the range is the limit's",
    ),
    ("reduction", "transmission", "", "", lambda f: f.properties.reduction, "read; limits are the joint's"),
)


def stated_rows(described: RobotDescription) -> Iterator[StatedRow]:
    """Of every joint, those that follow others among them; without what the file leaves out or is no number."""
    for what, urdf, xml, unit, value, used in _STATED_PROPERTIES:
        for slides in (False, True):
            facts = [f for f in described.facts if f.is_slide is slides]
            found = {f.name: v for f in facts if (v := value(f)) is not None}
            values = {name: v for name, v in found.items() if not isinstance(v, float) or not math.isnan(v)}
            if values:
                own = _SLIDE_UNITS.get(unit, unit) if slides else unit
                yield StatedRow(what, xml if described.is_mjcf else urdf, own, values, used)


# ---------------------------------------------------------------- Both, printed.


def origin_lines(origins: Sequence[OriginRow], stated: Sequence[StatedRow]) -> Iterator[str]:
    """In lines of at most 80 columns."""
    rows = [row for row in origins if row.of]
    if rows:
        yield "Where numbers come from"
    for row in rows:
        several = sum(other.number == row.number for other in rows) > 1
        who = f" of {words.list_names(row.of)}" if several else ""
        yield wrap_text(f"{row.number}{who}: {row.source}", "      ", "  ")
    if stated:
        yield "Also stated by the file"
    for s in stated:
        yield wrap_text(f"{s.what}: {_format_values(s)} ({s.tag}; {s.used})", "      ", "  ")


def _format_values(row: StatedRow) -> str:
    """Such as "0.01 N·m, 24 joints", or "0.5 to 2 N·m, 3 joints"."""
    values = list(dict.fromkeys(row.values.values()))
    unit, count = f" {row.unit}" if row.unit else "", len(row.values)
    many = f"{count} joint{'' if count == 1 else 's'}"
    if isinstance(values[0], tuple):
        return many if len(values) > 1 else f"{values[0][0]:.4g} to {values[0][1]:.4g}{unit}, {many}"
    if len(values) == 1:
        return f"{values[0]:.4g}{unit}, {many}"
    return f"{min(values):.4g} to {max(values):.4g}{unit}, {many}"


# ----------------------------------------------------------------
# The rows of a description of a hand, as plain data.


class JointRow(NamedTuple):
    """One independent joint of a hand's description.

    kind : "revolute", "continuous", "prismatic".
    lower, upper [rad, m] : ±inf: no end.
    torque_limit [N·m, N] : None where none is known.
    stiffness [N·m/rad] : its own, the diagonal of a matrix; None where none was said, or a transmission gives way in
        its place.
    fingertips : those that it moves.
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

    arms [m/rad, m/m] : by name of the joints that it moves.
    tension_limit [N] : that it bears and its motor holds for good; None: no limit.
    closes [N] : with which its motor draws it in; None: it has none.
    """

    name: str
    arms: dict[str, float]
    tension_limit: float | None
    closes: float | None


class LinkRow(NamedTuple):
    """One link of a hand's description.

    mass [kg] : 0 where the file says none.
    joint : that carries it, "" for the base.
    geometry : "collision", "visual" or "" for none; collision where it has both.
    """

    name: str
    mass: float
    joint: str
    geometry: str


def tendon_rows(elasticity: Elasticity, joints: Sequence[str]) -> tuple[TendonRow, ...]:
    """Of a hand's transmission; () where it has no tendons. joints (nv,) : names."""
    if not isinstance(elasticity, TendonStiffness):
        return ()
    found = list[TendonRow]()
    numbers = elasticity.arms.tolist(), elasticity.cables.limits.tolist(), elasticity.closing_tensions.tolist()
    for name, arms, limit, closes in zip(elasticity.cables.names, *numbers, strict=True):
        moved = {joint: arm for joint, arm in zip(joints, arms, strict=True) if arm}
        found.append(TendonRow(name, moved, *(None if np.isinf(x) else x for x in (limit, closes))))
    return tuple(found)


# ----------------------------------------------------------------
# A description of a hand, printed in lines of at most 80 columns.

_COLUMN_WIDTHS = (9, 9, 10, 11)  # columns: range from, to; torque limit; stiffness


def format_description(hand: Any) -> str:
    """Write a `HandDescription` as lines of text."""
    x, y, z = (f"{1e3 * s:.0f}" for s in hand.size)
    head = f"{hand.name} ({hand.source})" if hand.name != hand.source else hand.name
    taken = [t for t in hand.fingertips if t.taken]
    fingers = _format_count(len(taken), "fingertip") if taken else "no fingertips chosen"
    facts = f"{_format_count(len(hand.joints), 'joint')}, {fingers}, {hand.mass:.3g} kg, {x} × {y} × {z} mm"
    lines = [wrap_text(head, "    "), wrap_text(facts, "    ")]
    lines += _tip_lines("Fingertips", taken)
    rest = [t for t in hand.fingertips if not t.taken]
    lines += _tip_lines(
        "Could be fingertips too" if taken else "Candidates: pass fingertips=[...] with those meant", rest
    )
    lines += _touch_lines(hand.touching)
    lines += ["", *_joint_lines(hand.joints), *_tendon_lines(hand.tendons)]
    if hand.couplings:
        lines += ["", "Joints that follow others"]
        for c in hand.couplings:
            shift = f" {'-' if c.offset < 0 else '+'} {abs(c.offset):g}" if c.offset else ""
            between = next((chain[1:-1] for chain in hand.chains if chain[0] == c.joint), ())
            by = f" (by {', '.join(between)})" if between else ""
            lines.append(wrap_text(f"{c.joint} = {c.factor:g} × {c.follows}{shift}{by}", "      ", "  "))
    if said := list(origin_lines(hand.origins, hand.stated)):
        lines += ["", *said]
    lines += ["", _link_line(hand.links), wrap_text(f"Audit: {hand.audit.summary}", "    ")]
    return "\n".join(lines)


def _tip_lines(title: str, tips: Sequence[TipRow]) -> Iterator[str]:
    if tips:
        yield ""
        yield title
        for t in tips:
            if t.reason == "named":
                where = f", point ({', '.join(f'{1e3 * v:.1f}' for v in t.point)}) mm" if t.point is not None else ""
                on = f"on {t.link}{where}" if t.link != t.name or where else "the frame of this name"
                yield wrap_text(f"{t.name}: {on}", "      ", "  ")
            else:
                yield wrap_text(f"{t.name}: {t.reason}", "      ", "  ")


def _touch_lines(rows: Sequence[TouchRow]) -> Iterator[str]:
    """Those of equal shapes and pads together."""
    alike = dict[str, list[str]]()
    for row in rows:
        alike.setdefault(f"{' and '.join(row.shapes)}, {_format_pad(row.pad)}", []).append(row.name)
    if alike:
        yield ""
        yield 'What may touch, with links="all" of a grasp'
        for text, names in alike.items():
            yield wrap_text(f"{', '.join(names)}: {text}", "      ", "  ")


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
        return f"box {size(*(2.0 * np.array(g.halfSide).ravel()).tolist())}"
    if isinstance(g, (coal.Cylinder, coal.Capsule)):
        kind = type(g).__name__.lower()
        return f"{kind} of {size(g.radius)} radius, {size(2.0 * g.halfLength)} long"
    if isinstance(g, coal.Ellipsoid):
        return f"ellipsoid with half axes {size(*np.array(g.radii).ravel().tolist())}"
    return f"hull {size(*np.ptp(np.array(g.points()), axis=0).tolist())}"


def _joint_lines(joints: Sequence[JointRow]) -> Iterator[str]:
    """Tables of joints, those of one finger together."""
    sprung = any(j.stiffness is not None for j in joints)
    columns = _COLUMN_WIDTHS if sprung else _COLUMN_WIDTHS[:3]
    widest = max(len(j.name) for j in joints) + 2
    beside = widest + sum(columns) <= MAX_TEXT_WIDTH
    width = widest if beside else MAX_TEXT_WIDTH - sum(columns)
    heads = ["from", "to", "limit", "stiffness"][: len(columns)]
    units = ["rad", "rad", "N·m", "N·m/rad"][: len(columns)]
    yield "Joint".ljust(width) + "".join(h.rjust(w) for h, w in zip(heads, columns, strict=True))
    yield " " * width + "".join(u.rjust(w) for u, w in zip(units, columns, strict=True))
    last: tuple[str, ...] | None = None
    for j in joints:
        if j.fingertips != last:
            last = j.fingertips
            who = last[0] if len(last) == 1 else f"{', '.join(last)}" if last else "no fingertip"
            yield wrap_text(f"moves {who}:", "    ")
        cells = [_format_number(j.lower), _format_number(j.upper), _format_limit(j.torque_limit)]
        cells += [_format_spring(j.stiffness)] if sprung else []
        numbers = "".join(c.rjust(w) for c, w in zip(cells, columns, strict=True))
        unit = " m, N" if j.kind == "prismatic" else ""
        if len(f"  {j.name}{unit}") <= width:
            yield f"  {j.name}{unit}".ljust(width) + numbers
        else:
            yield from (f"  {j.name}{unit}", " " * width + numbers)


def _tendon_lines(rows: Sequence[TendonRow]) -> Iterator[str]:
    """Which joints each moves, and with which tension."""
    if rows:
        yield from ("", "Tendons")
    for t in rows:
        says = [", ".join([f"{joint} by {words.format_length(arm)}" for joint, arm in t.arms.items()])]
        if t.tension_limit is not None:
            says.append(f"at most {words.format_force(t.tension_limit)} for good")
        if t.closes is not None:
            says.append(f"closes with {words.format_force(t.closes)}")
        yield wrap_text(f"{t.name}: {'; '.join(says)}", "      ", "  ")


def _link_line(links: Sequence[Any]) -> str:
    """How many links there are, and which lack geometry or mass."""
    moved = [k for k in links if k.joint]
    bare, light = sum(k.geometry != "collision" for k in moved), sum(not k.mass for k in moved)
    lacks = [f"{n} without {what}" for n, what in ((bare, "collision geometry"), (light, "mass")) if n]
    text = f"{_format_count(len(links), 'link')}, {len(moved)} of them moved by joints"
    return wrap_text(text + (f"; of these, {' and '.join(lacks)}" if lacks else ""), "    ")


def _format_count(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _format_number(x: float) -> str:
    return "no end" if math.isinf(x) else f"{x:.3f}" if abs(x) < 1e3 else f"{x:.3g}"


def _format_limit(x: float | None) -> str:
    return "unknown" if x is None else "none" if math.isinf(x) else f"{x:.4g}"


def _format_spring(x: float | None) -> str:
    return "–" if x is None else "rigid" if math.isinf(x) else f"{x:.3g}"
