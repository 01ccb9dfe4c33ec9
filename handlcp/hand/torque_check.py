"""`TorqueCheck`: joint by joint the torque that holds a grasp, the limit, and which joint gives out first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components

from handlcp import words
from handlcp.actuation.joint_stiffness import Elasticity
from handlcp.actuation.motor import HOLDING, Drives, Motor
from handlcp.check import Array, Bools, Ints, read_only
from handlcp.errors import UnknownName
from handlcp.grasp.failure.failure_mode import is_exceeded, largest_share_index
from handlcp.grasp.failure.failure_text import describe_torque_excess
from handlcp.record import Record
from handlcp.robot.hand_model import HandModel
from handlcp.words import TextTable, wrap_text


class TorqueRow(NamedTuple):
    """One joint, or likewise one tendon with its tension. torque, limit [N·m] (N for a prismatic joint); utilisation
    [-]; known: whether the limit is. unit : "N·m" or "N". motor : of the joint, whose limit is what it holds for good;
    None: a limit alone.
    """

    joint: str
    torque: float
    limit: float
    utilisation: float
    known: bool
    unit: str = "N·m"
    motor: Motor | None = None

    @property
    def held_by(self) -> str:
        """What the limit is: "continuous", of the motor, or "holding", of its gear; "" of a joint without a motor."""
        return "" if self.motor is None else self.motor.held_by

    @property
    def lasts(self) -> float | None:
        """[s] how long this torque is held, begun cold (`Motor.lasts`): inf within the limit, 0 beyond what a motor
        gives at all and beyond a limit without one; None where a motor's thermal time is not known.
        """
        if not self.over:
            return np.inf
        return 0.0 if self.motor is None else self.motor.lasts(self.torque)

    @property
    def over(self) -> bool:
        """Whether the joint needs more than its limit."""
        return bool(is_exceeded(self.utilisation))


@dataclass(frozen=True, slots=True)
class TorqueCheck(Record):
    """Torques against limits; iterates over `TorqueRow`s and prints as a table.

    joints : nv names. torque : (nv,) [N·m]. limit : (nv,) [N·m], inf where there is none or none is known.
    utilisation : (nv,) |torque| / limit, a finite number always (NaN if the torque is): 0 where the limit is infinite
        or unknown.
    known : nv booleans.
    yielding : names of the joints at their limit that give way there (`TorqueSaturation`); their utilisation is 1.
    sliding : names of prismatic joints, whose torque, limit and margin are forces [N].
    drives : the motors of the joints; None where none has one.
    """

    entries = (
        "joints", "torque_Nm (nv,)", "limit_Nm (nv,)", "utilisation (nv,)", "margin_Nm (nv,)", "known", "yielding",
        "binding", "ok", "held_by", "lasts_s",
    )  # fmt: skip

    joints: tuple[str, ...]
    torque: Array
    limit: Array
    utilisation: Array
    known: tuple[bool, ...]
    yielding: tuple[str, ...] = ()
    sliding: tuple[str, ...] = ()
    drives: Drives | None = None

    @property
    def held_by(self) -> tuple[str, ...]:
        """(nv,) "continuous", "holding", or "" of a joint without a motor."""
        return tuple([row.held_by for row in self])

    @property
    def lasts(self) -> tuple[float | None, ...]:
        """(nv,) [s] how long each torque is held, as in `TorqueRow`."""
        return tuple([row.lasts for row in self])

    @property
    def unknown(self) -> tuple[str, ...]:
        """The joints whose limit is not known."""
        return tuple(name for name, known in zip(self.joints, self.known, strict=True) if not known)

    @property
    def binding(self) -> str | None:
        """The joint with the highest utilisation among the known limits; None when no limit is known."""
        shares = np.where(self.known & np.isfinite(self.utilisation), self.utilisation, -1.0)
        i = largest_share_index(shares)
        return self.joints[i] if shares[i] >= 0 else None

    @property
    def unlimited(self) -> str:
        """What is said where no joint's limit is finite: gears hold, or no joint has a limit."""
        held = [row.joint for row in self if row.held_by == HOLDING and np.isinf(row.limit)]
        if not held:
            return "no joint has a torque limit"
        if len(held) == len(self):
            return "gears hold all joints, whatever their torques"
        return f"gears hold {words.list_names(held)}, whatever the torque; no other joint has a torque limit"

    @property
    def over(self) -> tuple[TorqueRow, ...]:
        """The rows of joints asked for more than their limit."""
        return tuple(row for row in self if row.over)

    @property
    def ok(self) -> bool:
        """All limits known (pass `torque_limits`, numpy.inf for none), and none exceeded. False also where a limit is
        not known: a verdict then warns and may be HELD, since `over` decides there.
        """
        return all(self.known) and not np.isnan(self.utilisation).any() and not self.over

    def __iter__(self) -> Iterator[TorqueRow]:
        columns = (a.tolist() for a in (self.torque, self.limit, self.utilisation))
        units = [words.effort_unit(joint in self.sliding) for joint in self.joints]
        motors = (None,) * len(self) if self.drives is None else self.drives.motors
        return map(TorqueRow, self.joints, *columns, self.known, units, motors)

    def __len__(self) -> int:
        return len(self.joints)

    def __getitem__(self, joint: str) -> TorqueRow:
        if joint not in self.joints:
            raise UnknownName("joint", "a joint", [str(joint)], self.joints)
        return next(row for row in self if row.joint == joint)

    @property
    def margin(self) -> Array:
        """(nv,) N·m, how much more torque each joint has: limit - |torque|, below 0 where it would need more than it
        has; inf where there is no limit or none is known.
        """
        return read_only(self.limit - abs(self.torque))

    @property
    def table(self) -> TextTable:
        """Joint by joint, with a remark in the last column."""
        known = [limit for limit in self.limit.tolist() if np.isfinite(limit)]
        units = {row.unit for row in self}
        unit, size = words.choose_prefix(max(units, key=len), [10.0 * x for x in (*self.torque.tolist(), *known)])
        if len(units) > 1:
            unit, size = "N·m", 1.0
        limits = [f"{r.limit / size:.4g}" if np.isfinite(r.limit) else "none" for r in self]
        limits = [text if r.known else "unknown" for text, r in zip(limits, self, strict=True)]
        shares = ["–" if not r.known or np.isinf(r.limit) else words.format_percent(r.utilisation) for r in self]
        torques = _format_torques(self.torque / size)
        if len(units) > 1:  # those of joints that slide say their own
            torques = [f"{t} N" if r.unit == "N" else t for t, r in zip(torques, self, strict=True)]
        columns = ([r.joint for r in self], torques, limits, shares, [self.remark(r) for r in self])
        heads = ("joint", f"torque\n{unit}", f"limit\n{unit}", "of limit", "")
        return TextTable(heads, tuple(zip(*columns, strict=True)), "<>>><")

    def remark(self, row: TorqueRow) -> str:
        """What stands beside a row: over its limit, yields at its limit, closest to its limit; "" for all others. With
        a motor also which torque of it is the limit, and for how long it holds more.
        """
        if row.over and row.known:
            lasts = row.lasts
            return f"holds for {words.format_duration(lasts)}" if lasts else "over limit"
        if row.joint in self.yielding:
            return "yields"
        closest = row.joint == self.binding and bool(np.isfinite(row.limit))
        return ", ".join([word for word in (row.held_by, "closest" * closest) if word])

    def __str__(self) -> str:
        return f"{self.table}\n{wrap_text(self.verdict)}"

    @property
    def verdict(self) -> str:
        """One sentence about the torques beside their limits."""
        if over := self.over:
            return f"{describe_torque_excess([r.joint for r in over])}."
        if np.isnan(self.torque).any():
            return "No torques: the grasp was not solved."
        if self.unknown:
            return f"Without a torque limit: {words.list_names(self.unknown)}. Pass torque_limits."
        if self.yielding:
            one = len(self.yielding) == 1
            gives = "gives way at its limit" if one else "give way at their limits"
            return f"All joints hold; {words.list_names(self.yielding)} {gives}."
        if self.binding is None or not np.isfinite(self[self.binding].limit):
            return f"{self.unlimited[0].upper()}{self.unlimited[1:]}."
        return f"All joints hold; {self.binding} is closest to its limit."

    def __rich__(self) -> Any:
        from handlcp.viz import torque_table  # for rich alone

        return torque_table(self)


