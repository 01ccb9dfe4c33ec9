"""The load in one direction at which MuJoCo's object leaves, or a joint reaches its torque limit or its range's end.

The load grows slowly, and waits while the object moves fast: a load that is held lets it come to rest. An object that
goes on moving while the load waits has left.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, array, number
from handlcp.errors import InputError
from handlcp.grasp import Grasp, TorqueSaturation
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.probe import Reading
from handlcp.simulator.under_way import PUSH, Run

__all__ = ["SimulatedLimit", "simulate_limit"]

_FAST = 0.05  # times the reach of the contacts, in a second: the load waits while the object moves faster
_LEFT = 0.06  # times the reach: how far an object that has left moves while the load waits
_REST_AFTER = 0.5  # [s] that an object has to stay under the largest factor
_SLIDES, _GONE = 0.97, 1e-3  # share of the friction limit from which a contact slides; of the largest force, below
# which it is gone


@dataclass(frozen=True)
class SimulatedLimit:
    """factor : of the load, when the object leaves or a joint reaches its torque limit or its range ends; inf where
    none of it happens up to the largest factor; 0 where the object is lost before. joint : which one reaches that, ""
    where the object leaves. slides, gone : the contacts that do when it leaves. first : the contact that slides or goes
    first while the load grows; "" where none does. seconds : [s] of MuJoCo's steps.
    """

    factor: float
    joint: str
    slides: tuple[str, ...]
    gone: tuple[str, ...]
    first: str
    seconds: float


def simulate_limit(
    grasp: Grasp, wrench: Any, most: float, *, seconds: float = 8.0, settle: float = 0.5,
    settings: SimulatorSettings | None = None,
) -> SimulatedLimit:  # fmt: skip
    """Squeeze, then the weight, then a load that grows from 0 to `most` times `wrench` (6,).

    seconds : for all of the load, where it need not wait, and of the stages before it. settle, settings : as in
    `simulate`. Joints that yield by `TorqueSaturation` have no limit to reach.
    Raises as `simulate`.
    """
    asked, most = array("wrench", wrench, (6,)), number("most", most, above=0.0)
    if not asked.any():
        raise InputError("wrench", "a load", "zeros")
    seconds, settle = number("seconds", seconds, above=0.0), number("settle", settle, minimum=0.0)
    run = Run(grasp, asked, settings)
    if not all(run.stage(name, min(seconds, 4.0), settle) for name in (*run.before, "squeeze", "weight")):
        return SimulatedLimit(0.0, "", (), (), "", run.seconds)
    return _grown(run, most, most * run.period / seconds)


def _grown(run: Run, most: float, step: float) -> SimulatedLimit:
    """The load grows by so many factors in each period."""
    reach, limits = run.probe.reach, _limits(run)
    factor, waited, rest, first = 0.0, 0.0, 0, ""
    calm = run.track.readings[-1]
    while rest * run.period < _REST_AFTER:
        there = run.advance(PUSH, factor)
        now = run.track.readings[-1]
        slides, gone = _contacts(run, now)
        first = first or next(iter(slides + gone), "")
        reached = np.flatnonzero(np.logical_or(np.abs(now.torques) >= limits, _outside(run)))
        if len(reached):
            joint = run.grasp.state.hand.joint_names[int(reached[0])]
            return SimulatedLimit(factor, joint, slides, gone, first, run.seconds)
        speed = run.track.fastest(1, reach)
        if speed <= _FAST * reach and there:
            calm, waited, rest = now, 0.0, rest + (factor == most)
            factor = min(factor + step, most)
            continue
        waited += speed * run.period
        if waited > _LEFT * reach or not there:
            return SimulatedLimit(factor, "", *_leaving(run, calm, now), first, run.seconds)
    return SimulatedLimit(np.inf, "", (), (), first, run.seconds)


def _limits(run: Run) -> Array:
    """(nv,) of the joints' torques; infinite where there is none, or where joints yield."""
    limits = run.grasp.state.hand.torque_limits
    yields = any(isinstance(e, TorqueSaturation) for e in run.grasp.spec.effects)
    return np.where((limits > 0.0) & (not yields), limits, np.inf)


def _outside(run: Run) -> Array:
    """(nv,) whether joints are beyond an end of their ranges, which MuJoCo's joints do not have."""
    hand, (q, _) = run.grasp.state.hand, run.probe.joints()
    return np.asarray((q < hand.lower) | (q > hand.upper))


def _leaving(run: Run, calm: Reading, now: Reading) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Contacts that slide, and that are gone, when the object was last calm or by when it has left."""
    before, after = _contacts(run, calm), _contacts(run, now)
    gone = tuple([name for name in run.probe.names if name in before[1] + after[1]])
    return tuple([name for name in run.probe.names if name in before[0] + after[0] and name not in gone]), gone


def _contacts(run: Run, reading: Reading) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the contacts that slide, and of those that are gone."""
    size = np.linalg.norm(reading.forces, axis=1)
    gone = size <= _GONE * size.max()
    slides = ~gone & (reading.friction >= _SLIDES)
    names = run.probe.names
    return tuple([n for n, s in zip(names, slides, strict=True) if s]), tuple(
        [n for n, g in zip(names, gone, strict=True) if g]
    )
