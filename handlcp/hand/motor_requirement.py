"""`RequiredTorque`: what motors have to give for joints and tendons, and with which gear they do.

    peak = max(closing + τ_f, largest - τ_f),    continuous = held - τ_f
    N η ≥ max(peak / τ_peak, continuous / τ_continuous)

τ_f is the dry friction of a drive, in newtons at a tendon: of the hand's own, or of the motor that takes its place. It
is against closing, and carries its part of what is held. `held` is nothing where a gear carries all of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.actuation.motor import Drives, Motor
from handlcp.check import Array, Bools, check_array, check_keys, check_method_calls, check_number, read_only
from handlcp.errors import InputError
from handlcp.grasp.derivatives.parameter.joint import with_torque_limits
from handlcp.grasp.failure.failure_mode import is_exceeded
from handlcp.grasp.failure.failure_text import describe_torque_excess
from handlcp.grasp.model.request import GraspSpec, rebuild
from handlcp.grasp.solution.verdict import HELD
from handlcp.hand.mechanism import hand_mechanism
from handlcp.hand.request import GraspRequest
from handlcp.record import Record, columns_from_arrays, pick_entries, rows_from_columns, to_plain
from handlcp.words import TextTable, wrap_text

_TENSION_ROUNDING = 1e-6  # of the largest tension: less is rounding


def peak_effort(closing: Array, largest: Array, drives: Drives | None) -> Array:
    """(k,) that each motor gives for a moment, where the largest effort is (k,) while it closes and (k,) at all."""
    rubs = _drive_friction(drives)
    return read_only(np.maximum(closing + rubs, largest - rubs))


def continuous_effort(held: Array, drives: Drives | None) -> Array:
    """(k,) that each motor gives for good, where (k,) is held [N·m, N]."""
    carried = np.zeros(len(held))
    if drives is not None:
        carried = np.array([0.0 if m is None else m.holding or 0.0 for m in drives.motors])
    return read_only(np.where(held <= carried, 0.0, np.maximum(held - _drive_friction(drives), 0.0)))


def least_reductions(motor: Motor, closing: Array, largest: Array, held: Array) -> Array:
    """(k,) the least reduction with which a motor does for these efforts, (k,) each [N·m, N]. Raises InputError."""
    if not isinstance(motor, Motor):
        raise InputError("motor", "a Motor", repr(motor)[:80])
    bought, own = Drives((motor,) * len(held)), replace(motor, reduction=1.0, friction=0.0, holding=None)
    return read_only(
        np.maximum(peak_effort(closing, largest, bought) / own.at_peak, continuous_effort(held, bought) / own.for_good)
    )


def _drive_friction(drives: Drives | None) -> Array | float:
    return 0.0 if drives is None else drives.friction


@dataclass(frozen=True, slots=True, eq=False)
class RequiredTension:
    """What tendons pull with, under any load of a brief, from the first touch to the whole load; how much harder than
    at first, of those that are taut whatever comes.

    tendons : t names. tension, held : (t,) [N] the largest, and the largest under any whole load, 0 where a tendon only
    lets go. least : (t,) [N] the smallest; below 0 the tendon goes slack, and as much more of pretension keeps it taut:
    half of it does where an equal one works against it. moved : joints that tendons with motors move. drives : motors
    of the tendons, whose dry friction counts in what they give; None: none are known.
    """

    tendons: tuple[str, ...]
    tension: Array
    held: Array
    least: Array
    moved: tuple[str, ...] = ()
    drives: Drives | None = None

    @property
    def peak(self) -> Array:
        """(t,) [N] that each motor gives at the tendon for a moment: `tension`, and the drive's dry friction."""
        return peak_effort(self.tension, self.tension, self.drives)

    @property
    def continuous(self) -> Array:
        """(t,) [N] that each motor gives at the tendon for good, as of joints."""
        return continuous_effort(self.held, self.drives)

    def reductions(self, motor: Motor) -> Array:
        """(t,) the least reduction [N/(N·m)] with which this motor serves at each tendon, as of joints. Raises
        InputError.
        """
        return least_reductions(motor, self.tension, self.tension, self.held)

    @property
    def slack(self) -> tuple[str, ...]:
        """Those that go slack, by more than rounding."""
        size = _TENSION_ROUNDING * float(self.tension.max(initial=0.0))
        return tuple([name for name, least in zip(self.tendons, self.least.tolist(), strict=True) if least < -size])

    @property
    def table(self) -> TextTable:
        """The table of the tensions, one tendon a row."""
        numbers = words.format_column(self.peak.tolist()), words.format_column(self.continuous.tolist())
        says = [
            f"goes slack; {words.format_force(-low)} more of pretension at most keep it taut"
            if name in self.slack
            else ""
            for name, low in zip(self.tendons, self.least.tolist(), strict=True)
        ]
        every = tuple(zip(self.tendons, *numbers, says, strict=True))
        return TextTable(("tendon", "peak\nN", "continuous\nN", ""), every, "<>><")

    def to_dict(self) -> list[dict[str, Any]]:
        """A dictionary for each tendon."""
        lines = ["tendon = tendons", *[f"{n}_N = {n}" for n in ("tension", "held", "peak", "continuous", "least")]]
        found: list[dict[str, Any]] = to_plain(rows_from_columns(columns_from_arrays(self, *lines)))
        return found


