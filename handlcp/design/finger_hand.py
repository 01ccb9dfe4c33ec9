"""`finger_hand`: a hand from numbers, with fingers of straight links on a round palm, as a URDF.

Fingers stand on a circle about the palm's z axis and point along +z, or lean out. Their joints turn about the palm's
tangents, positive angles inward. Links are capsules, fingertips balls about the last links' ends. World frame: the
palm's, z = 0 where the fingers stand.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, radians, sin
from typing import Any, TypeVar

import numpy as np

from handlcp.check import check_array, check_call, check_integer, check_keys, check_number, count_dimensions
from handlcp.errors import InputError, shorten_repr
from handlcp.hand.hand import Hand
from handlcp.write_file import write_file

LINK_LENGTHS: FloatRow = (0.05, 0.04)  # [m]
JOINT_RANGES = (-0.5, 1.6), (0.0, 1.9)  # [rad] of the first joint of a finger, and of those beyond it
EFFORT_LIMITS = 0.8, 0.4  # [N·m] likewise
SPEED_LIMIT = 6.0  # [rad/s]
PALM_RADIUS, PALM_HEIGHT, LINK_RADIUS = 0.04, 0.020, 0.008  # [m]
DENSITIES = {"palm": 1300.0, "link": 3000.0, "tip": 1400.0}  # [kg/m³] about those of the example hands, motors included
MAX_FINGERS = 30  # fingers


@dataclass(frozen=True, slots=True)
class _FingerShape:
    """The numbers of one finger with k links.

    lengths : (k,) of its links [m].
    radius, tip_radius : of its links and of its fingertip [m].
    axis_distance : distance of its base from the palm's axis [m].
    angle : about that axis, from +x [rad].
    tilt : by which it leans outward [rad].
    ranges : (lower, upper) of each of its k joints [rad].
    coupling : (k - 1,) turns of each joint beyond the first for each turn of the one before; None: they are free.
    """

    name: str
    lengths: FloatRow
    radius: float
    tip_radius: float
    axis_distance: float
    angle: float
    tilt: float
    ranges: RangePairs
    coupling: FloatRow | None

    @property
    def base_position(self) -> tuple[float, float]:
        """Where the finger stands on the palm: x and y [m], axes of the palm."""
        return self.axis_distance * cos(self.angle), self.axis_distance * sin(self.angle)

    @property
    def link_names(self) -> list[str]:
        """What its links are called, from the palm outwards."""
        inner = len(self.lengths) - 2
        if inner < 0:
            return ["proximal"]
        return ["proximal", *(["middle"] if inner == 1 else [f"middle_{i + 1}" for i in range(inner)]), "distal"]


@check_call()
def finger_hand(
    fingers: int = 3,
    link_lengths: Any = LINK_LENGTHS,
    palm_radius: Any = PALM_RADIUS,
    link_radius: Any = LINK_RADIUS,
    *,
    tip_radius: Any = None,
    angles: Any = None,
    tilt: Any = 0.0,
    ranges: Any = None,
    coupling: Any = None,
    joint_stiffness: Any = 1.0,
    pad_flexibility: Any = 1e-4,
    torque_limits: Any = None,
    motors: Any = None,
    joint_friction: Any = None,
    name: str = "finger_hand",
    file: Any = None,
) -> Hand:
    """A hand of straight fingers on a round palm, as `Hand.from_urdf` reads it from the URDF that is made here.

    Each number is one of all fingers, a sequence with one for each of them, or a mapping by name, {"finger_1": 0.05},
    whose others have the default. Joints are called finger_1_proximal, finger_1_middle (of four links and more
    finger_1_middle_1, …) and finger_1_distal, their links finger_1_proximal_link, …, fingertips finger_1_tip.

    fingers : how many.
    link_lengths : [m] (k,), from one joint to the next, the last to the fingertip's centre; or such a row for each
        finger, also of other numbers of links.
    palm_radius : [m] of the circle on which fingers stand.
    link_radius : [m].
    tip_radius : [m] None: as the links.
    angles : [rad] where the fingers stand on the circle; None: evenly, from +x on.
    tilt : [rad] by which they lean outward.
    ranges : [rad] (lower, upper) of all joints of all fingers; or for each finger such a pair, or one for each joint.
        None: -0.5 to 1.6 for first joints, 0 to 1.9 for others.
    coupling : how far each joint beyond the first turns for each radian of the one before, a mimic joint; for each
        finger such a number, None, or one for each of these joints. None: they turn as they like.
    joint_stiffness, pad_flexibility, torque_limits, motors, joint_friction : as of `Hand.from_urdf`. Torque limits of
        the URDF are 0.8 N·m for first joints, 0.4 N·m for others.
    name : of the robot.
    file : where the URDF is written as well; None: nowhere.

    Masses follow from 3000 kg/m³ for links with their motors, 1300 kg/m³ for the palm, 20 mm high, and 1400 kg/m³ for
    fingertips. Raises InputError, also for fingers that overlap on the palm; UnknownName.
    """
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        raise InputError("name", "a name of printable characters", shorten_repr(name))
    given = {
        "link_lengths": link_lengths,
        "palm_radius": palm_radius,
        "link_radius": link_radius,
        "tip_radius": tip_radius,
        "angles": angles,
        "tilt": tilt,
        "ranges": ranges,
        "coupling": coupling,
    }
    made = _read_fingers(check_integer("fingers", fingers, 1, MAX_FINGERS), given)
    _check_no_overlap(made, "palm_radius" if angles is None else "angles")
    urdf = _make_urdf(name, made)
    if file is not None:
        write_file("file", file, urdf)
    return Hand.from_urdf(
        urdf.decode(),
        joint_stiffness=joint_stiffness,
        pad_flexibility=pad_flexibility,
        torque_limits=torque_limits,
        motors=motors,
        joint_friction=joint_friction,
    )


def _read_fingers(n: int, given: Mapping[str, Any]) -> list[_FingerShape]:
    """The n fingers that the arguments of `finger_hand` describe. Raises InputError, UnknownName."""
    names = [f"finger_{i + 1}" for i in range(n)]

    def each(argument: str, default: Sequence[T], read: ValueReader[T], deep: int = 0) -> list[T]:
        return read_by_finger(argument, given[argument], names, default, read, deep)

    rows, radii = (
        each("link_lengths", [LINK_LENGTHS] * n, read_link_lengths, 1),
        each("link_radius", [LINK_RADIUS] * n, read_length),
    )
    tips, out = each("tip_radius", radii, read_length), each("palm_radius", [PALM_RADIUS] * n, read_length)
    about, lean = each("angles", [2 * pi * i / n for i in range(n)], read_angle), each("tilt", [0.0] * n, read_angle)
    no_pairs: list[RangePairs | None] = [None] * n
    between, follow = each("ranges", no_pairs, read_ranges, 1), each("coupling", [None] * n, read_coupling)
    made = []
    for i, (finger, row) in enumerate(zip(names, rows, strict=True)):
        k, turns, led = len(row), between[i], follow[i]
        if turns is None:
            turns = (JOINT_RANGES[0], *[JOINT_RANGES[1]] * (k - 1))
        turns = spread_over_joints(f"ranges[{finger!r}]", turns, k, "pairs of ends")
        if led is not None:
            led = spread_over_joints(f"coupling[{finger!r}]", led, k - 1, "numbers of joints beyond the first")
        made.append(_FingerShape(finger, row, radii[i], tips[i], out[i], about[i], lean[i], turns, led))
    return made


def _check_no_overlap(fingers: Sequence[_FingerShape], argument: str) -> None:
    """Check that fingers do not overlap where they stand. Raises InputError."""
    for i, one in enumerate(fingers):
        for other in fingers[:i]:
            (x, y), (a, b) = one.base_position, other.base_position
            apart, wide = hypot(x - a, y - b), one.radius + other.radius
            if apart < wide:
                came = f"{other.name} and {one.name} {1e3 * apart:.3g} mm from each other, which overlap"
                expected = f"fingers that stand at least {1e3 * wide:.3g} mm from each other, the width of a link"
                raise InputError(argument, expected, came)


def _make_urdf(name: str, fingers: Sequence[_FingerShape]) -> bytes:
    """The text of the hand's file."""
    from handlcp.design.urdf_parts import format_urdf, make_palm, make_robot  # yourdfpy: half a second

    reach = max(finger.axis_distance + finger.radius for finger in fingers)
    base = make_palm(DENSITIES["palm"] * pi * reach**2 * PALM_HEIGHT, reach, PALM_HEIGHT, PALM_HEIGHT / 2)
    return format_urdf(
        make_robot(name, base, [_make_finger(finger) for finger in fingers]), "Made by handlcp.finger_hand"
    )


