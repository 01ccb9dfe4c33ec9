"""A hand from numbers: fingers of straight links on a round palm, as a URDF.

Fingers stand on a circle about the palm's z axis and point along +z, or lean out. Their joints turn about the palm's
tangents, positive angles inward. Links are capsules, fingertips balls about the last links' ends. World frame: the
palm's, z = 0 where the fingers stand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, sin
from typing import Any

from handlcp.check import integer
from handlcp.design.by_finger import (
    Pairs,
    Read,
    Row,
    T,
    angle,
    by_finger,
    ends,
    followed,
    for_joints,
    lengths,
    positive,
)
from handlcp.errors import InputError, shown
from handlcp.hand.hand import Hand
from handlcp.keywords import helped
from handlcp.write_file import write_file

LENGTHS: Row = (0.05, 0.04)  # [m]
RANGES = (-0.5, 1.6), (0.0, 1.9)  # [rad] of the first joint of a finger, and of those beyond it
EFFORTS = 0.8, 0.4  # [N·m] likewise
SPEED = 6.0  # [rad/s]
PALM_RADIUS, PALM_HEIGHT, RADIUS = 0.04, 0.020, 0.008  # [m]
DENSITY = {"palm": 1300.0, "link": 3000.0, "tip": 1400.0}  # [kg/m³] about those of the example hands, motors included
MOST = 30  # fingers


@dataclass(frozen=True, slots=True)
class _Finger:
    """The numbers of one finger with k links.

    lengths : (k,) of its links [m].
    radius, tip : of its links and of its fingertip [m].
    out : distance of its base from the palm's axis [m].
    angle : about that axis, from +x [rad].
    tilt : by which it leans outward [rad].
    ranges : (lower, upper) of each of its k joints [rad].
    follow : (k - 1,) turns of each joint beyond the first for each turn of the one before; None: they are free.
    """

    name: str
    lengths: Row
    radius: float
    tip: float
    out: float
    angle: float
    tilt: float
    ranges: Pairs
    follow: Row | None

    @property
    def place(self) -> tuple[float, float]:
        """Where the finger stands on the palm: x and y [m], axes of the palm."""
        return self.out * cos(self.angle), self.out * sin(self.angle)

    @property
    def kinds(self) -> list[str]:
        """What its links are called, from the palm outwards."""
        inner = len(self.lengths) - 2
        if inner < 0:
            return ["proximal"]
        return ["proximal", *(["middle"] if inner == 1 else [f"middle_{i + 1}" for i in range(inner)]), "distal"]


@helped()
def finger_hand(
    fingers: int = 3,
    link_lengths: Any = LENGTHS,
    palm_radius: Any = PALM_RADIUS,
    link_radius: Any = RADIUS,
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
        raise InputError("name", "a name of printable characters", shown(name))
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
    made = _read(integer("fingers", fingers, 1, MOST), given)
    _check_apart(made, "palm_radius" if angles is None else "angles")
    urdf = _urdf(name, made)
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


def _read(n: int, given: Mapping[str, Any]) -> list[_Finger]:
    """The n fingers that the arguments of `finger_hand` describe. Raises InputError, UnknownName."""
    names = [f"finger_{i + 1}" for i in range(n)]

    def each(argument: str, default: Sequence[T], read: Read[T], deep: int = 0) -> list[T]:
        return by_finger(argument, given[argument], names, default, read, deep)

    rows, radii = each("link_lengths", [LENGTHS] * n, lengths, 1), each("link_radius", [RADIUS] * n, positive)
    tips, out = each("tip_radius", radii, positive), each("palm_radius", [PALM_RADIUS] * n, positive)
    about, lean = each("angles", [2 * pi * i / n for i in range(n)], angle), each("tilt", [0.0] * n, angle)
    no_pairs: list[Pairs | None] = [None] * n
    between, follow = each("ranges", no_pairs, ends, 1), each("coupling", [None] * n, followed)
    made = []
    for i, (finger, row) in enumerate(zip(names, rows, strict=True)):
        k, turns, led = len(row), between[i], follow[i]
        if turns is None:
            turns = (RANGES[0], *[RANGES[1]] * (k - 1))
        turns = for_joints(f"ranges[{finger!r}]", turns, k, "pairs of ends")
        if led is not None:
            led = for_joints(f"coupling[{finger!r}]", led, k - 1, "numbers of joints beyond the first")
        made.append(_Finger(finger, row, radii[i], tips[i], out[i], about[i], lean[i], turns, led))
    return made


def _check_apart(fingers: Sequence[_Finger], argument: str) -> None:
    """Check that fingers do not overlap where they stand. Raises InputError."""
    for i, one in enumerate(fingers):
        for other in fingers[:i]:
            (x, y), (a, b) = one.place, other.place
            apart, wide = hypot(x - a, y - b), one.radius + other.radius
            if apart < wide:
                came = f"{other.name} and {one.name} {1e3 * apart:.3g} mm from each other, which overlap"
                expected = f"fingers that stand at least {1e3 * wide:.3g} mm from each other, the width of a link"
                raise InputError(argument, expected, came)


def _urdf(name: str, fingers: Sequence[_Finger]) -> bytes:
    """The text of the hand's file."""
    from handlcp.design.blocks import palm, robot, text

    reach = max(finger.out + finger.radius for finger in fingers)
    base = palm(DENSITY["palm"] * pi * reach**2 * PALM_HEIGHT, reach, PALM_HEIGHT, PALM_HEIGHT / 2)
    return text(robot(name, base, [_parts(finger) for finger in fingers]), "Made by handlcp.finger_hand")


def _parts(finger: _Finger) -> tuple[list[Any], list[Any]]:
    """Links and joints of a finger."""
    from handlcp.design.blocks import link, mount, pose, revolute, tip

    links, joints, follows = list[Any](), list[Any](), None
    parent, at = "palm", pose((*finger.place, 0.0), (0.0, finger.tilt, finger.angle))
    for i, (kind, length) in enumerate(zip(finger.kinds, finger.lengths, strict=True)):
        joint = f"{finger.name}_{kind}"
        if i and finger.follow is not None:
            follows = (joints[-1].name, finger.follow[i - 1])
        axis, effort = (0.0, -1.0, 0.0), EFFORTS[min(i, 1)]
        joints.append(revolute(joint, parent, at, axis, effort, SPEED, finger.ranges[i], follows))
        mass = DENSITY["link"] * pi * finger.radius**2 * length
        links.append(link(f"{joint}_link", mass, finger.radius, length, "z", rounded=True))
        parent, at = f"{joint}_link", pose((0.0, 0.0, length))
    links.append(tip(f"{finger.name}_tip", DENSITY["tip"] * 4 / 3 * pi * finger.tip**3, finger.tip))
    joints.append(mount(finger.name, parent, at))
    return links, joints
