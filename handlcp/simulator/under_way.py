"""A simulation under way: stages in which commands, weight and load grow, and what is read meanwhile."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import Unsupported
from handlcp.grasp import Grasp
from handlcp.grasp.path.state import LET_GO
from handlcp.hand.robot.source.mujoco_log import without_mujoco_log
from handlcp.simulator.object_body import OBJECT
from handlcp.simulator.probe import Probe, Reading
from handlcp.simulator.settings import SimulatorSettings, need_mujoco, of_a_hand
from handlcp.simulator.write import to_mujoco

# ----------------------------------------------------------------
# What a simulated object has done so far: whether it moves slowly, rests, or is lost.
#
# Loads wait while the object moves fast, so that damping takes up no more than a small part of them. An object that is
# lost ends far away, under the load at which it began to move fast.

_FAR = 2.0  # times the reach of the contacts: an object that has moved this far is lost


@dataclass(frozen=True, eq=False)
class Record:
    """m moments of a simulation, one every `period` [s]; world axes.

    stages (m,) names, and shares (m,) of the stage. forces (m, n, 3) [N] of the contacts on the object. friction (m, n)
    share of its limit that each contact uses, 0 without force. motion (m, 6) [m, rad] of the object since the start.
    speed (m, 6). torques (m, nv) [N·m].
    """

    stages: tuple[str, ...]
    shares: Array
    forces: Array
    friction: Array
    motion: Array
    speed: Array
    torques: Array
    period: float


@dataclass(eq=False)
class Track:
    """Readings as they come, one every `period` [s]."""

    period: float
    stages: list[str] = field(default_factory=list)
    shares: list[float] = field(default_factory=list)
    readings: list[Reading] = field(default_factory=list)

    def add(self, stage: str, share: float, reading: Reading) -> None:
        """Add a reading, which is one period behind the last one. share : of the stage, 0 to 1."""
        self.stages.append(stage)
        self.shares.append(share)
        self.readings.append(reading)

    def fastest(self, last: int, reach: float) -> float:
        """[m/s] of the last readings, turning counted at the contacts."""
        return max(swiftness(r.speed, reach) for r in self.readings[-last:])

    def strayed(self, last: int, reach: float) -> float:
        """[m] of the last readings from the very last one, at most, turning counted at the contacts; inf before there
        are as many.
        """
        if len(self.readings) < last:
            return np.inf
        motion = np.array([r.motion for r in self.readings[-last:]])
        away = np.linalg.norm((motion - motion[-1]).reshape(-1, 2, 3), axis=2)
        return float((away[:, 0] + reach * away[:, 1]).max())

    def record(self) -> Record:
        """All readings so far, as arrays."""
        names = ("forces", "friction", "motion", "speed", "torques")
        parts = {name: read_only(np.array([getattr(r, name) for r in self.readings])) for name in names}
        return Record(stages=tuple(self.stages), shares=read_only(np.array(self.shares)), period=self.period, **parts)


def escaped(reading: Reading, reach: float) -> bool:
    """Whether the object is far from where it started. An object that turns between fingertips is still held."""
    return math.hypot(*reading.motion[:3]) > _FAR * reach


def swiftness(vector: Any, reach: float) -> float:
    """[m, m/s] of a translation and a turn, the turn counted at the contacts."""
    return math.hypot(*vector[:3]) + reach * math.hypot(*vector[3:])


# ----------------------------------------------------------------

SAG = "own weight"  # the stage before all others where the hand's links bend its joints
LONGEST = 60.0  # [s] that a load waits: an object that still moves has left
PUSH = "load alone"  # the stage in which the load grows beside a weight that is there already
_KEPT = 1e6  # times its own inertia and damping keep an object in place; it is let go as slowly as they fade
_LEADS = {
    "squeeze": ("squeeze",),
    "load": ("weight", "load"),
    "together": ("squeeze", "weight", "load"),
    "weight": ("weight",),
    PUSH: ("load",),
    SAG: ("sag",),
    LET_GO: ("free",),
}
_READ = 20  # time steps between two readings, and between two changes of what drives the simulation
_REST = 1e-5  # [m/s] an object that moves slower is at rest
_SPEEDS, _PLACES = 50, 250  # readings over which it does so, by its speed and by where it is
_FAST = 0.02  # times the reach of the contacts, in a second: while the object moves faster, loads wait
_DRAG = 0.02  # of the load that grows: what damping of the object may take up in a stage
_LEAST = 0.1  # of the contact forces: such a load counts as at least this much
_CREEPS = 1e-3  # times the reach, in a second: slower than this is always slow
_RELENTS = 0.5  # [s] of waiting after which twice that speed is slow
_PATIENCE = 20.0  # times `settle` that an object may take to come to rest
_ADRIFT = 0.2  # [s] without any contact under a load, after which an object has left


class Run:
    """A grasp in MuJoCo, from where its fingertips touch the object.

    load (6,) : as in `simulate`; None: the grasp's own. slip (n, 3) : so far. seconds : of MuJoCo's steps so far.
    calm : the stage, and the share of it, up to which the object has moved slowly. period : [s]
    between two readings. Raises as `to_mujoco`; Unsupported where MuJoCo is not installed.
    """

    def __init__(self, grasp: Grasp, load: Array | None, settings: SimulatorSettings | None) -> None:
        self.mujoco = need_mujoco()
        xml, self.state = to_mujoco(grasp, settings)
        try:
            with without_mujoco_log():
                self.model = self.mujoco.MjModel.from_xml_string(xml)
        except (ValueError, self.mujoco.FatalError) as error:
            raise Unsupported(f"MuJoCo cannot have this grasp: {' '.join(str(error).split())}") from None
        # Sparse from 60 motions on, some four times as fast; the MJCF says dense because MuJoCo 4.0.0 errs there
        self.model.opt.jacobian = self.mujoco.mjtJacobian.mjJAC_AUTO
        self.data: Any = self.mujoco.MjData(self.model)
        self.state.put(self.model, self.data, 0.0, 0.0)
        self.state.drive(self.model, self.data, 0.0, 0.0, sag=0.0)
        self.grasp = of_a_hand(grasp)
        self.probe = Probe(self.grasp, self.model, self.data)
        self.wrench = self.state.wrench if load is None else load
        wrenches = {"weight": self.grasp.spec.wrench - self.state.wrench, "load": self.wrench}
        self._sizes = {part: self._size(wrench) for part, wrench in wrenches.items()}
        self._damping = (SimulatorSettings() if settings is None else settings).object_damping
        self.calm, self._adrift = ("", 0.0), 0.0
        self.slip, self.seconds = np.zeros((len(self.probe.names), 3)), 0.0
        self.period = _READ * float(self.model.opt.timestep)
        self.track = Track(self.period)
        self._shares = {"squeeze": 0.0, "weight": 0.0, "load": 0.0, "sag": 0.0 if self.state.weighing else 1.0}
        self._shares["free"] = 0.0 if self.state.keeps else 1.0
        body = self.model.body(OBJECT)
        self._own = slice(int(body.dofadr[0]), int(body.dofadr[0] + body.dofnum[0]))
        self._damped = self.model.dof_damping[self._own].copy()
        self._slows = float(self.model.body_mass[body.id]) / self._damping  # [s] inertia by damping

    @property
    def weighs(self) -> bool:
        """Whether the object has a weight."""
        mechanism = self.grasp.spec.mechanism
        return mechanism is not None and bool(mechanism.weight_of_object(self.grasp.spec.reference)[:3].any())

    def with_own(self, stages: Iterable[str]) -> list[str]:
        """The stages asked for, and those that come with them: before all, the weight of the hand's links; after the
        squeeze, the object is let go that was kept in place.
        """
        found = [SAG] if self.state.weighing else []
        for stage in stages:
            found += [stage, LET_GO] if stage == "squeeze" and self.state.keeps else [stage]
        return found

    def stage(self, name: str, seconds: float, settle: float) -> bool:
        """Ramp one stage, which waits while the object moves fast, and wait for rest; whether the object is still
        there.
        """
        steps = max(round(seconds / self.period), 1)
        self.calm = (name, 0.0)
        done, waited = 0, 0.0
        while done < steps:
            share = _ramp((done + 1) / steps)
            if not self.advance(name, share) or waited > LONGEST:
                return False
            if self.slow(waited):
                done, waited, self.calm = done + 1, 0.0, (name, share)
            else:
                waited += self.period
        wait = round(settle / self.period)
        for k in range(round(_PATIENCE * wait)):
            if k >= wait and self._resting():
                return True
            if not self.advance(name, 1.0):
                return False
        return wait == 0 or self._resting()

    def slow(self, waited: float, share: float = _DRAG) -> bool:
        """Whether the object moves so slowly that damping takes up no more than a share of the load that grows. After a
        load has waited [s] more is slow: creeping past the last balance takes for ever.
        """
        reach, now = self.probe.reach, self.track.readings[-1]
        speed = _FAST * reach
        leads = _LEADS[self.track.stages[-1]]
        grows = [size * self._shares[part] for part, size in self._sizes.items() if part in leads]
        if grows:
            least = _LEAST * float(np.linalg.norm(now.forces, axis=1).sum())
            drag = share * max(sum(grows), least)
            speed = min(speed, max(drag / self._damping, _CREEPS * reach))
        return swiftness(now.speed, reach) <= speed * (1.0 + waited / _RELENTS)

    def advance(self, name: str, share: float) -> bool:
        """To this share of a stage, for one period; whether the object is still there."""
        self._shares |= dict.fromkeys(_LEADS[name], share)
        now = self._shares
        self.state.drive(self.model, self.data, now["squeeze"], now["weight"], now["load"] * self.wrench, now["sag"])
        if self.state.keeps:  # heavy as well: damping alone, friction would forget what it carries
            kept = self._damped * _KEPT ** (1.0 - now["free"])
            self.model.dof_damping[self._own] = kept
            self.model.dof_armature[self._own] = self._slows * (kept - self._damped)
        self._choose_contacts()
        began = perf_counter()
        with without_mujoco_log():
            self.mujoco.mj_step(self.model, self.data, _READ)
        self.seconds += perf_counter() - began
        reading = self.probe.read()
        self.slip += self.period * reading.slipping
        self.track.add(name, share, reading)
        carried = reading.forces.any() or not (now["weight"] or now["load"])
        self._adrift = 0.0 if carried else self._adrift + self.period
        return not (escaped(reading, self.probe.reach) or self._adrift > _ADRIFT)

    def _choose_contacts(self) -> None:
        """Several contacts of a pair of shapes, or one. MuJoCo looks for several where an edge lies along a face; where
        it takes a face that is not the one touched its contacts coincide, and their normal is off by degrees. It then
        looks for one contact, unless others lie apart: shapes that lie flush are held by more than one.
        """
        options, off = self.model.opt, int(self.mujoco.mjtDisableBit.mjDSBL_MULTICCD)
        options.disableflags &= ~off
        with without_mujoco_log():
            self.mujoco.mj_collision(self.model, self.data)
        if self.probe.coincide():
            options.disableflags |= off

    def _size(self, wrench: Array) -> float:
        """[N] of a force and a torque, the torque as forces at the contacts."""
        return float(np.linalg.norm(wrench[:3]) + np.linalg.norm(wrench[3:]) / self.probe.reach)

    def _resting(self) -> bool:
        """Over the last readings, so that a turning point is not taken for rest. By speed; or by place, over a longer
        time: where an edge lies along a face MuJoCo may have one contact, now at this end and now at that, and the
        object trembles faster than it gets anywhere.
        """
        reach = self.probe.reach
        by_speed = self.track.fastest(_SPEEDS, reach) < _REST
        return by_speed or self.track.strayed(_PLACES, reach) < _REST * _PLACES * self.period


def _ramp(x: float) -> float:
    """From 0 to 1, starting so slowly that friction, which starts from nothing as well, carries the object along."""
    return x**4 * (5.0 - 4.0 * x)
