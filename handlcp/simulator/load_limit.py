"""`SimulatedLimit`: the load at which MuJoCo's object leaves, or a joint reaches its torque limit or range's end.

The load grows slowly, and waits while the object moves fast. An object that moves far meanwhile has jumped; one that
comes to rest again is held, and the load goes on growing; one that does not has left.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, check_array, check_number, read_only
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.grasp.failure.failure_mode import find_exceeded, state_limits
from handlcp.record import Record
from handlcp.simulator.settings import SimulatorSettings
from handlcp.simulator.simulation_run import MAX_WAIT, PUSH_STAGE, SimulationReading, SimulationRun

# ----------------------------------------------------------------
# How an object moves while its load grows: smoothly, or in jumps while the load waits.

_JUMP_DISTANCE = 1e-3  # [m] that an object moves while the load waits: it has jumped
_JUMP_ANGLE = np.radians(2.0)  # [rad] that it turns


@dataclass(frozen=True, eq=False)
class LimitTrack(Record):
    """factors (m,) of the load, each larger than the one before. motion (m, 6) of the object since the load began to
    grow, when it had become slow under that load: translation of the reference point [m], rotation vector [rad], world
    axes. Between two factors with a jump the motion jumps. forces (m, n, 3) on the object then [N], world axes.
    """

    entries = ("factors (m,)", "motion_m_rad (m, 6)")

    factors: Array
    motion: Array
    forces: Array

    def forces_at(self, factor: float) -> Array:
        """(n, 3) forces on the object [N] under the last of the factors that is not larger than this one, world axes;
        NaN beyond the last one.
        """
        k = int(np.searchsorted(self.factors, factor, side="right")) - 1
        if k < 0 or factor > self.factors[-1]:
            return np.full(self.forces.shape[1:], np.nan)
        return np.asarray(self.forces[k])

    def motion_at(self, factor: float) -> Array:
        """(6,) how far the object had moved under this factor [m, rad], interpolated; NaN beyond the last one."""
        if not (len(self.factors) and 0.0 <= factor <= self.factors[-1]):
            return np.full(6, np.nan)
        return np.array([np.interp(factor, self.factors, column) for column in self.motion.T])


class LimitTracker:
    """Records how an object moves while its load grows.

    start (6,) : motion of the object when the load begins to grow [m, rad]. jump : the first factor at which the object
    has jumped; inf so far.
    """

    def __init__(self, start: Array) -> None:
        self.jump = np.inf
        self._start = self._calm = start
        self._factors: list[float] = []
        self._motion: list[Array] = []
        self._forces: list[Array] = []

    def record_rest(self, factor: float, motion: Array, forces: Array) -> None:
        """The object moves slowly under this factor; motion (6,), forces (n, 3)."""
        self._calm = motion
        if not self._factors or factor > self._factors[-1]:
            self._factors.append(factor)
            self._motion.append(relative_motion(self._start, motion))
            self._forces.append(forces)

    def record_motion(self, factor: float, motion: Array) -> None:
        """The object moves fast under this factor; motion (6,)."""
        if np.isfinite(self.jump):
            return
        way = relative_motion(self._calm, motion)
        if np.linalg.norm(way[:3]) > _JUMP_DISTANCE or np.linalg.norm(way[3:]) > _JUMP_ANGLE:
            self.jump = factor

    def make_track(self) -> LimitTrack:
        """How the object has moved so far, as arrays."""
        motion = read_only(np.array(self._motion).reshape(-1, 6))
        forces = read_only(np.array(self._forces) if self._forces else np.zeros((0, 0, 3)))
        return LimitTrack(read_only(np.array(self._factors)), motion, forces)


def relative_motion(before: Array, after: Array) -> Array:
    """(6,) from one motion to another: difference of translations, rotation vector of one turn after the other."""
    turn = pin.exp3(np.array(after[3:])) @ pin.exp3(np.array(before[3:])).T
    return np.append(after[:3] - before[:3], pin.log3(turn))


# ----------------------------------------------------------------

# [s] of each stage before the load grows, at most: friction follows within 0.1 s, see `friction_time`
_MAX_STAGE_SECONDS = 6.0
_MAX_DRAG_SHARE = 0.0025  # of the load: what damping of the object may take up while it grows
_RANGE_END_TOLERANCE = 1e-4  # [rad, m] as near to the end of its range a joint stands there
_FINAL_REST_SECONDS = 0.5  # [s] that an object has to stay under the largest factor
_SLIDING_SHARE, _GONE_FORCE_SHARE = (
    0.97,
    1e-3,
)  # share of the friction limit from which a contact slides; of the largest force, below
# which it is gone


@dataclass(frozen=True)
class SimulatedLimit(Record):
    """How much of a load MuJoCo holds, and what gives out there; made by `simulate_limit`.

    factor : of the load, when the object leaves or a joint reaches its torque limit or the end of its range; inf where
        none of it happens up to the largest factor; 0 where the object is lost before.
    joint : which one reaches that; "" where the object leaves.
    slides, gone : names of the contacts that slide, and that are gone, when the object leaves.
    first, first_at : the contact that slides or goes first while the load grows, and at which factor; "" and inf where
        none does.
    jump : the factor at which the object first moves by more than 1 mm, or turns by more than 2°, while the load waits;
        inf where it never does. It may have come to rest again.
    track : how the object has moved meanwhile.
    squeezed (n, 3) : forces on the object [N] with all of the squeeze and without weight and load, world axes.
    seconds : [s] of MuJoCo's steps.
    """

    entries = (
        "factor",
        "joint",
        "slides",
        "gone",
        "first",
        "first_at",
        "jump",
        "track",
        "squeezed_N (n, 3)",
        "seconds",
    )

    factor: float
    joint: str
    slides: tuple[str, ...]
    gone: tuple[str, ...]
    first: str
    seconds: float
    first_at: float
    jump: float
    track: LimitTrack
    squeezed: Array


def simulate_limit(
    grasp: Grasp,
    wrench: Any,
    most: float,
    *,
    seconds: float = 8.0,
    settle: float = 0.5,
    settings: SimulatorSettings | None = None,
) -> SimulatedLimit:
    """Squeeze, then the weight, then a load that grows from 0 to `most` times `wrench` (6,).

    seconds : for all of the load, where it need not wait; the stages before it take as long, up to 6 s each. settle,
    settings : as in `simulate`. Joints that yield by `TorqueSaturation` have no limit to reach.
    Raises as `simulate`.
    """
    asked, most = check_array("wrench", wrench, (6,)), check_number("most", most, above=0.0)
    if not asked.any():
        raise InputError("wrench", "a load", "zeros")
    seconds, settle = check_number("seconds", seconds, above=0.0), check_number("settle", settle, minimum=0.0)
    run, before = SimulationRun(grasp, asked, settings), min(seconds, _MAX_STAGE_SECONDS)
    held = all(run.run_stage(name, before, settle) for name in run.with_own_stages(("squeeze",)))
    squeezed = read_only(run.track.readings[-1].forces)
    held = held and run.run_stage("weight", before, settle)
    growing = _GrowingLoad(run, squeezed)
    return growing.grow_to(most, most * run.period / seconds) if held else growing.make_result(0.0)


class _GrowingLoad:
    """The load that grows, and what has happened meanwhile."""

    def __init__(self, run: SimulationRun, squeezed: Array) -> None:
        self.run, self.squeezed = run, squeezed
        # As in `load_limit`: the end of a range at which a joint stands before the load grows does not end it
        limits, q = state_limits(run.grasp.spec).without_tendons, run.track.readings[-1].q
        self.limits = replace(
            limits,
            lower=np.where(q < limits.lower + _RANGE_END_TOLERANCE, -np.inf, limits.lower),
            upper=np.where(q > limits.upper - _RANGE_END_TOLERANCE, np.inf, limits.upper),
        )
        self.first, self.first_at = "", np.inf
        self.tracking = LimitTracker(run.track.readings[-1].motion)

    def grow_to(self, most: float, step: float) -> SimulatedLimit:
        """By so much of the factor in each period in which it does not wait."""
        run, factor, waited, rest = self.run, 0.0, 0.0, 0
        calm = run.track.readings[-1]
        while rest * run.period < _FINAL_REST_SECONDS:
            there = run.advance(PUSH_STAGE, factor)
            now = run.track.readings[-1]
            if not self.first and (moving := sum(_sliding_and_gone(run, now), ())):
                self.first, self.first_at = moving[0], factor
            if there and run.is_slow(waited, _MAX_DRAG_SHARE):
                if joint := self._find_limiting_joint(now):
                    return self.make_result(factor, joint, *_sliding_and_gone(run, now))
                self.tracking.record_rest(factor, now.motion, now.forces)
                calm, waited, rest = now, 0.0, rest + (factor == most)
                factor = min(factor + step, most)
                continue
            self.tracking.record_motion(factor, now.motion)
            waited += run.period
            if waited > MAX_WAIT or not there:
                return self.make_result(factor, "", *_leaving_contacts(run, calm, now))
        return self.make_result(np.inf)

    def _find_limiting_joint(self, now: SimulationReading) -> str:
        """Of its torque or its range; not while the object moves fast, when fingers may spring anywhere."""
        found = find_exceeded(self.limits, now.torques, now.q)  # MuJoCo's joints have no ends of ranges
        return found[0].who if found else ""

    def make_result(
        self, factor: float, joint: str = "", slides: tuple[str, ...] = (), gone: tuple[str, ...] = ()
    ) -> SimulatedLimit:
        """What has been found by now."""
        return SimulatedLimit(
            factor=factor,
            joint=joint,
            slides=slides,
            gone=gone,
            first=self.first,
            seconds=self.run.seconds,
            first_at=self.first_at,
            jump=self.tracking.jump,
            track=self.tracking.make_track(),
            squeezed=self.squeezed,
        )


def _leaving_contacts(
    run: SimulationRun, calm: SimulationReading, now: SimulationReading
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Contacts that slide, and that are gone, when the object was last calm or by when it has left."""
    before, after = _sliding_and_gone(run, calm), _sliding_and_gone(run, now)
    gone = tuple([name for name in run.probe.names if name in before[1] + after[1]])
    return tuple([name for name in run.probe.names if name in before[0] + after[0] and name not in gone]), gone


def _sliding_and_gone(run: SimulationRun, reading: SimulationReading) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the contacts that slide, and of those that are gone."""
    size = np.linalg.norm(reading.forces, axis=1)
    gone = size <= _GONE_FORCE_SHARE * size.max()
    slides = ~gone & (reading.friction >= _SLIDING_SHARE)
    names = run.probe.names
    return tuple([n for n, s in zip(names, slides, strict=True) if s]), tuple(
        [n for n, g in zip(names, gone, strict=True) if g]
    )