# ----------------------------------------------------------------
# A brief: the loads that a grasp has to hold, each multiplied by a safety factor, and the grasp under each of them.

_LOAD_PARTS = ("load", "mass", "gravity")
_SINGLE_LOAD_NAME = "the load"


class LoadCase(NamedTuple):
    """One load of a brief. name : what it is called. spec : the grasp under this load times the safety factor, weight
    of the object included, without torque limits.
    """

    name: str
    spec: GraspSpec


def read_load_cases(spec: GraspSpec, loads: Any, safety: Any) -> tuple[LoadCase, ...]:
    """The loads of a brief, as `HandGrasp.required_torque` takes them. Raises InputError, UnknownName."""
    factor = check_number("safety", safety, above=0.0)
    bare = with_torque_limits(spec, np.full(len(hand_mechanism(spec).names), np.inf))
    shapes = ((6,),) if spec.plane is None else ((6,), (3,))
    named = list[tuple[str, dict[str, Any]]]()  # of each load what it says of load, mass and gravity
    if loads is None:
        named.append((_SINGLE_LOAD_NAME, {}))
    elif isinstance(loads, Mapping):
        for name, value in loads.items():
            argument = f"loads[{name!r}]"
            if isinstance(value, Mapping):
                named.append((str(name), check_keys(argument, value, _LOAD_PARTS, "a part of a load")))
            else:
                named.append((str(name), {"load": check_array(argument, value, *shapes)}))
    else:
        both = [one for shape in shapes for one in (shape, (-1, *shape))]
        rows = np.atleast_2d(check_array("loads", loads, *both, what="loads (m, 6) or by name: finite numbers"))
        named += [(f"load {k}" if len(rows) > 1 else _SINGLE_LOAD_NAME, {"load": row}) for k, row in enumerate(rows, 1)]
    if not named:
        raise InputError("loads", "at least one load", "none")
    return tuple([LoadCase(name, _apply_load(bare, said, factor)) for name, said in named])


def _apply_load(spec: GraspSpec, said: dict[str, Any], factor: float) -> GraspSpec:
    """The grasp under this load times the factor; what is not said stays as the grasp has it."""
    mechanism = hand_mechanism(spec)
    target = mechanism.target
    own: Array = spec.wrench - mechanism.weight_of_object(spec.reference)
    given: dict[str, Any] = {"load": factor * np.asarray(said.get("load", own), dtype=float)}
    mass = said.get("mass", None if target is None else target.mass)
    if "mass" in said or mass:
        given["mass"] = factor * check_number("mass", mass, minimum=0.0)
    if "gravity" in said:
        given["gravity"] = said["gravity"]
    return rebuild(spec, given, GraspRequest)


# ----------------------------------------------------------------
# What motors a brief takes, as data and as a table.


