"""`SimulationRun`: a simulation under way, and what it says about forces, torques and motion."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only
from handlcp.errors import Unsupported
from handlcp.grasp import Grasp
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.path.state import LET_GO
from handlcp.hand import HandGrasp
from handlcp.robot.mjcf import without_mujoco_log
from handlcp.simulator.export import to_mujoco
from handlcp.simulator.object_body import LOADED_POINT_NAME, OBJECT_NAME, pad_name
from handlcp.simulator.settings import SimulatorSettings, import_mujoco, require_hand_grasp

_SAME_POINT_DISTANCE = 1e-6  # [m] contacts of one pair that are nearer coincide
_POINT_CONTACT_ROWS = 3  # rows of a contact without a moment about its normal


@dataclass(frozen=True, eq=False)
class SimulationReading:
    """One moment of a simulation. forces (n, 3) on the object, and slip speed (n, 3) of the object along each contact,
    world axes. friction (n,) share of its limit that each contact uses, 0 without force. motion (6,) of the object
    since the start: translation of the reference, rotation vector. speed (6,) of the object. q (nv,) where the
    joints are. torques (nv,) that the actuators hold.
    """

    forces: Array
    slip_speed: Array
    friction: Array
    motion: Array
    speed: Array
    q: Array
    torques: Array


class SimulationProbe:
    """Reads one simulation of a grasp; made at its start.

    names (n,) : the contacts, the fingers' first. reach : [m] from the reference to the farthest contact.
    """

    def __init__(self, grasp: HandGrasp, model: Any, data: Any) -> None:
        self._mujoco, self.model, self.data = import_mujoco(), model, data
        self.names, self._joints = grasp.names, grasp.state.hand.joint_names
        self._object, self._loaded = model.body(OBJECT_NAME).id, model.body(LOADED_POINT_NAME).id
        pairs = [model.pair(name) for name in self.names]
        geoms = [(int(p.geom1[0]), int(p.geom2[0])) for p in pairs]
        self._contact = {frozenset(pair): i for i, pair in enumerate(geoms)}
        self._ours = [int(model.geom_bodyid[pair[0]]) for pair in geoms]
        for i, name in enumerate(grasp.fingertips):  # one contact, of whichever of its shapes touch
            pad = model.body(pad_name(name))
            for geom in range(int(pad.geomadr[0]), int(pad.geomadr[0] + pad.geomnum[0])):
                self._contact[frozenset((geom, geoms[i][1]))] = i
        of_object = model.body_rootid[model.geom_bodyid] == self._object  # the object, or carried by it
        self._objects = set(np.flatnonzero(of_object).tolist())
        self.start, self.axes = data.xpos[self._loaded].copy(), data.xmat[self._loaded].reshape(3, 3).copy()
        self.reach = max(float(np.linalg.norm(grasp.spec.positions - grasp.reference, axis=1).max()), 1e-3)
        self._qpos = [int(model.jnt_qposadr[model.joint(j).id]) for j in self._joints]
        self._dofs = [int(model.jnt_dofadr[model.joint(j).id]) for j in self._joints]

    def take_reading(self) -> SimulationReading:
        """Forces, torques, and how the object moves."""
        mujoco, model, data = self._mujoco, self.model, self.data
        forces, slipping = np.zeros((len(self.names), 3)), np.zeros((len(self.names), 3))
        friction = np.zeros(len(self.names))
        wrench, speed = np.zeros(6), self._body_speed(self._loaded)
        at = data.xpos[self._loaded]
        for k in range(data.ncon):
            contact = data.contact[k]
            i = self._contact[frozenset((int(contact.geom1), int(contact.geom2)))]
            mujoco.mj_contactForce(model, data, k, wrench)
            axes = contact.frame.reshape(3, 3)
            sign = 1.0 if int(contact.geom2) in self._objects else -1.0  # the force acts on the second of the two
            force, normal = sign * (axes.T @ wrench[:3]), axes[0]
            forces[i] += force
            if wrench[0] > 0.0:  # normal, tangents; moment about the normal, …
                across = wrench[1:3] / contact.friction[:2]
                turning = wrench[3] / contact.friction[2] if contact.dim > _POINT_CONTACT_ROWS else 0.0
                friction[i] = max(friction[i], np.sqrt(across @ across + turning * turning) / wrench[0])
            body, own = self._ours[i], self._body_speed(self._ours[i])
            finger = own[:3] + cross_rows(own[3:], contact.pos - data.xpos[body])
            v = speed[:3] + cross_rows(speed[3:], contact.pos - at) - finger
            slipping[i] = v - normal * (normal @ v)
        R = data.xmat[self._loaded].reshape(3, 3) @ self.axes.T
        motion = np.append(at - self.start, pin.log3(R))
        return SimulationReading(forces, slipping, friction, motion, speed, *self.read_joints())

    def has_coinciding_contacts(self) -> bool:
        """Whether some pairs of shapes touch at one point twice, and none at points apart."""
        contact = self.data.contact
        shapes, points = np.sort(contact.geom, axis=1), contact.pos
        twice = apart = False
        for pair in np.unique(shapes, axis=0):
            own = points[(shapes == pair).all(axis=1)]
            if len(own) > 1:
                spread = float(np.ptp(own, axis=0).max())
                twice, apart = twice or spread <= _SAME_POINT_DISTANCE, apart or spread > _SAME_POINT_DISTANCE
        return twice and not apart

    def read_joints(self) -> tuple[Array, Array]:
        """(nv,) positions [rad, m] and torques that the actuators hold [N·m, N]."""
        data, torque = self.data, self.data.qfrc_actuator[self._dofs].copy()
        equality = int(self._mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        for row in np.flatnonzero(data.efc_type[: data.nefc] == equality):
            name = self.model.equality(int(data.efc_id[row])).name
            if name in self._joints:  # a rigid joint
                torque[self._joints.index(name)] += data.efc_force[row]
        return data.qpos[self._qpos].copy(), torque

    def _body_speed(self, body: int) -> Array:
        """Velocity (6,) of a body: of the origin of its frame [m/s], and angular [rad/s], world axes."""
        speed = np.zeros(6)
        self._mujoco.mj_objectVelocity(self.model, self.data, self._mujoco.mjtObj.mjOBJ_XBODY, body, speed, 0)
        return speed[[3, 4, 5, 0, 1, 2]]  # MuJoCo has the angular part first


# ----------------------------------------------------------------
# What a simulated object has done so far: whether it moves slowly, rests, or is lost.
#
# Loads wait while the object moves fast, so that damping takes up no more than a small part of them. An object that is
# lost ends far away, under the load at which it began to move fast.

_LOST_DISTANCE_FACTOR = 2.0  # times the reach of the contacts: an object that has moved this far is lost


@dataclass(frozen=True, eq=False)
class SimulationRecord:
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
class SimulationTrack:
    """Readings as they come, one every `period` [s]."""

    period: float
    stages: list[str] = field(default_factory=list)
    shares: list[float] = field(default_factory=list)
    readings: list[SimulationReading] = field(default_factory=list)

    def add(self, stage: str, share: float, reading: SimulationReading) -> None:
        """Add a reading, which is one period behind the last one. share : of the stage, 0 to 1."""
        self.stages.append(stage)
        self.shares.append(share)
        self.readings.append(reading)

    def largest_drift(self, last: int, reach: float) -> float:
        """[m] of the last readings from the very last one, at most, turning counted at the contacts; inf before there
        are as many.
        """
        if len(self.readings) < last:
            return np.inf
        motion = np.array([r.motion for r in self.readings[-last:]])
        away = np.linalg.norm((motion - motion[-1]).reshape(-1, 2, 3), axis=2)
        return float((away[:, 0] + reach * away[:, 1]).max())

    def to_record(self) -> SimulationRecord:
        """All readings so far, as arrays."""
        names = ("forces", "friction", "motion", "speed", "torques")
        parts = {name: read_only(np.array([getattr(r, name) for r in self.readings])) for name in names}
        return SimulationRecord(
            stages=tuple(self.stages), shares=read_only(np.array(self.shares)), period=self.period, **parts
        )


def contact_speed(vector: Any, reach: float) -> float:
    """[m, m/s] of a translation and a turn, the turn counted at the contacts."""
    return math.hypot(*vector[:3]) + reach * math.hypot(*vector[3:])


# ----------------------------------------------------------------
# A simulation under way: stages in which commands, weight and load grow, and what is read meanwhile.

SAG_STAGE = "own weight"  # the stage before all others where the hand's links bend its joints
MAX_WAIT = 60.0  # [s] that a load waits: an object that still moves has left
PUSH_STAGE = "load alone"  # the stage in which the load grows beside a weight that is there already
_HOLD_FACTOR = 1e6  # times its own inertia and damping keep an object in place; it is let go as slowly as they fade
_STAGE_PARTS = {
    "squeeze": ("squeeze",),
    "load": ("weight", "load"),
    "together": ("squeeze", "weight", "load"),
    "weight": ("weight",),
    PUSH_STAGE: ("load",),
    SAG_STAGE: ("sag",),
    LET_GO: ("free",),
}
_STEPS_PER_READING = 20  # time steps between two readings, and between two changes of what drives the simulation
_REST_SPEED = 1e-5  # [m/s] an object that moves slower is at rest
_SPEED_READINGS, _PLACE_READINGS = 50, 250  # readings over which it does so, by its speed and by where it is
_FAST_SPEED_SHARE = 0.02  # times the reach of the contacts, in a second: while the object moves faster, loads wait
_DRAG_SHARE = 0.02  # of the load that grows: what damping of the object may take up in a stage
_MIN_LOAD_SHARE = 0.1  # of the contact forces: such a load counts as at least this much
_CREEP_SPEED_SHARE = 1e-3  # times the reach, in a second: slower than this is always slow
_WAIT_SECONDS_SCALE = 0.5  # [s] of waiting after which twice that speed is slow
_MAX_SETTLE_FACTOR = 20.0  # times `settle` that an object may take to come to rest
_MAX_SECONDS_ADRIFT = 0.2  # [s] without any contact under a load, after which an object has left


class SimulationRun:
    """A grasp in MuJoCo, from where its fingertips touch the object.

    load (6,) : as in `simulate`; None: the grasp's own. slip (n, 3) : so far. seconds : of MuJoCo's steps so far.
    calm : the stage, and the share of it, up to which the object has moved slowly. period : [s] between two readings.
    Raises as `to_mujoco`; Unsupported where MuJoCo is not installed.
    """

    def __init__(self, grasp: Grasp, load: Array | None, settings: SimulatorSettings | None) -> None:
        self.mujoco = import_mujoco()
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
        self.grasp = require_hand_grasp(grasp)
        self.probe = SimulationProbe(self.grasp, self.model, self.data)
        self.wrench = self.state.wrench if load is None else load
        wrenches = {"weight": self.grasp.spec.wrench - self.state.wrench, "load": self.wrench}
        # [N] of a force and a torque, the torque as forces at the contacts
        self._sizes = {
            part: float(np.linalg.norm(w[:3]) + np.linalg.norm(w[3:]) / self.probe.reach)
            for part, w in wrenches.items()
        }
        self._damping = (SimulatorSettings() if settings is None else settings).object_damping
        self.calm, self._adrift = ("", 0.0), 0.0
        self.slip, self.seconds = np.zeros((len(self.probe.names), 3)), 0.0
        self.period = _STEPS_PER_READING * float(self.model.opt.timestep)
        self.track = SimulationTrack(self.period)
        self._shares = {"squeeze": 0.0, "weight": 0.0, "load": 0.0, "sag": 0.0 if self.state.weighing else 1.0}
        self._shares["free"] = 0.0 if self.state.keeps else 1.0
        body = self.model.body(OBJECT_NAME)
        self._own = slice(int(body.dofadr[0]), int(body.dofadr[0] + body.dofnum[0]))
        self._damped = self.model.dof_damping[self._own].copy()
        self._slows = float(self.model.body_mass[body.id]) / self._damping  # [s] inertia by damping

    @property
    def has_weight(self) -> bool:
        """Whether the object has a weight."""
        mechanism = self.grasp.spec.mechanism
        return mechanism is not None and bool(mechanism.weight_of_object(self.grasp.spec.reference)[:3].any())

    def with_own_stages(self, stages: Iterable[str]) -> list[str]:
        """The stages asked for, and those that come with them: before all, the weight of the hand's links; after the
        squeeze, the object is let go that was kept in place.
        """
        found = [SAG_STAGE] if self.state.weighing else []
        for stage in stages:
            found += [stage, LET_GO] if stage == "squeeze" and self.state.keeps else [stage]
        return found

    def run_stage(self, name: str, seconds: float, settle: float) -> bool:
        """Ramp one stage, which waits while the object moves fast, and wait for rest; whether the object is still
        there.
        """
        steps = max(round(seconds / self.period), 1)
        self.calm = (name, 0.0)
        done, waited = 0, 0.0
        while done < steps:
            share = _ramp((done + 1) / steps)
            if not self.advance(name, share) or waited > MAX_WAIT:
                return False
            if self.is_slow(waited):
                done, waited, self.calm = done + 1, 0.0, (name, share)
            else:
                waited += self.period
        wait = round(settle / self.period)
        for k in range(round(_MAX_SETTLE_FACTOR * wait)):
            if k >= wait and self._is_resting():
                return True
            if not self.advance(name, 1.0):
                return False
        return wait == 0 or self._is_resting()

    def is_slow(self, waited: float, share: float = _DRAG_SHARE) -> bool:
        """Whether the object moves so slowly that damping takes up no more than a share of the load that grows. After a
        load has waited [s] more is slow: creeping past the last balance takes for ever.
        """
        reach, now = self.probe.reach, self.track.readings[-1]
        speed = _FAST_SPEED_SHARE * reach
        leads = _STAGE_PARTS[self.track.stages[-1]]
        grows = [size * self._shares[part] for part, size in self._sizes.items() if part in leads]
        if grows:
            least = _MIN_LOAD_SHARE * float(np.linalg.norm(now.forces, axis=1).sum())
            drag = share * max(sum(grows), least)
            speed = min(speed, max(drag / self._damping, _CREEP_SPEED_SHARE * reach))
        return contact_speed(now.speed, reach) <= speed * (1.0 + waited / _WAIT_SECONDS_SCALE)

    def advance(self, name: str, share: float) -> bool:
        """To this share of a stage, for one period; whether the object is still there."""
        self._shares |= dict.fromkeys(_STAGE_PARTS[name], share)
        now = self._shares
        self.state.drive(self.model, self.data, now["squeeze"], now["weight"], now["load"] * self.wrench, now["sag"])
        if self.state.keeps:  # heavy as well: damping alone, friction would forget what it carries
            kept = self._damped * _HOLD_FACTOR ** (1.0 - now["free"])
            self.model.dof_damping[self._own] = kept
            self.model.dof_armature[self._own] = self._slows * (kept - self._damped)
        self._choose_contacts()
        began = perf_counter()
        with without_mujoco_log():
            self.mujoco.mj_step(self.model, self.data, _STEPS_PER_READING)
        self.seconds += perf_counter() - began
        reading = self.probe.take_reading()
        self.slip += self.period * reading.slip_speed
        self.track.add(name, share, reading)
        carried = reading.forces.any() or not (now["weight"] or now["load"])
        self._adrift = 0.0 if carried else self._adrift + self.period
        # Far from where it started: an object that turns between fingertips is still held
        escaped = math.hypot(*reading.motion[:3]) > _LOST_DISTANCE_FACTOR * self.probe.reach
        return not (escaped or self._adrift > _MAX_SECONDS_ADRIFT)

    def _choose_contacts(self) -> None:
        """Several contacts of a pair of shapes, or one. MuJoCo looks for several where an edge lies along a face; where
        it takes a face that is not the one touched its contacts coincide, and their normal is off by degrees. It then
        looks for one contact, unless others lie apart: shapes that lie flush are held by more than one.
        """
        options, off = self.model.opt, int(self.mujoco.mjtDisableBit.mjDSBL_MULTICCD)
        options.disableflags &= ~off
        with without_mujoco_log():
            self.mujoco.mj_collision(self.model, self.data)
        if self.probe.has_coinciding_contacts():
            options.disableflags |= off

    def _is_resting(self) -> bool:
        """Over the last readings, so that a turning point is not taken for rest. By speed; or by place, over a longer
        time: where an edge lies along a face MuJoCo may have one contact, now at this end and now at that, and the
        object trembles faster than it gets anywhere.
        """
        reach = self.probe.reach
        if max(contact_speed(r.speed, reach) for r in self.track.readings[-_SPEED_READINGS:]) < _REST_SPEED:
            return True
        return self.track.largest_drift(_PLACE_READINGS, reach) < _REST_SPEED * _PLACE_READINGS * self.period


def _ramp(x: float) -> float:
    """From 0 to 1, starting so slowly that friction, which starts from nothing as well, carries the object along."""
    return x**4 * (5.0 - 4.0 * x)