def compare_with_limits(hand: HandModel, torque: Array, yielding: tuple[str, ...] = ()) -> TorqueCheck:
    """Compare torques (nv,) [N·m] with the limits of a hand, at which some joints yield; infinite ones never count."""
    limits = hand.torques
    used, known, drives = read_only(abs(torque) / limits.limits), limits.known, limits.drives
    return TorqueCheck(hand.joint_names, torque, limits.limits, used, known, yielding, hand.sliding, drives)


def _format_torques(values: Array) -> list[str]:
    """Four decimals, fewer where the largest torque has more than one digit before them."""
    largest = float(np.nanmax(abs(values), initial=0.0))
    decimals = 4 if largest < 9.99995 else 3 if largest < 99.9995 else 2
    return [f"{round(t, decimals) + 0.0:.{decimals}f}" if np.isfinite(t) else "–" for t in values.tolist()]


# ----------------------------------------------------------------
# What the joints of a hand pull with where it has closed, beside the closing torque that was asked for.


MIN_TORQUE_SHARE = 0.8  # of the closing torque: a finger none of whose joints pulls with as much is named
MAX_TORQUE_SHARE = 1.05  # of its torque: a joint that pulls with more is driven by other fingers


@dataclass(frozen=True, eq=False)
class MotorPull:
    """What motors pull with where a closing torque was asked of them.

    closing_torque (nv,) : the torques that were asked of the joints [N·m], with their signs, 0 of joints that do not
        pull.
    fingers (nv,) : number of each joint's finger, -1 of those.
    """

    closing_torque: Array
    fingers: Ints
    elasticity: Elasticity

    @classmethod
    def from_torque(cls, asked: Array, moves: Bools, elasticity: Elasticity) -> MotorPull:
        """Joints that move one place that may touch (moves (n, nv)), or are driven together, are of one finger."""
        pulls = np.flatnonzero(asked)
        move = moves[:, pulls].astype(int)
        compliance = elasticity.contact_compliance(np.eye(len(asked)))[np.ix_(pulls, pulls)]
        fingers = np.full(len(asked), -1)
        if len(pulls):
            fingers[pulls] = connected_components((move.T @ move > 0) | (compliance != 0.0), directed=False)[1]
        return cls(asked, fingers, elasticity)

    @property
    def finger_numbers(self) -> list[int]:
        """Numbers of the fingers."""
        return list(range(int(self.fingers.max(initial=-1)) + 1))

    def torque_shares(self, torque: Array, command: Array) -> Array:
        """(nv,) of the torque asked for that actuators pull with; 0 of other joints. torque (nv,) : of the joints
        [N·m]. command (nv,) : how far they are commanded beyond the grasp's posture [rad, m].
        """
        asked = np.where(self.closing_torque != 0.0, self.closing_torque, 1.0)
        return np.where(self.closing_torque != 0.0, self.elasticity.actuator_torque(torque, command) / asked, 0.0)

    def weakest_joints(self, shares: Array) -> list[int]:
        """Of each finger none of whose joints keeps enough, the joint that keeps most."""
        most = [int(np.where(self.fingers == finger, shares, -np.inf).argmax()) for finger in self.finger_numbers]
        return [j for j in most if shares[j] < MIN_TORQUE_SHARE]
