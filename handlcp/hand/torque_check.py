"""Joint by joint: the torque that holds a grasp, the limit, which joint gives out first, and what that says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.errors import UnknownName
from handlcp.grasp.cause.judge import exceeded, most_used
from handlcp.grasp.cause.wording import needs_more
from handlcp.hand.elasticity.motor import HOLDING, Drives, Motor
from handlcp.record import Record
from handlcp.text_table import TextTable, wrapped
from handlcp.views import view


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
        return bool(exceeded(self.utilisation))


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
        i = most_used(shares)
        return self.joints[i] if shares[i] >= 0 else None

    @property
    def unlimited(self) -> str:
        """What is said where no joint's limit is finite: gears hold, or no joint has a limit."""
        held = [row.joint for row in self if row.held_by == HOLDING and np.isinf(row.limit)]
        if not held:
            return "no joint has a torque limit"
        if len(held) == len(self):
            return "gears hold all joints, whatever their torques"
        return f"gears hold {words.listed(held)}, whatever the torque; no other joint has a torque limit"

    @property
    def over(self) -> tuple[TorqueRow, ...]:
        """The rows of joints asked for more than their limit."""
        return tuple(row for row in self if row.over)

    @property
    def ok(self) -> bool:
        """All limits known (pass `torque_limits`, numpy.inf for none), and none exceeded."""
        return all(self.known) and not np.isnan(self.utilisation).any() and not self.over

    def __iter__(self) -> Iterator[TorqueRow]:
        columns = (a.tolist() for a in (self.torque, self.limit, self.utilisation))
        units = [words.effort_unit(joint in self.sliding) for joint in self.joints]
        motors = (None,) * len(self) if self.drives is None else self.drives.of
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
        unit, size = words.prefixed(max(units, key=len), [10.0 * x for x in (*self.torque.tolist(), *known)])
        if len(units) > 1:
            unit, size = "N·m", 1.0
        limits = [_limit(r._replace(limit=r.limit / size)) for r in self]
        torques = _torques(self.torque / size)
        if len(units) > 1:  # those of joints that slide say their own
            torques = [f"{t} N" if r.unit == "N" else t for t, r in zip(torques, self, strict=True)]
        columns = ([r.joint for r in self], torques, limits, [_share(r) for r in self],
                   [self.remark(r) for r in self])  # fmt: skip
        heads = ("joint", f"torque\n{unit}", f"limit\n{unit}", "of limit", "")
        return TextTable(heads, tuple(zip(*columns, strict=True)), "<>>><")

    def remark(self, row: TorqueRow) -> str:
        """What stands beside a row: over its limit, yields at its limit, closest to its limit; "" for all others. With
        a motor also which torque of it is the limit, and for how long it holds more.
        """
        if row.over and row.known:
            lasts = row.lasts
            return f"holds for {words.duration(lasts)}" if lasts else "over limit"
        if row.joint in self.yielding:
            return "yields"
        closest = row.joint == self.binding and bool(np.isfinite(row.limit))
        return ", ".join([word for word in (row.held_by, "closest" * closest) if word])

    def __str__(self) -> str:
        return f"{self.table}\n{wrapped(self.verdict)}"

    @property
    def verdict(self) -> str:
        """One sentence."""
        if over := self.over:
            return f"{needs_more([r.joint for r in over])}."
        if np.isnan(self.torque).any():
            return "No torques: the grasp was not solved."
        if self.unknown:
            return f"Without a torque limit: {words.listed(self.unknown)}. Pass torque_limits."
        if self.yielding:
            one = len(self.yielding) == 1
            gives = "gives way at its limit" if one else "give way at their limits"
            return f"All joints hold; {words.listed(self.yielding)} {gives}."
        if self.binding is None or not np.isfinite(self[self.binding].limit):
            return f"{self.unlimited[0].upper()}{self.unlimited[1:]}."
        return f"All joints hold; {self.binding} is closest to its limit."

    def __rich__(self) -> Any:
        return view("torque_table")(self)


def torque_check(
    joints: Sequence[str], torque: Array, limit: Array, known: Sequence[bool], yielding: tuple[str, ...] = (),
    sliding: tuple[str, ...] = (), drives: Drives | None = None,
) -> TorqueCheck:  # fmt: skip
    """Compare torques (nv,) with limits (nv,) [N·m]; an infinite limit is never used up. yielding, sliding : names.
    drives : motors behind the limits.
    """
    used = read_only(abs(torque) / limit)
    return TorqueCheck(tuple(joints), torque, limit, used, tuple(known), yielding, sliding, drives)


def _limit(row: TorqueRow) -> str:
    return f"{row.limit:.4g}" if row.known and np.isfinite(row.limit) else "none" if row.known else "unknown"


def _share(row: TorqueRow) -> str:
    return "–" if not row.known or np.isinf(row.limit) else words.percent(row.utilisation)


def _torques(values: Array) -> list[str]:
    """Four decimals, fewer where the largest torque has more than one digit before them."""
    largest = float(np.nanmax(abs(values), initial=0.0))
    decimals = 4 if largest < 9.99995 else 3 if largest < 99.9995 else 2
    return [f"{round(t, decimals) + 0.0:.{decimals}f}" if np.isfinite(t) else "–" for t in values.tolist()]
