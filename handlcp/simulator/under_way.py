"""A simulation under way: stages in which commands, weight and load grow, and what is read meanwhile."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp import Grasp
from handlcp.simulator.loss import Track, escaped, lost_at
from handlcp.simulator.mjcf.object_body import OBJECT
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.need import need_mujoco
from handlcp.simulator.probe import Probe
from handlcp.simulator.refusals import of_a_hand
from handlcp.simulator.write import to_mujoco

__all__ = ["PUSH", "SAG", "Run"]

SAG = "own weight"  # the stage before all others where the hand's links bend its joints
PUSH = "load alone"  # the stage in which the load grows beside a weight that is there already
_LEADS = {
    "squeeze": ("squeeze",), "load": ("weight", "load"), "together": ("squeeze", "weight", "load"),
    "weight": ("weight",), PUSH: ("load",), SAG: ("sag",),
}  # fmt: skip
_READ = 10  # time steps between two readings, and between two changes of what drives the simulation
_REST = 1e-5  # [m/s] an object that moves slower is at rest
_PATIENCE = 8.0  # times `settle` that an object may take to come to rest


class Run:
    """A grasp in MuJoCo, from where its fingertips touch the object.

    load (6,) : as in `simulate`; None: the grasp's own. slip (n, 3) : so far. seconds : of MuJoCo's steps so far.
    period : [s] between two readings. Raises as `to_mujoco`; Unsupported where MuJoCo is not installed.
    """

    def __init__(self, grasp: Grasp, load: Array | None, settings: SimulatorSettings | None) -> None:
        self.mujoco = need_mujoco()
        xml, self.state = to_mujoco(grasp, settings)
        self.model = self.mujoco.MjModel.from_xml_string(xml)
        self.data: Any = self.mujoco.MjData(self.model)
        self.state.put(self.model, self.data, 0.0, 0.0)
        self.state.drive(self.model, self.data, 0.0, 0.0, sag=0.0)
        self.grasp = of_a_hand(grasp)
        self.probe = Probe(self.grasp, self.model, self.data)
        self.wrench = self.state.wrench if load is None else load
        self.slip, self.seconds = np.zeros((len(self.probe.names), 3)), 0.0
        self.period = _READ * float(self.model.opt.timestep)
        self.track = Track(self.period)
        self._shares = {"squeeze": 0.0, "weight": 0.0, "load": 0.0, "sag": 0.0 if self.state.weighing else 1.0}

    @property
    def before(self) -> tuple[str, ...]:
        """Stages that come before those asked for."""
        return (SAG,) if self.state.weighing else ()

    def stage(self, name: str, seconds: float, settle: float) -> bool:
        """Ramp one stage and wait for rest; whether the object is still there."""
        steps = max(round(seconds / self.period), 1)
        for k in range(steps):
            if not self.advance(name, _ramp((k + 1) / steps)):
                return False
        wait = round(settle / self.period)
        for k in range(round(_PATIENCE * wait)):
            if k >= wait and self._resting():
                return True
            if not self.advance(name, 1.0):
                return False
        return wait == 0 or self._resting()

    def advance(self, name: str, share: float) -> bool:
        """To this share of a stage, for one period; whether the object is still there."""
        self._shares |= dict.fromkeys(_LEADS[name], share)
        now = self._shares
        self.state.drive(self.model, self.data, now["squeeze"], now["weight"], now["load"] * self.wrench, now["sag"])
        began = perf_counter()
        self.mujoco.mj_step(self.model, self.data, _READ)
        self.seconds += perf_counter() - began
        reading = self.probe.read()
        self.slip += self.period * reading.slipping
        self.track.add(name, share, reading)
        return not escaped(reading, self.probe.reach)

    def lost(self) -> tuple[str, float]:
        """Stage and share at which it was lost."""
        reach, mass = self.probe.reach, float(self.model.body_subtreemass[self.model.body(OBJECT).id])
        load = self.grasp.spec.wrench - self.state.wrench + self.wrench
        size = float(np.linalg.norm(load[:3]) + np.linalg.norm(load[3:]) / reach)
        return lost_at(self.track.record(), reach, mass, size)

    def _resting(self) -> bool:
        """Over the last readings, so that a turning point is not taken for rest."""
        return self.track.fastest(50, self.probe.reach) < _REST


def _ramp(x: float) -> float:
    """From 0 to 1, starting so slowly that friction, which starts from nothing as well, carries the object along."""
    return x**4 * (5.0 - 4.0 * x)