def _make_finger(finger: _FingerShape) -> tuple[list[Any], list[Any]]:
    """Links and joints of a finger."""
    from handlcp.design.urdf_parts import (  # as above
        make_link,
        make_pose,
        make_revolute_joint,
        make_tip,
        make_tip_mount,
    )

    links, joints, follows = list[Any](), list[Any](), None
    parent, at = "palm", make_pose((*finger.base_position, 0.0), (0.0, finger.tilt, finger.angle))
    for i, (kind, length) in enumerate(zip(finger.link_names, finger.lengths, strict=True)):
        joint = f"{finger.name}_{kind}"
        if i and finger.coupling is not None:
            follows = (joints[-1].name, finger.coupling[i - 1])
        axis, effort = (0.0, -1.0, 0.0), EFFORT_LIMITS[min(i, 1)]
        joints.append(make_revolute_joint(joint, parent, at, axis, effort, SPEED_LIMIT, finger.ranges[i], follows))
        mass = DENSITIES["link"] * pi * finger.radius**2 * length
        links.append(make_link(f"{joint}_link", mass, finger.radius, length, "z", rounded=True))
        parent, at = f"{joint}_link", make_pose((0.0, 0.0, length))
    links.append(
        make_tip(f"{finger.name}_tip", DENSITIES["tip"] * 4 / 3 * pi * finger.tip_radius**3, finger.tip_radius)
    )
    joints.append(make_tip_mount(finger.name, parent, at))
    return links, joints