@check_method_calls
@dataclass(frozen=True, slots=True, eq=False)
class RequiredTorque(Record):
    """The torque that each joint needs so that every load of a brief, times the safety factor, holds.

    joints : nv names. torque : (nv,) [N·m] (N for a prismatic joint), the largest of each joint under any load, from
        the first touch to the whole load. closing : (nv,) the largest that pulls at it while the hand closes, dry
        friction of the joint included and that of its drive not. held : (nv,) the largest under any whole load. NaN
        where no grip was found that holds.
    grip : normal force [N] to command at each fingertip, by name, `grip_force=` of `state.grasp`; where nothing holds,
        the grip that got furthest.
    sized_by : for each joint the load that needs most of it, or "squeeze": closing the hand does.
    loads : m names. torques : (m, nv) [N·m] the same under each load. safety : factor on loads and weight.
    limits : (nv,) of the hand as it is [N·m], inf where there is none or none is known. known : nv booleans. drives :
        its motors, whose dry friction counts in what they give; None: none are known.
    verdicts : what `check()` says of each load, with `torque` as the limits. reasons : of each load that is not HELD,
        why; the answer is confirmed only where there is none.
    tensions : of a hand with `Tendons`, what they pull with; None: it has none. sliding : names of joints that slide,
        whose torques are forces [N].
    fails : the largest share of the grip that was tried and does not hold; None: none was found, because less grip
        needs as much torque. lost : the load that this share does not hold, and why; where nothing holds, those of
        `grip`.
    """

    entries = (
        "holds", "confirmed", "enough", "safety", "grip_N", "verdicts", "reasons", "fails_at_share_of_grip = fails",
    )  # fmt: skip

    joints: tuple[str, ...]
    torque: Array
    closing: Array
    held: Array
    grip: dict[str, float]
    sized_by: tuple[str, ...]
    loads: tuple[str, ...]
    torques: Array = field(repr=False)
    safety: float
    limits: Array
    known: tuple[bool, ...]
    verdicts: dict[str, str]
    fails: float | None
    lost: tuple[str, str] | None
    reasons: dict[str, str] = field(default_factory=dict)
    drives: Drives | None = None
    tensions: RequiredTension | None = None
    sliding: tuple[str, ...] = ()

    @property
    def peak(self) -> Array:
        """(nv,) [N·m] that each motor gives at the joint for a moment: `closing` and the drive's dry friction, or
        `torque` less that, whichever is larger.
        """
        return peak_effort(self.closing, self.torque, self.drives)

    @property
    def _largest(self) -> Array:
        return np.maximum(self.torque, self.closing)

    @property
    def continuous(self) -> Array:
        """(nv,) [N·m] that each motor gives at the joint for good: `held`, less what dry friction holds of it, and
        nothing where a gear carries all of it.
        """
        return continuous_effort(self.held, self.drives)

    def reductions(self, motor: Motor) -> Array:
        """(nv,) the least reduction N with which this motor serves at each joint, in place of the hand's own: N η is at
        least peak and continuous of the joint, with the motor's dry friction and `holding`, over those of the motor.
        Torques and grip are those of the hand with its own friction, on which they depend: pass the hand motors with
        that of the one to buy. Its own reduction is left out. NaN of joints that tendons with motors move. Raises
        InputError.
        """
        moved = () if self.tensions is None else self.tensions.moved
        own = np.array([joint not in moved for joint in self.joints])
        return read_only(np.where(own, least_reductions(motor, self.closing, self.torque, self.held), np.nan))

    @property
    def holds(self) -> bool:
        """Whether there is a grip with which every load can be followed to its end."""
        return not bool(np.isnan(self.torque).any())

    @property
    def confirmed(self) -> bool:
        """Whether there is such a grip, and `check()` says HELD of every load with it."""
        return self.holds and all(word == HELD for word in self.verdicts.values())

    @property
    def enough(self) -> bool:
        """Whether the hand's own limits are enough: all of them known, none below the torque, the answer confirmed."""
        return self.confirmed and all(self.known) and not self.weak

    @property
    def weak(self) -> tuple[str, ...]:
        """The joints whose own limit is below the torque, or below what closes them."""
        return tuple([name for name, short in zip(self.joints, self._is_too_weak, strict=True) if short])

    @property
    def _is_too_weak(self) -> Bools:
        if self.drives is None:
            return np.asarray(is_exceeded(self._largest / self.limits))
        closes = np.where(np.isfinite(self.drives.closing_limits), self.drives.closing_limits, self.limits)
        gives = np.maximum(self.limits, closes + 2.0 * self.drives.friction)  # peak, and friction that helps
        for_a_moment = is_exceeded(self.torque / gives) | is_exceeded(self.closing / closes)
        return np.asarray(for_a_moment | is_exceeded(self.held / self.limits))

    @property
    def rows(self) -> tuple[tuple[str, ...], ...]:
        """Of each joint, to print: name, peak, continuous and limit [N·m], those of slides with their own unit where
        others turn, share of the limit, what sizes the peak, remark.
        """
        peak, held, rows = words.format_column(self.peak), words.format_column(self.continuous), []
        used = self._largest if self.drives is None else self.held
        for k, (joint, load, limit) in enumerate(zip(self.joints, self.sized_by, self.limits.tolist(), strict=True)):
            finite = np.isfinite(limit)
            most = f"{limit:.4g}" if finite else "none" if self.known[k] else "unknown"
            share = words.format_percent(float(used[k] / limit)) if finite else "–"
            own = " N" if joint in self.sliding and self.unit != "N" else ""
            most += own if finite else ""
            remark = "over limit" if self._is_too_weak[k] else ""
            rows.append((joint, f"{peak[k]}{own}", f"{held[k]}{own}", most, share, load, remark))
        return tuple(rows)

    @property
    def unit(self) -> str:
        """Of the columns of the table: "N" where all joints slide."""
        return words.effort_unit(all(joint in self.sliding for joint in self.joints))

    @property
    def table(self) -> TextTable:
        """The table of the torques, one joint a row."""
        efforts = [f"{what}\n{self.unit}" for what in ("peak", "continuous", "limit")]
        return TextTable(("joint", *efforts, "of limit", "sized by", ""), self.rows, "<>>>><<")

    def __str__(self) -> str:
        if not self.holds:
            return self.sentence
        table = str(self.table) if self.tensions is None else f"{self.table}\n\n{self.tensions.table}\n"
        if not self.confirmed:
            return wrap_text(f"NOT CONFIRMED: {self.sentence}") + f"\n\n{table}"
        return f"{table}\n{self.sentence}"

    @property
    def sentence(self) -> str:
        """The grip, what less of it does, and whether the hand's own limits are enough."""
        many = f"{len(self.loads)} loads" if len(self.loads) > 1 else self.loads[0]
        beside = f"{many} × {self.safety:g}, weight included," if self.safety != 1.0 else many
        pressed = ", ".join([f"{words.format_force(f)} ({name})" for name, f in self.grip.items()])
        forces = list(self.grip.values())
        if max(forces) - min(forces) <= 1e-3 * max(forces):
            pressed = f"{words.format_force(forces[0])} at each fingertip"
        if not self.holds:
            assert self.lost is not None
            load, why = self.lost
            none = f"No grip was found that holds {beside.rstrip(',')}. With {pressed}, {load} is {why}."
            return wrap_text(none)
        if self.confirmed:
            parts = [f"With a grip of {pressed}, {beside} {'are' if len(self.loads) > 1 else 'is'} held."]
        else:
            some = f"{len(self.reasons)} of {many}" if len(self.loads) > 1 else many
            some += f" × {self.safety:g}, weight included" if self.safety != 1.0 else ""
            parts = [f"With a grip of {pressed}, check() does not say HELD of {some}."]
            parts += [f"{name} is {self.verdicts[name]}: {why}." for name, why in self.reasons.items()]
        if self.fails is not None and self.lost is not None:
            parts.append(f"With {100 * self.fails:.4g} % of it, {self.lost[0]} is lost.")
        if idle := [name for name, f in self.grip.items() if words.format_force(f) == words.format_force(0.0)]:
            who = "the fingertips" if len(idle) == len(self.grip) else words.join_names(idle)
            parts.append(f"0 N is to touch without pressing: load and other fingers press the object against {who}.")
        if self.weak:
            parts.append(f"As the hand is, {describe_torque_excess(self.weak)}.")
        elif self.enough:
            parts.append("The hand's own torque limits are enough.")
        return wrap_text(" ".join(parts))

    def to_dict(self) -> dict[str, Any]:
        """As plain data, SI units in the key names, None for what is not a finite number."""
        lines = (
            "joint = joints", "torque_Nm", "closing_Nm", "held_Nm", "peak_Nm", "continuous_Nm", "sized_by",
            "limit_Nm = limits", "limit_known = known",
        )  # fmt: skip
        by_load = [dict(zip(self.loads, column, strict=True)) for column in self.torques.T]
        lost = None if self.lost is None else dict(zip(("load", "why"), self.lost, strict=True))
        joints = rows_from_columns(columns_from_arrays(self, *lines) | {"by_load_Nm": by_load})
        return {**pick_entries(self, *self.entries), "lost": lost, "joints": to_plain(joints)} | (
            {} if self.tensions is None else {"tendons": self.tensions.to_dict()}
        )
