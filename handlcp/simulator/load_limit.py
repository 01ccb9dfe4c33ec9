"""`SimulatedLimit`: the load at which MuJoCo's object leaves, or a joint reaches its torque limit or range's end.

The load grows slowly, and waits while the object moves fast. An object that moves far meanwhile has jumped; one that
comes to rest again is held, and the load goes on growing; one that does not has left.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, check_number, read_only
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.grasp.failure.failure_mode import find_exceeded, state_limits
from handlcp.grasp.model.request import check_load
from handlcp.record import Record
from handlcp.simulator.settings import SimulatorSettings, require_hand_grasp
from handlcp.simulator.simulation_run import MAX_WAIT, PUSH_STAGE, SimulationReading, SimulationRun

# ----------------------------------------------------------------
# How an object moves while its load grows: smoothly, or in jumps while the load waits.

_JUMP_DISTANCE = 1e-3  # [m] that an object moves while the load waits: it has jumped
_JUMP_ANGLE = np.radians(2.0)  # [rad] that it turns
_HOP_SHARE = 0.02  # of both: smaller motions while the load waits are not noted


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
    has jumped; inf so far. hops : as in `SimulatedLimit`.
    """

    def __init__(self, start: Array) -> None:
        self.jump = np.inf
        self.hops: list[tuple[float, float, float]] = []
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
        way = relative_motion(self._calm, motion)
        shift, turn = float(np.linalg.norm(way[:3])), float(np.linalg.norm(way[3:]))
        size = max(shift / _JUMP_DISTANCE, turn / _JUMP_ANGLE)
        if size > 1.0 and np.isinf(self.jump):
            self.jump = factor
        if self.hops and self.hops[-1][0] == factor:
            shift, turn = max(shift, self.hops[-1][1]), max(turn, self.hops[-1][2])
            self.hops[-1] = factor, shift, turn
        elif size > _HOP_SHARE:
            self.hops.append((factor, shift, turn))

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

_Names = tuple[str, ...]

# [s] of each stage before the load grows, at most: friction follows within 0.1 s, see `friction_time`
_MAX_STAGE_SECONDS = 6.0
_MAX_DRAG_SHARE = 0.0025  # of the load: what damping of the object may take up while it grows
_RANGE_END_TOLERANCE = 1e-4  # [rad, m] as near to the end of its range a joint stands there
_FINAL_REST_SECONDS = 0.5  # [s] that an object has to stay under the largest factor
# Share of the friction limit from which a contact slides; of the largest force, below which it is gone
_SLIDING_SHARE, _GONE_FORCE_SHARE = 0.97, 1e-3


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
    hops (k, 3) : each factor at which the object moves while the load waits, how far it does [m], and how far it turns
        [rad]; jumps are the large ones of them.
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
        "hops (k, 3)",
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
    hops: Array
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
    """Squeeze, then the weight, then a load that grows from 0 to `most` times a wrench.

    wrench : (6,) force [N] and torque [N·m] beside the weight, of a planar grasp also (3,), as in `Grasp`. seconds :
    for all of the load, where it need not wait; the stages before it take as long, up to 6 s each. settle, settings :
    as in `simulate`. Joints that yield by `TorqueSaturation` have no limit to reach.
    Raises as `simulate`.
    """
    own, most = require_hand_grasp(grasp), check_number("most", most, above=0.0)
    asked = check_load(own.spec, wrench)
    if not asked.any():
        raise InputError("wrench", "a load", "zeros")
    seconds, settle = check_number("seconds", seconds, above=0.0), check_number("settle", settle, minimum=0.0)
    run, before = SimulationRun(own, asked, settings), min(seconds, _MAX_STAGE_SECONDS)
    held = all(run.run_stage(name, before, settle) for name in run.with_own_stages(("squeeze",)))
    squeezed = read_only(run.track.readings[-1].forces)
    held = held and run.run_stage("weight", before, settle)
    calm = run.track.readings[-1]
    # As in `load_limit`: the end of a range at which a joint stands before the load grows does not end it
    limits, q = state_limits(run.grasp.spec).without_tendons, calm.q
    limits = replace(
        limits,
        lower=np.where(q < limits.lower + _RANGE_END_TOLERANCE, -np.inf, limits.lower),
        upper=np.where(q > limits.upper - _RANGE_END_TOLERANCE, np.inf, limits.upper),
    )
    tracking, first, first_at = LimitTracker(calm.motion), "", np.inf

    def result(factor: float, joint: str = "", slides: _Names = (), gone: _Names = ()) -> SimulatedLimit:
        """What has been found by now."""
        jump, track, hops = tracking.jump, tracking.make_track(), read_only(np.array(tracking.hops).reshape(-1, 3))
        return SimulatedLimit(factor, joint, slides, gone, first, run.seconds, first_at, jump, hops, track, squeezed)

    if not held:
        return result(0.0)
    factor, waited, rest = 0.0, 0.0, 0
    while rest * run.period < _FINAL_REST_SECONDS:
        there = run.advance(PUSH_STAGE, factor)
        now = run.track.readings[-1]
        if not first and (moving := sum(_sliding_and_gone(run, now), ())):
            first, first_at = moving[0], factor
        if there and run.is_slow(waited, _MAX_DRAG_SHARE):
            # Not while the object moves fast, when fingers may spring anywhere; MuJoCo's joints have no ends of ranges
            if exceeded := find_exceeded(limits, now.torques, now.q):
                return result(factor, exceeded[0].who, *_sliding_and_gone(run, now))
            tracking.record_rest(factor, now.motion, now.forces)
            calm, waited, rest = now, 0.0, rest + (factor == most)
            factor = min(factor + most * run.period / seconds, most)
            continue
        tracking.record_motion(factor, now.motion)
        waited += run.period
        if waited > MAX_WAIT or not there:  # what slid or had gone when it was last calm has done so by now
            slid, lost = (a + b for a, b in zip(_sliding_and_gone(run, calm), _sliding_and_gone(run, now), strict=True))
            gone = tuple([name for name in run.probe.names if name in lost])
            return result(factor, "", tuple([n for n in run.probe.names if n in slid and n not in gone]), gone)
    return result(np.inf)


def _sliding_and_gone(run: SimulationRun, reading: SimulationReading) -> tuple[_Names, _Names]:
    """Names of the contacts that slide, and of those that are gone."""
    size = np.linalg.norm(reading.forces, axis=1)
    gone = size <= _GONE_FORCE_SHARE * size.max()
    slides = ~gone & (reading.friction >= _SLIDING_SHARE)
    names = np.array(run.probe.names)
    return tuple(names[slides].tolist()), tuple(names[gone].tolist())