# ----------------------------------------------------------------
# What users pass finger by finger: one value for all, a sequence of as many, or a mapping by name.


_MAX_LENGTH = 1.0  # [m] no link, fingertip or palm is larger
T = TypeVar("T")
ValueReader = Callable[[str, Any], T]
FloatRow = tuple[float, ...]
RangePairs = tuple[tuple[float, float], ...]


def read_by_finger(
    argument: str, value: Any, fingers: Sequence[str], default: Sequence[T], read: ValueReader[T], deep: int
) -> list[T]:
    """One value for each finger, from one for all, a sequence of as many, or a mapping by name.

    argument : what the caller calls the value, for messages.
    value : what the user gave; None: `default`.
    fingers : (n,) names.
    default : (n,) values of fingers that a mapping leaves out.
    read : checks the value of one finger.
    deep : number of dimensions that one finger's plainest value has, such as 0 for a number.

    Raises InputError, UnknownName.
    """
    if value is None:
        return list(default)
    if isinstance(value, Mapping):
        named = check_keys(argument, value, fingers, "a finger")
        every = zip(fingers, default, strict=True)
        return [read(f"{argument}[{f!r}]", named[f]) if f in named else own for f, own in every]
    if not isinstance(value, (Sequence, np.ndarray)) or isinstance(value, str) or count_dimensions(value) in (0, deep):
        return [read(argument, value)] * len(fingers)
    if len(value) != len(fingers):
        raise InputError(
            argument, f"one for all {len(fingers)} fingers, or as many, or a mapping by finger", repr(value)[:80]
        )
    return [read(f"{argument}[{i}]", one) for i, one in enumerate(value)]


def read_length(argument: str, value: Any) -> float:
    """A length above 0 [m], refused where millimetres seem to be meant. Raises InputError."""
    length = check_number(argument, value, above=0.0)
    if length > _MAX_LENGTH:
        expected = f"a length in metres of at most {_MAX_LENGTH:g} (if millimetres are meant, {length / 1e3:g})"
        raise InputError(argument, expected, f"{length:g}")
    return length


def read_angle(argument: str, value: Any) -> float:
    """An angle of at most one turn [rad], refused where degrees seem to be meant. Raises InputError."""
    turn = check_number(argument, value)
    if abs(turn) > 2.0 * pi:
        expected = f"an angle in radians of at most one turn (if degrees are meant, {radians(turn):.4g})"
        raise InputError(argument, expected, f"{turn:g}")
    return turn


def read_link_lengths(argument: str, value: Any) -> FloatRow:
    """Lengths (k,) of the k ≥ 1 links of a finger [m]. Raises InputError."""
    row = check_array(argument, value, (-1,), what="lengths of the links of a finger [m]")
    if not len(row):
        raise InputError(argument, "lengths of the links of a finger [m], at least one", "none")
    return tuple([read_length(f"{argument}[{i}]", x) for i, x in enumerate(row.tolist())])


def read_ranges(argument: str, value: Any) -> RangePairs:
    """Lower and upper end [rad] of each joint of a finger, one pair of all of them. Raises InputError."""
    rows = check_array(argument, value, (2,), (-1, 2), what="lower and upper ends of the joints' ranges [rad]").reshape(
        -1, 2
    )
    if not len(rows) or not (rows[:, 0] < rows[:, 1]).all():
        raise InputError(argument, "a lower end below the upper end [rad]", repr(value)[:80])
    return tuple([(read_angle(argument, low), read_angle(argument, high)) for low, high in rows.tolist()])


def read_coupling(argument: str, value: Any) -> FloatRow | None:
    """How far each joint beyond the first turns for each radian of the one before [-], or one number for all of them.

    None: these joints are free. Raises InputError.
    """
    if value is None:
        return None
    return tuple(check_array(argument, value, (), (-1,)).reshape(-1).tolist())


def spread_over_joints(argument: str, value: tuple[T, ...], count: int, what: str) -> tuple[T, ...]:
    """One value for each of so many joints, from as many or from one of all. Raises InputError."""
    every = value * count if len(value) == 1 else value
    if len(every) != count:
        raise InputError(argument, f"{what}: one for all, or {count} of them", f"{len(value)}")
    return every
