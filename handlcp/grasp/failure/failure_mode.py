"""`FailureMode`: what gives out, as data, and the one judge of torques, ranges and contacts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import hypot
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.grasp.effects.joint_torque import TorqueSaturation
from handlcp.grasp.model.mechanism import Cables, Mechanism
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import SEPARATED, SLIDING, ContactStatus
from handlcp.record import Record
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

# ----------------------------------------------------------------
# What gives out, as data. The functions below make it, the table of words says it (`failure_text.py`).

SLIPS, OPENS, TORQUE, TENSION, RANGE = "slips", "opens", "torque", "tension", "range"
EQUILIBRIUM, MOTION, SLIDES, UNDECIDED = "equilibrium", "motion", "slides", "undecided"
OBJECT = "the object"


@dataclass(frozen=True, slots=True)
class FailureMode(Record):
    """What gives out first when a load grows: a contact, a joint, a tendon or the object.

    kind : "slips" (a finger that slips), "opens" (a contact that lets go), "torque" (a joint at its torque limit),
        "tension" (a tendon at its limit), "range" (a joint at the end of its range), "equilibrium" (forces no longer
        balance the load), "motion" (the object moves farther than was allowed), "slides" (a contact that presses has
        slid as far as it may), "undecided" (something does, and it is not known what).
    who : the finger, the joint, the tendon or "the object".
    margin : share of the limit that is left; 0 at the limit, below 0 beyond it. Causes of the same kind and name are
        equal, whatever their margins.
    """

    entries = ("kind", "who")

    kind: str
    who: str
    margin: float = field(default=0.0, compare=False)

    def __repr__(self) -> str:
        left = f", margin={self.margin:.3g}" if self.margin else ""
        return f"FailureMode({self.kind!r}, {self.who!r}{left})"


Bind = FailureMode


# ----------------------------------------------------------------
# The judge: what in a state is beyond its limit, what is at it, and which contacts give way.
#
# share = |τ| / τ_max            of a torque limit, and likewise of a tendon's tension
# share = 1 + outside / span     of a joint's range; outside < 0 within it
# share = moved / allowed        of the object's motion
#
# Each share is 1 at the limit. A state is beyond a limit where a share is above 1 by more than a tolerance, and
# nowhere is this compared in another way.

_MAX_SHARE = 1.0 + OVER_LIMIT_TOLERANCE
_MIN_TORQUE_LIMIT = 1e-12  # [N·m]: a limit of a joint without torque counts as this
_UNLIMITED_MOTION = (np.inf, np.inf)


def is_exceeded(share: Any) -> Any:
    """Whether shares of a limit, a number or an array, are beyond it; NaN is not."""
    return share > _MAX_SHARE


@dataclass(frozen=True, eq=False)
class StateLimits:
    """What a state must not exceed.

    names (n,) : of the contacts. joints (nv,), tendons (t,) : names. efforts (nv + t,) : limits of torques [N·m, N],
    then of tensions [N], inf where there is none.
    lower, upper (nv,) : ends of the ranges [rad, m], infinite where there is none. motion : how far the object may
    move [m] and turn [rad].
    """

    names: tuple[str, ...]
    joints: tuple[str, ...]
    efforts: Array
    lower: Array
    upper: Array
    motion: tuple[float, float] = _UNLIMITED_MOTION
    tendons: tuple[str, ...] = ()
    inverse_efforts: Array = field(init=False, repr=False)  # 1 / τ_max
    inverse_spans: Array = field(init=False, repr=False)  # 1 / span; 1 where a range has none

    def __post_init__(self) -> None:
        span = self.upper - self.lower
        ranged = np.isfinite(span) & (span > 0.0)
        object.__setattr__(self, "inverse_efforts", read_only(1.0 / np.maximum(self.efforts, _MIN_TORQUE_LIMIT)))
        object.__setattr__(self, "inverse_spans", read_only(1.0 / np.where(ranged, span, 1.0)))

    def failure_mode(self, k: int, share: float) -> FailureMode:
        """What the k-th of `limit_shares` is of."""
        nv, left = len(self.joints), 1.0 - share
        if k < nv:
            return FailureMode(TORQUE, self.joints[k], left)
        if (k := k - nv) < len(self.tendons):
            return FailureMode(TENSION, self.tendons[k], left)
        k -= len(self.tendons)
        return FailureMode(RANGE, self.joints[k], left) if k < nv else FailureMode(MOTION, OBJECT, left)

    @property
    def without_tendons(self) -> StateLimits:
        """Without those of tendons."""
        return replace(self, efforts=self.efforts[: len(self.joints)], tendons=())


def state_limits(
    spec: GraspSpec,
    *,
    motion: tuple[float, float] = _UNLIMITED_MOTION,
    ranges: bool = True,
    nominal: Array | None = None,
) -> StateLimits:
    """The limits of a grasp. With `TorqueSaturation` torques have no limit to exceed: joints yield at it.

    motion : how far the object may move [m] and turn [rad]. ranges : whether the ends of ranges count. nominal (nv,) :
    where the joints are before they move; a range that a joint has left there already does not count.
    """
    mechanism = spec.mechanism
    if mechanism is None:
        none = np.zeros(0)
        return StateLimits(spec.names, (), none, none, none, motion)
    torque, free = mechanism.limits, np.full(len(mechanism.names), np.inf)
    if any(isinstance(e, TorqueSaturation) for e in spec.effects):
        torque = free
    cables = mechanism.joint_model.cables or Cables.without_tendons(0)
    efforts = np.concatenate([torque, cables.limits])
    lower, upper = mechanism.joint_model.ranges if ranges else (-free, free)
    if nominal is not None:
        alone = StateLimits((), mechanism.names, free, lower, upper)
        left = is_exceeded(limit_shares(alone, np.zeros(len(free)), nominal)[len(free) :])
        lower, upper = np.where(left, -np.inf, lower), np.where(left, np.inf, upper)
    return StateLimits(spec.names, mechanism.names, efforts, lower, upper, motion, cables.names)


def limit_shares(limits: StateLimits, efforts: Array, q: Array | None = None, moved: Array | None = None) -> Array:
    """Shares of the limits: (nv + t,) of torques and tensions; with q (nv,) of ranges too, nv more; with moved (6,) of
    the object's motion too, 2 more, of shift and turn. NaN where a torque is.
    """
    named = len(limits.joints)  # joints that a flexibility alone knows have no names, and no limits
    parts = [abs(efforts[: len(limits.inverse_efforts)]) * limits.inverse_efforts]
    if q is not None:
        parts.append(np.maximum(q[:named] - limits.upper, limits.lower - q[:named]) * limits.inverse_spans + 1.0)
    if moved is not None:
        if q is None:
            parts.append(np.full(len(limits.joints), -np.inf))
        x, y, z, a, b, c = moved.tolist()
        parts.append(np.array([hypot(x, y, z) / limits.motion[0], hypot(a, b, c) / limits.motion[1]]))
    return np.concatenate(parts)


def find_exceeded(
    limits: StateLimits, efforts: Array, q: Array | None = None, moved: Array | None = None
) -> tuple[FailureMode, ...]:
    """What is beyond its limit in a state: torques first, then tensions, ranges and the object's motion; arguments as
    in `limit_shares`.
    """
    share = limit_shares(limits, efforts, q, moved)
    return _failure_modes(limits, share, is_exceeded(share))


def find_exceeded_closing(mechanism: Mechanism | None, efforts: Callable[[], Array]) -> tuple[FailureMode, ...]:
    """Joints and tendons that closing took more of than their motors give. efforts : makes (nv + t,) [N·m, N], and is
    asked only where there are motors.
    """
    if mechanism is None or (closes := mechanism.joint_model.closing_limits) is None:
        return ()
    free, cables = np.full(len(mechanism.names), np.inf), mechanism.joint_model.cables
    tendons = () if cables is None else cables.names
    return find_exceeded(StateLimits((), mechanism.names, closes, -free, free, tendons=tendons), efforts())


def find_binding(
    limits: StateLimits,
    efforts: Array,
    q: Array | None = None,
    moved: Array | None = None,
    near: float = OVER_LIMIT_TOLERANCE,
) -> tuple[FailureMode, ...]:
    """What ends a path in a state: all that is at its limit or beyond, or else what is nearest to it. () where nothing
    has a limit. near : shares that differ by no more, relative, are equal: as exactly as the state is located.
    """
    share = limit_shares(limits, efforts, q, moved)
    most = float(np.nanmax(share, initial=0.0))
    if not most > 0.0:
        return ()
    return _failure_modes(limits, share, share >= min(most, 1.0) * (1.0 - near))


def find_slipping(
    names: Sequence[str], kinds: Sequence[ContactStatus], before: Sequence[ContactStatus] | None = None
) -> tuple[FailureMode, ...]:
    """What gives way where no more load is balanced: contacts that open there; or else all that slide; or else balance
    itself. kinds (n,) : what each contact does. before (n,) : the same short of that place; None: nothing
    opens there.
    """
    if before is not None:
        opened = [n for n, a, b in zip(names, before, kinds, strict=True) if b == SEPARATED != a]
        if opened:
            return tuple([FailureMode(OPENS, name) for name in opened])
    every = zip(names, kinds if before is None else before, kinds, strict=True)
    sliding = [name for name, a, b in every if SLIDING in (a, b)]
    return tuple([FailureMode(SLIPS, name) for name in sliding]) or (FailureMode(EQUILIBRIUM, OBJECT),)


def largest_share_index(share: Array) -> int:
    """Which share is the largest: the first of those that differ from it by rounding alone; NaN is none."""
    known = np.where(np.isnan(share), -np.inf, share)
    most = float(known.max())
    return int(np.argmax(known >= most - OVER_LIMIT_TOLERANCE * abs(most)))


def _failure_modes(limits: StateLimits, share: Array, which: Bools) -> tuple[FailureMode, ...]:
    """The same cause once."""
    found = dict[FailureMode, FailureMode]()
    for k in np.flatnonzero(which).tolist():
        one = limits.failure_mode(k, float(share[k]))
        if one not in found or found[one].margin > one.margin:
            found[one] = one
    return tuple(found.values())
