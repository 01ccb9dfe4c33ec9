"""`Motor`: what a motor gives for a moment, what for good, and what its gear carries without it; `Drives`: all of them.

At the joint, through reduction N and efficiency η, with dry friction τ_f of the drive and what the motor gives, τ_m:

    τ_c = N η continuous,    τ_p = N η peak
    moving     τ_m = τ ± τ_f                       friction is against the motion
    at rest    |τ_m - τ| ≤ τ_f                     and takes whatever it takes
    closing    |τ_m| ≤ τ_p
    held       |τ| ≤ max(τ_c + τ_f, holding)       so that τ_c can be enough
    lasts      t = T ln(u² / (u² - 1)),   u = (|τ| - τ_f) / τ_c

In a loading that is followed τ_f is dry friction at the joint, as a hand's `joint_friction` is: it evolves with the
motion, and forces depend on it. A joint that is held stands still; u is the least that its motor has to give then, as a
share of what it gives for good. Its winding heats with u², and T is its thermal time: from cold, it is as hot as it may
be after t.

At a tendon all of it is in newtons of tension. There friction stays between the motor and the cable, which is the
spring: it changes no force, and a tendon closes with |τ| ≤ τ_p - τ_f.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, check_init_call, check_keys, check_method_calls, check_number, read_only
from handlcp.errors import InputError
from handlcp.lazy_property import lazy_property

CONTINUOUS, HOLDING = "continuous", "holding"  # which of the two a joint is held by


@check_init_call()
@check_method_calls
@dataclass(frozen=True)
class Motor:
    """One motor with its gear, for `motors=` of a hand, or of `Tendons`: what is said of the joint is then said of the
    tendon, in newtons of tension.

    continuous, peak : torque of the motor itself [N·m] (N of a linear one), for good and for a moment; peak None: no
        more than continuous.
    holding : torque at the joint [N·m] that a gear which cannot be driven back carries, more than its motor gives for
        good; numpy.inf: any, as of a worm. None: the motor alone holds.
    friction : dry friction of the drive at the joint [N·m]: it hinders closing, and helps to hold. A loading that is
        followed has it beside a hand's `joint_friction`; one solve in one posture knows no way, and has it in the limit
        alone. Of a tendon [N] it stays before the cable, and changes no force.
    reduction : turns of the motor per turn of the joint; of a tendon, newtons of tension per N·m of the motor, n / r
        [1/m] for a spool of radius r behind a gear n. efficiency : of the gear, 0 to 1.
    stiffness : of the joint [N·m/rad], in place of what the hand's `joint_stiffness` says; None: that. Of a tendon
        always None.
    thermal_time : [s] time constant of the winding's temperature; None: not known.

    Raises InputError for a peak below continuous, a negative friction, an efficiency that is not above 0 and at most 1,
    a friction that peak does not overcome, and a holding torque below what the motor holds for good.
    """

    continuous: float
    peak: float | None = None
    holding: float | None = None
    friction: float = 0.0
    reduction: float = 1.0
    efficiency: float = 1.0
    stiffness: float | None = None
    thermal_time: float | None = None

    def __post_init__(self) -> None:
        optional = "peak", "holding", "stiffness", "thermal_time"
        for name in ("continuous", "friction", "reduction", "efficiency", *optional):
            if (value := getattr(self, name)) is None and name in optional:
                continue
            minimum, above = (0.0, -np.inf) if name == "friction" else (-np.inf, 0.0)
            finite = name not in ("holding", "stiffness")
            value = check_number(f"Motor.{name}", value, minimum=minimum, above=above, finite=finite)
            object.__setattr__(self, name, value)
        if self.efficiency > 1.0:
            raise InputError("Motor.efficiency", "a number above 0 and at most 1", self.efficiency)
        if self.peak is not None and self.peak < self.continuous:
            raise InputError("Motor.peak", f"at least the continuous torque, {self.continuous:g}", self.peak)
        if self.friction >= self.at_peak:
            expected = f"less than the peak torque at the joint, {self.at_peak:g} N·m, which has to overcome it"
            raise InputError("Motor.friction", expected, self.friction)
        if self.holding is not None and self.holding < self.for_good + self.friction:
            least = self.for_good + self.friction
            expected = f"at least what the motor and friction hold for good at the joint, {least:g} N·m, or None"
            raise InputError("Motor.holding", expected, self.holding)

    @property
    def for_good(self) -> float:
        """τ_c [N·m], at the joint."""
        return self.reduction * self.efficiency * self.continuous

    @property
    def at_peak(self) -> float:
        """τ_p [N·m], at the joint."""
        return self.reduction * self.efficiency * (self.continuous if self.peak is None else self.peak)

    @property
    def closes(self) -> float:
        """[N·m] Of `at_peak`, what is left for the joint or the tendon while it closes."""
        return self.at_peak - self.friction

    @property
    def holds(self) -> float:
        """[N·m] That the joint holds for good."""
        return max(self.for_good + self.friction, self.holding or 0.0)

    @property
    def gives(self) -> float:
        """[N·m] The largest torque at the joint that is held for a moment, friction and gear included."""
        return max(self.at_peak + self.friction, self.holding or 0.0)

    @property
    def held_by(self) -> str:
        """What holds for good: "continuous", the motor, or "holding", the gear where it carries more."""
        return HOLDING if self.holding is not None else CONTINUOUS

    def share(self, torque: float) -> float:
        """The share of its continuous torque `for_good` that the motor gives, for a torque at the joint [N·m].

        It is 0 where friction or the gear carries all of it.
        """
        torque = check_number("torque", torque)
        if abs(torque) <= (self.holding or 0.0):
            return 0.0
        return max(abs(torque) - self.friction, 0.0) / self.for_good

    def lasts(self, torque: float) -> float | None:
        """[s] how long a torque at the joint [N·m] is held, begun cold: inf where the motor gives no more than for
        good, 0 beyond its peak; None where the thermal time is not known.
        """
        u = self.share(torque)
        if u <= 1.0:
            return np.inf
        if abs(torque) > self.gives:
            return 0.0
        return None if self.thermal_time is None else self.thermal_time * float(np.log(u * u / (u * u - 1.0)))


# ----------------------------------------------------------------
# The motors of a hand, joint by joint or tendon by tendon.


@dataclass(frozen=True, eq=False)
class Drives:
    """The motor of each joint, or of each tendon.

    motors (nv,) or (t,) : None where a joint has a torque limit alone, or none. Those of tendons count in newtons of
        tension.
    """

    motors: tuple[Motor | None, ...]

    def motor_joints(self, joints: Sequence[str]) -> tuple[str, ...]:
        """Of the joints (nv,) that have a motor."""
        return tuple([joint for joint, motor in zip(joints, self.motors, strict=True) if motor is not None])

    def drop_motors(self, joints: Sequence[str], named: Sequence[str]) -> Drives | None:
        """But for those of the named joints, of joints (nv,)."""
        left = tuple([None if j in named else motor for j, motor in zip(joints, self.motors, strict=True)])
        return Drives(left) if any(left) else None

    def stiffness(self, joints: Sequence[str]) -> dict[str, float]:
        """[N·m/rad] By name, of the joints (nv,) whose motors say it."""
        every = zip(joints, self.motors, strict=True)
        return {joint: m.stiffness for joint, m in every if m is not None and m.stiffness is not None}

    @lazy_property
    def friction(self) -> Array:
        """Dry friction τ_f (nv,) of the motors at their joints [N·m]."""
        return self._motor_values("friction", np.zeros(len(self.motors)))

    @lazy_property
    def closing_limits(self) -> Array:
        """(nv,) with which the joints can close [N·m]; inf of a joint without a motor."""
        return self._motor_values("closes", np.full(len(self.motors), np.inf))

    def peak_limits(self, limits: Array) -> Array:
        """(nv,) the peak of each motor at the joint [N·m]; of a joint without a motor its limit, of limits (nv,)."""
        return self._motor_values("at_peak", limits)

    def holding_limits(self, limits: Array) -> Array:
        """(nv,) that they hold for good [N·m]; of a joint without a motor its limit, of limits (nv,)."""
        return self._motor_values("holds", limits)

    def _motor_values(self, number: str, others: Array) -> Array:
        """(nv,) of each motor; of joints without one, those of others (nv,)."""
        every = zip(self.motors, others.tolist(), strict=True)
        return read_only(np.array([other if m is None else getattr(m, number) for m, other in every]))


def read_motors(value: Any, names: Sequence[str], argument: str = "motors", kind: str = "joint") -> Drives | None:
    """From a `Motor` for every joint, a mapping of joint names to motors (others: none), or None; likewise of what else
    has names. Raises InputError, UnknownName.
    """
    if value is None:
        return None
    if isinstance(value, Motor):
        return Drives((value,) * len(names))
    if not isinstance(value, Mapping):
        expected = f"a Motor for every {kind}, or a mapping of {kind} names to Motors"
        raise InputError(argument, expected, repr(value)[:80])
    named = check_keys(argument, value, names, f"a {kind}")
    for name, motor in named.items():
        if not isinstance(motor, Motor):
            raise InputError(f"{argument}[{name!r}]", "a Motor", repr(motor)[:80])
    return Drives(tuple([named.get(name) for name in names])) if named else None


# ----------------------------------------------------------------
# Motors that draw tendons in: which of them each tendon has, and what cannot be.
#
# A spool of radius r behind a gear n makes n / r newtons of tension of each newton metre of its motor. With that as
# reduction, a `Motor` says in newtons at the tendon what it says of a joint in newton metres.


_MOTORS_ARGUMENT = "Tendons.motors"


def read_tendon_motors(value: Any, tendons: Sequence[str], pretension: Array) -> Drives | None:
    """From a `Motor` for every tendon, a mapping of tendon names to motors (others: none), or None. pretension (t,) :
    which a motor has to make and to hold [N]. Raises InputError, UnknownName.
    """
    drives = read_motors(value, tendons, _MOTORS_ARGUMENT, "tendon")
    if drives is None:
        return None
    for name, motor, begun in zip(tendons, drives.motors, pretension.tolist(), strict=True):
        if motor is None:
            continue
        if motor.stiffness is not None:
            expected = "a Motor without stiffness: Tendons.stiffness says it"
            raise InputError(f"{_MOTORS_ARGUMENT}[{name!r}]", expected, f"Motor(stiffness={motor.stiffness:g})")
        if min(motor.closes, motor.holds) < begun < np.inf:
            came = f"one that closes with {motor.closes:g} N and holds {motor.holds:g} N for good"
            expected = f"a motor that makes and holds the pretension, {begun:g} N"
            raise InputError(f"{_MOTORS_ARGUMENT}[{name!r}]", expected, came)
    return drives


def check_driven_once(arms: Array, tendons: Drives | None, drives: Drives | None, joints: Sequence[str]) -> None:
    """Raises InputError for motors of joints that tendons with motors move; arms (t, nv) : R."""
    if tendons is None or drives is None:
        return
    drawn, own = (np.array([motor is not None for motor in every.motors]) for every in (tendons, drives))
    if both := [joints[k] for k in np.flatnonzero(own & arms[drawn].any(axis=0)).tolist()]:
        raise InputError("motors", "no motor of a joint that a tendon with a motor moves", ", ".join(both))
