"""A grasp in MuJoCo, quasi-statically: the hand squeezes, then weight and load come, all slowly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.simulator.loss import Record, Track, escaped, lost_at
from handlcp.simulator.mjcf.object_body import OBJECT
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.need import need_mujoco
from handlcp.simulator.probe import Probe
from handlcp.simulator.refusals import of_a_hand
from handlcp.simulator.state import SimulatorState
from handlcp.simulator.write import to_mujoco

__all__ = ["SAG", "Simulation", "simulate"]

_READ = 10  # time steps between two readings, and between two changes of what drives the simulation
SAG = "own weight"  # the stage before all others where the hand's links bend its joints
_REST = 1e-5  # [m/s] an object that moves slower is at rest
_PATIENCE = 8.0  # times `settle` that an object may take to come to rest


@dataclass(frozen=True, eq=False, kw_only=True)
class Simulation:
    """The end of a simulated loading. n contacts, the fingers' first; nv independent joints. World axes.

    held : whether the object is still in the hand, at rest, under all of the load.
    lost_stage, lost_at : where it was lost: the stage's name, and the share of that stage; None where it is held.
    forces_world (n, 3) [N] on the object. torques (nv,) [N·m] of the joints' springs.
    displacement (6,) [m, rad] of the object since the start: translation of the reference point, rotation vector.
    q (nv,) [rad, m] where the joints are. slip (n, 3) [m] of the object along each contact, summed over time.
    names : of the contacts. record : the same over time. simulated : [s]. seconds : [s] of MuJoCo's steps,
    without reading them.
    """

    held: bool
    lost_stage: str | None
    lost_at: float | None
    forces_world: Array
    torques: Array
    displacement: Array
    q: Array
    slip: Array
    names: tuple[str, ...]
    record: Record
    simulated: float
    seconds: float

    def __repr__(self) -> str:
        where = "held" if self.held else f"lost at {self.lost_at:.1%} of {self.lost_stage}"
        return f"Simulation({where})"


def simulate(
    grasp: Grasp, load: Any = None, order: Sequence[str] | str = ("squeeze", "load"), *, seconds: float = 2.0,
    settle: float = 0.5, settings: SimulatorSettings | None = None,
) -> Simulation:  # fmt: skip
    """Load a grasp in MuJoCo, slowly enough to be static.

    load : (6,) force [N] and torque [N·m] on the object besides its weight at the end; None: the grasp's own. The force
        acts at the point of the object that the reference is at the start; the torque keeps its axes in the world.
    order : ("squeeze", "load"): commands first, then weight and load; "together": all in proportion.
    seconds : of each stage, smooth at both ends; where contacts slide, 8 s are safer. settle : [s] to come to rest
        after each. settings : as in `to_mujoco`.

    Raises what `to_mujoco` raises; Unsupported where MuJoCo is not installed.
    """
    mujoco, stages = need_mujoco(), _stages(order)
    seconds, settle = number("seconds", seconds, above=0.0), number("settle", settle, minimum=0.0)
    xml, state = to_mujoco(grasp, settings)
    wrench = state.wrench if load is None else array("load", load, (6,))
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    state.put(model, data, 0.0, 0.0)
    state.drive(model, data, 0.0, 0.0, sag=0.0)
    the_grasp = of_a_hand(grasp)
    run = _Run(mujoco, model, data, state, Probe(the_grasp, model, data), wrench)
    stages = (SAG, *stages) if state.weighing else stages
    held = all(run.stage(name, seconds, settle) for name in stages)
    record = run.track.record()
    q, torques = run.probe.joints()
    stage, share = (None, None) if held else run.lost(the_grasp.spec.wrench - state.wrench + wrench)
    forces, motion = read_only(record.forces[-1]), read_only(record.motion[-1])
    return Simulation(
        held=held, lost_stage=stage, lost_at=share, forces_world=forces, torques=read_only(torques),
        displacement=motion, q=read_only(q), slip=read_only(run.slip), names=run.probe.names, record=record,
        simulated=float(data.time), seconds=run.seconds,
    )  # fmt: skip


def _stages(order: Any) -> tuple[str, ...]:
    if order == "together":
        return ("together",)
    if not isinstance(order, str) and tuple(order) in {("squeeze", "load"), ("squeeze",)}:
        return tuple(order)
    raise InputError("order", '("squeeze", "load"), ("squeeze",) or "together"', repr(order))


def _ramp(x: float) -> float:
    """From 0 to 1, starting so slowly that friction, which starts from nothing as well, carries the object along."""
    return x**4 * (5.0 - 4.0 * x)


class _Run:
    """A simulation under way."""

    def __init__(self, mujoco: Any, model: Any, data: Any, state: SimulatorState, probe: Probe, wrench: Array) -> None:
        self.mujoco, self.model, self.data = mujoco, model, data
        self.state, self.probe, self.wrench = state, probe, wrench
        self.slip = np.zeros((len(probe.names), 3))
        self.squeeze = self.load = self.seconds = 0.0
        self.period = _READ * float(model.opt.timestep)
        self.track = Track(self.period)

    def stage(self, name: str, seconds: float, settle: float) -> bool:
        """Ramp one stage and wait for rest; whether the object is still there."""
        steps = max(round(seconds / self.period), 1)
        for k in range(steps):
            if not self._advance(name, _ramp((k + 1) / steps)):
                return False
        wait = round(settle / self.period)
        for k in range(round(_PATIENCE * wait)):
            if k >= wait and self._resting():
                return True
            if not self._advance(name, 1.0):
                return False
        return wait == 0 or self._resting()

    def lost(self, load: Array) -> tuple[str, float]:
        """Where it was lost, under a load (6,) about the reference."""
        reach, mass = self.probe.reach, float(self.model.body_subtreemass[self.model.body(OBJECT).id])
        size = float(np.linalg.norm(load[:3]) + np.linalg.norm(load[3:]) / reach)
        return lost_at(self.track.record(), reach, mass, size)

    def _advance(self, name: str, share: float) -> bool:
        if name in ("squeeze", "together"):
            self.squeeze = share
        if name in ("load", "together"):
            self.load = share
        sag = share if name == SAG else 1.0
        self.state.drive(self.model, self.data, self.squeeze, self.load, self.load * self.wrench, sag)
        began = perf_counter()
        self.mujoco.mj_step(self.model, self.data, _READ)
        self.seconds += perf_counter() - began
        reading = self.probe.read()
        self.slip += self.period * reading.slipping
        self.track.add(name, share, reading)
        return not escaped(reading, self.probe.reach)

    def _resting(self) -> bool:
        """Over the last readings, so that a turning point is not taken for rest."""
        return self.track.fastest(50, self.probe.reach) < _REST
