"""A description of a hand as plain rows, and printed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import coal
import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.robot.source.origins import origin_lines
from handlcp.hand.robot.tip_geometry import TipShape
from handlcp.text_table import WIDTH, wrapped

# ----------------------------------------------------------------
# The rows of a description of a hand, as plain data.


class JointRow(NamedTuple):
    """One independent joint. kind : "revolute", "continuous", "prismatic". lower, upper [rad, m], ±inf: no end.

    torque_limit [N·m, N] : None where none is known. stiffness [N·m/rad] : its own, the diagonal of a matrix; None
    where none was said, or a transmission gives way in its place. fingertips : that it moves.
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
    """One tendon. arms [m/rad, m/m] : by name of the joints that it moves. tension_limit [N] : that it bears and its
    motor holds for good; None: no limit. closes [N] : with which its motor draws it in; None: it has none.
    """

    name: str
    arms: dict[str, float]
    tension_limit: float | None
    closes: float | None


class LinkRow(NamedTuple):
    """One link. mass [kg] : 0 where the file says none. joint : that carries it, "" for the base. geometry :
    "collision", "visual" or "" for none; collision where it has both.
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
    numbers = elasticity.arms.tolist(), elasticity.cables.limits.tolist(), elasticity.closes.tolist()
    for name, arms, limit, closes in zip(elasticity.cables.names, *numbers, strict=True):
        moved = {joint: arm for joint, arm in zip(joints, arms, strict=True) if arm}
        found.append(TendonRow(name, moved, *(None if np.isinf(x) else x for x in (limit, closes))))
    return tuple(found)


# ----------------------------------------------------------------
# A description of a hand, printed in lines of at most 80 columns.

_NUMBERS = (9, 9, 10, 11)  # columns: range from, to; torque limit; stiffness


def text_of(hand: Any) -> str:
    """Of a `HandDescription`."""
    x, y, z = (f"{1e3 * s:.0f}" for s in hand.size)
    head = f"{hand.name} ({hand.source})" if hand.name != hand.source else hand.name
    taken = [t for t in hand.fingertips if t.taken]
    fingers = _many(len(taken), "fingertip") if taken else "no fingertips chosen"
    facts = f"{_many(len(hand.joints), 'joint')}, {fingers}, {hand.mass:.3g} kg, {x} × {y} × {z} mm"
    lines = [wrapped(head, "    "), wrapped(facts, "    ")]
    lines += _tips("Fingertips", taken)
    rest = [t for t in hand.fingertips if not t.taken]
    lines += _tips("Could be fingertips too" if taken else "Candidates: pass fingertips=[...] with those meant", rest)
    lines += _touching(hand.touching)
    lines += ["", *_joints(hand.joints), *_tendons(hand.tendons)]
    if hand.couplings:
        lines += ["", "Joints that follow others"]
        for c in hand.couplings:
            shift = f" {'-' if c.offset < 0 else '+'} {abs(c.offset):g}" if c.offset else ""
            between = next((chain[1:-1] for chain in hand.chains if chain[0] == c.joint), ())
            by = f" (by {', '.join(between)})" if between else ""
            lines.append(wrapped(f"{c.joint} = {c.factor:g} × {c.follows}{shift}{by}", "      ", "  "))
    if said := list(origin_lines(hand.origins, hand.stated)):
        lines += ["", *said]
    lines += ["", _links(hand.links), wrapped(f"Audit: {hand.audit.summary}", "    ")]
    return "\n".join(lines)


def _tips(title: str, tips: Sequence[TipRow]) -> Iterator[str]:
    if tips:
        yield ""
        yield title
        for t in tips:
            if t.reason == "named":
                where = f", point ({', '.join(f'{1e3 * v:.1f}' for v in t.point)}) mm" if t.point is not None else ""
                on = f"on {t.link}{where}" if t.link != t.name or where else "the frame of this name"
                yield wrapped(f"{t.name}: {on}", "      ", "  ")
            else:
                yield wrapped(f"{t.name}: {t.reason}", "      ", "  ")


def _touching(rows: Sequence[TouchRow]) -> Iterator[str]:
    """Those of equal shapes and pads together."""
    alike = dict[str, list[str]]()
    for row in rows:
        alike.setdefault(f"{' and '.join(row.shapes)}, {_pad(row.pad)}", []).append(row.name)
    if alike:
        yield ""
        yield 'What may touch, with links="all" of a grasp'
        for text, names in alike.items():
            yield wrapped(f"{', '.join(names)}: {text}", "      ", "  ")


def _pad(pad: Array) -> str:
    """Of a block (3, 3) [m/N]."""
    if not pad.any():
        return "rigid"
    own = pad.diagonal()
    if abs(pad - own[0] * np.eye(3)).max() <= 1e-12 * abs(pad).max():
        return f"pad {words.length(float(own[0]))}/N"
    return f"pad up to {words.length(float(np.linalg.eigvalsh(pad)[-1]))}/N"


def shape_words(shape: TipShape) -> str:
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


def _joints(joints: Sequence[JointRow]) -> Iterator[str]:
    """Tables of joints, those of one finger together."""
    sprung = any(j.stiffness is not None for j in joints)
    columns = _NUMBERS if sprung else _NUMBERS[:3]
    widest = max(len(j.name) for j in joints) + 2
    beside = widest + sum(columns) <= WIDTH
    width = widest if beside else WIDTH - sum(columns)
    heads = ["from", "to", "limit", "stiffness"][: len(columns)]
    units = ["rad", "rad", "N·m", "N·m/rad"][: len(columns)]
    yield "Joint".ljust(width) + "".join(h.rjust(w) for h, w in zip(heads, columns, strict=True))
    yield " " * width + "".join(u.rjust(w) for u, w in zip(units, columns, strict=True))
    last: tuple[str, ...] | None = None
    for j in joints:
        if j.fingertips != last:
            last = j.fingertips
            who = last[0] if len(last) == 1 else f"{', '.join(last)}" if last else "no fingertip"
            yield wrapped(f"moves {who}:", "    ")
        cells = [_number(j.lower), _number(j.upper), _limit(j.torque_limit)]
        cells += [_spring(j.stiffness)] if sprung else []
        numbers = "".join(c.rjust(w) for c, w in zip(cells, columns, strict=True))
        unit = " m, N" if j.kind == "prismatic" else ""
        if len(f"  {j.name}{unit}") <= width:
            yield f"  {j.name}{unit}".ljust(width) + numbers
        else:
            yield from (f"  {j.name}{unit}", " " * width + numbers)


def _tendons(rows: Sequence[TendonRow]) -> Iterator[str]:
    """Which joints each moves, and with which tension."""
    if rows:
        yield from ("", "Tendons")
    for t in rows:
        says = [", ".join([f"{joint} by {words.length(arm)}" for joint, arm in t.arms.items()])]
        if t.tension_limit is not None:
            says.append(f"at most {words.force(t.tension_limit)} for good")
        if t.closes is not None:
            says.append(f"closes with {words.force(t.closes)}")
        yield wrapped(f"{t.name}: {'; '.join(says)}", "      ", "  ")


def _links(links: Sequence[Any]) -> str:
    """How many links there are, and which lack geometry or mass."""
    moved = [k for k in links if k.joint]
    bare, light = sum(k.geometry != "collision" for k in moved), sum(not k.mass for k in moved)
    lacks = [f"{n} without {what}" for n, what in ((bare, "collision geometry"), (light, "mass")) if n]
    text = f"{_many(len(links), 'link')}, {len(moved)} of them moved by joints"
    return wrapped(text + (f"; of these, {' and '.join(lacks)}" if lacks else ""), "    ")


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _number(x: float) -> str:
    return "no end" if math.isinf(x) else f"{x:.3f}" if abs(x) < 1e3 else f"{x:.3g}"


def _limit(x: float | None) -> str:
    return "unknown" if x is None else "none" if math.isinf(x) else f"{x:.4g}"


def _spring(x: float | None) -> str:
    return "–" if x is None else "rigid" if math.isinf(x) else f"{x:.3g}"
