"""Where a simulation starts, what the hand is told, and what the object carries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.simulator.mjcf.object_body import LOADED, OBJECT
from handlcp.simulator.refusals import need_mujoco


@dataclass(frozen=True, eq=False)
class SimulatorState:
    """What the MJCF of `to_mujoco` leaves open. Immutable.

    positions : of all movable joints of the hand where the grasp begins, by name [rad, m].
    before, after : commands of the actuators at the start and with all of the squeeze, by name [rad, m].
    mass : [kg] of the object's weight; the mass with which it moves is another.
    weighing : bodies of the hand whose weight bends its joints, by name; none where the grasp leaves it out.
    wrench : (6,) force [N] and torque [N·m] on the object besides its weight, world axes. The force acts at the
        point of the object that the grasp's reference is at the start, and moves with it; the torque keeps its axes.
    """

    positions: Mapping[str, float]
    before: Mapping[str, float]
    after: Mapping[str, float]
    mass: float
    weighing: tuple[str, ...]
    wrench: Array

    def put(self, model: Any, data: Any, squeeze: float = 1.0, load: float = 1.0) -> None:
        """Put a simulation at its start, with these shares of squeeze, and of weight and load.

        model, data : mujoco.MjModel and MjData of the MJCF. The share of the weight is kept in the model.
        """
        mujoco = need_mujoco()
        mujoco.mj_resetData(model, data)
        for name, value in self.positions.items():
            data.qpos[model.jnt_qposadr[model.joint(name).id]] = value
        self.drive(model, data, squeeze, load)
        mujoco.mj_forward(model, data)

    def drive(
        self, model: Any, data: Any, squeeze: float, load: float, wrench: Array | None = None, sag: float = 1.0
    ) -> None:
        """Set the shares of squeeze, and of weight and load, while a simulation runs.

        wrench : (6,) instead of the state's own; all of it. sag : share of the weight of the hand's own links.
        """
        for name, start in self.before.items():
            data.ctrl[model.actuator(name).id] = start + squeeze * (self.after[name] - start)
        for name in self.weighing:
            model.body_gravcomp[model.body(name).id] = 1.0 - sag
        body = model.body(OBJECT).id
        model.body_gravcomp[body] = 1.0 - load * self.mass / model.body_mass[body]
        data.xfrc_applied[model.body(LOADED).id] = load * self.wrench if wrench is None else np.array(wrench)
