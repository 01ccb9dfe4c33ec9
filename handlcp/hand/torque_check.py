"""`TorqueCheck`: joint by joint the torque that holds a grasp, the limit, and which joint gives out first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components

from handlcp import words
from handlcp.actuation.joint_stiffness import Elasticity
from handlcp.actuation.motor import HOLDING, Drives, Motor
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array, Bools, Ints, read_only
from handlcp.errors import UnknownName
from handlcp.grasp.failure.failure_mode import TENSION, TORQUE, FailureMode, is_exceeded, largest_share_index
from handlcp.grasp.failure.failure_text import describe_torque_excess
from handlcp.grasp.failure.reason import Reason, make_reason
from handlcp.grasp.solution.force_bounds import find_torque_bounds, is_apart, torque_shares
from handlcp.record import Record
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
        "joints",
        "torque_Nm (nv,)",
        "limit_Nm (nv,)",
        "utilisation (nv,)",
        "margin_Nm (nv,)",
        "known",
        "yielding",
        "binding",
        "ok",
        "held_by",
        "lasts_s",
    )

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


def torque_check(
    joints: Sequence[str],
    torque: Array,
    limit: Array,
    known: Sequence[bool],
    yielding: tuple[str, ...] = (),
    sliding: tuple[str, ...] = (),
    drives: Drives | None = None,
) -> TorqueCheck:
    """Compare torques (nv,) with limits (nv,) [N·m]; an infinite limit is never used up. yielding, sliding : names.
    drives : motors behind the limits.
    """
    used = read_only(abs(torque) / limit)
    return TorqueCheck(tuple(joints), torque, limit, used, tuple(known), yielding, sliding, drives)


def _format_torques(values: Array) -> list[str]:
    """Four decimals, fewer where the largest torque has more than one digit before them."""
    largest = float(np.nanmax(abs(values), initial=0.0))
    decimals = 4 if largest < 9.99995 else 3 if largest < 99.9995 else 2
    return [f"{round(t, decimals) + 0.0:.{decimals}f}" if np.isfinite(t) else "–" for t in values.tolist()]


# ----------------------------------------------------------------
# What torques and tensions beside their limits say of a grasp, as reasons of a verdict: joints and tendons alike.


_MAX_UNMADE_SHARE = 0.01  # of a command's largest torque: more than this that nothing makes decides

# ----------------------------------------------------------------
# Of joints and of tendons the same: which is over its limit, and for how long it holds; which is nearest to it; and
# which takes more to close than its motor gives.


class EffortKind(NamedTuple):
    """What efforts are of, joints or tendons, and the words and keys for them.

    member : one of them.
    code : of a `FailureMode`, and of reasons.
    effort, limit : keys of numbers.
    """

    member: str
    code: str
    effort: str
    limit: str

    def reason_values(self, name: str, effort: float, limit: float) -> dict[str, Any]:
        """The values of a reason about one joint or tendon."""
        return {self.member: name, self.effort: effort, self.limit: limit}

    def row_values(self, r: TorqueRow) -> dict[str, Any]:
        """The same of a row of a check."""
        return self.reason_values(r.joint, r.torque, r.limit) | {"utilisation": r.utilisation}


JOINT_EFFORT = EffortKind("joint", TORQUE, "torque_Nm", "limit_Nm")
TENDON_EFFORT = EffortKind("tendon", TENSION, "tension_N", "limit_N")


def torque_reasons(check: TorqueCheck) -> Iterator[Reason]:
    """What a check says about holding: joints over their limit, or the nearest to it; those that yield; the unknown."""
    if check.over:
        yield _over_limit_reason(JOINT_EFFORT, check.over)
    elif check.binding is not None:
        nearest = check[check.binding]
        yield _nearest_limit_reason(JOINT_EFFORT, nearest, "" if np.isfinite(nearest.limit) else check.unlimited)
    if check.yielding:
        yield make_reason("torque", "note", {"yielding": check.yielding}, "yields")
    if check.unknown:
        yield make_reason("limit_unknown", "warning", {"joints": check.unknown})


def tension_reasons(stiffness: TendonStiffness, tension: Array) -> Iterator[Reason]:
    """What tendons say that pull with tension (t,) [N]: those over their limit, or the nearest to it."""
    cables, drives, rows = stiffness.cables, stiffness.drives, list[TorqueRow]()
    motors = (None,) * len(tension) if drives is None else drives.motors
    each = zip(cables.names, tension.tolist(), stiffness.strength.tolist(), cables.limits.tolist(), motors, strict=True)
    for name, t, bears, limit, motor in each:  # a motor counts that holds less for good than the tendon bears
        breaks = limit >= bears or bool(is_exceeded(t / bears))
        most = bears if breaks else limit
        rows.append(TorqueRow(name, t, most, t / most, True, "N", None if breaks else motor))
    if over := [row for row in rows if row.over]:
        yield _over_limit_reason(TENDON_EFFORT, over)
    elif any(np.isfinite(row.limit) for row in rows):
        nearest = largest_share_index(np.array([row.utilisation for row in rows]))
        yield _nearest_limit_reason(TENDON_EFFORT, rows[nearest])


def _over_limit_reason(kind: EffortKind, rows: Sequence[TorqueRow]) -> Reason:
    """Of those over their limits: for a while, where motors hold all of them at their peak, or not at all."""
    values: dict[str, Any] = {f"{kind.member}s": [kind.row_values(r) for r in rows]}
    if any(r.lasts == 0.0 for r in rows):
        needs = [(r.joint, abs(r.torque), r.limit, r.unit) for r in rows]
        return make_reason(f"{kind.code}_over_limit", "decides", values, rows=needs)
    known = [r.lasts for r in rows if r.lasts is not None]
    values["lasts_s"] = min(known) if len(known) == len(rows) else None
    shares = [(r.joint, r.motor.share(r.torque)) for r in rows if r.motor]
    return make_reason("overheats", "decides", values, "" if len(known) == len(rows) else "no time", shares=shares)


def _nearest_limit_reason(kind: EffortKind, r: TorqueRow, unlimited: str = "") -> Reason:
    said = {"member": kind.member, "name": r.joint, "limit": (r.limit, r.unit), "held_by": r.held_by}
    case = "no limit" if unlimited else ""
    return make_reason(kind.code, "note", kind.row_values(r), case, unlimited=unlimited, **said)


def unmade_reasons(
    names: Sequence[str], stiffness: Elasticity, command: Array, sliding: Sequence[str] = ()
) -> Iterator[Reason]:
    """Of a command (nv,) of the joints [rad, m] that tendons, or servos, make only in part: what nothing makes of it
    decides, where it is more than a hundredth. sliding : names of joints that slide.
    """
    left = stiffness.unmade_torque(command)
    if not left.any():
        return
    which, asked = np.flatnonzero(left), stiffness.command_torque(command)
    share, case = float(abs(left).max() / abs(asked).max()), ""
    if isinstance(stiffness, TendonStiffness):
        arms = stiffness.arms.T
        missing = abs(arms @ np.linalg.lstsq(arms, asked)[0] - asked).max()  # if tendons could push, too
        case = "tendons" if missing > _MAX_UNMADE_SHARE * abs(asked).max() else "opposite tendons"
    joints, torques = [names[k] for k in which.tolist()], left[which].tolist()
    values = {"joints": joints, "torques_Nm": torques, "share": share}
    rows = [(name, t, words.effort_unit(name in sliding)) for name, t in zip(joints, torques, strict=True)]
    severity = "decides" if share > _MAX_UNMADE_SHARE else "warning"
    yield make_reason("command_not_made", severity, values, case, rows=rows)


def closing_reasons(
    kind: EffortKind, names: Sequence[str], beyond: Sequence[FailureMode], drives: Drives, sliding: Sequence[str] = ()
) -> Iterator[Reason]:
    """Of joints or tendons that closing took more of than their motors give; beyond : of other kinds, too. sliding :
    names of joints that slide.
    """
    its = [c for c in beyond if c.kind == kind.code]
    if not its:
        return
    at, tendons = [names.index(c.who) for c in its], kind is TENDON_EFFORT
    most = (drives.closing_limits if tendons else drives.peak_limits(np.full(len(names), np.inf)))[at].tolist()
    rows = [
        (c.who, limit * (1.0 - c.margin), limit, words.effort_unit(tendons or c.who in sliding))
        for c, limit in zip(its, most, strict=True)
    ]
    values = {f"{kind.member}s": [kind.reason_values(name, taken, limit) for name, taken, limit, _ in rows]}
    rubs = tendons and bool(drives.friction[at].any())
    yield make_reason("closing_over_peak", "decides", values, "rubs" if rubs else "", rows=rows)


# ----------------------------------------------------------------
# Of torques that forces leave open.


def open_torque_reasons(s: Any) -> Iterator[Reason]:
    """Of a hand's solution that leaves forces open: whether joints are within their limits whatever these are."""
    if s.uniqueness is None or s.uniqueness.forces_determined:
        return
    check, torques = s.torque_check, find_torque_bounds(s)
    open_ = is_apart(torques, s.residuals.force_scale)
    bounds = torque_shares(torques, check.limit)
    values = {
        "joints": [
            {"joint": name, "torque_Nm": both, "utilisation": share}
            for name, both, share, yes in zip(check.joints, torques.tolist(), bounds.tolist(), open_, strict=True)
            if yes
        ]
    }
    if not open_.any():
        yield make_reason("torques_open", "note", values, "none")
        return
    least, most = bounds.T
    doubtful = np.flatnonzero(is_exceeded(most) & ~is_exceeded(least))
    if len(doubtful):
        k = doubtful[largest_share_index(most[doubtful])]
        both, case = bounds[k].tolist(), "" if np.isfinite(most[k]) else "no end"
        said = {"joint": check.joints[k], "both": both, "least": both[0], "more": len(doubtful) - 1}
        yield make_reason("torques_open", "warning", values, case, **said)
    elif not is_exceeded(most).any():
        k = largest_share_index(most)
        yield make_reason("torques_open", "note", values, "within", joint=check.joints[k], most=most[k])


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
        """Joints that move one place that may touch, or are driven together, are of one finger. moves (n, nv) : which
        joint moves which place.
        """
        pulls = np.flatnonzero(asked)
        move, compliance = (
            moves[:, pulls].astype(int),
            elasticity.contact_compliance(np.eye(len(asked)))[np.ix_(pulls, pulls)],
        )
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


def motor_pull_reasons(
    joints: Sequence[str], pulling: MotorPull, shares: Array, stuck: bool, sliding: Sequence[str] = ()
) -> Iterator[Reason]:
    """Of fingers that pull with less than asked for, (nv,) shares, once the hand has closed: they meet nothing, or
    another finger would have to pull harder. stuck : steps of closing found no state in which they do. sliding : names
    of joints that slide.
    """
    if short := pulling.weakest_joints(shares):
        asked = abs(pulling.closing_torque)
        rows = [
            (joints[k], float(shares[k] * asked[k]), float(asked[k]), words.effort_unit(joints[k] in sliding))
            for k in short
        ]
        values = [{"joint": joint, "torque_Nm": torque, "asked_Nm": most} for joint, torque, most, _ in rows]
        beyond = [joints[k] for k in np.flatnonzero(shares > MAX_TORQUE_SHARE).tolist()]
        case = "drives others" if beyond else "stuck" if stuck else ""
        yield make_reason("closing_torque", "warning", {"joints": values}, case, rows=rows, beyond=beyond)
