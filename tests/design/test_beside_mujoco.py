"""The motors that a brief takes, in MuJoCo: with the answer the object stays, with less grip it slips, and falls."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

from handlcp.simulator import compare
from tests.design.hands import cube_grasp

SAFETY = 1.5
USED = 0.97  # of the friction of every finger


def test_a_simulated_hand_holds_the_cube_with_these_motors_and_loses_it_with_less_grip():
    grasp = cube_grasp()
    r = grasp.required_torque(safety=SAFETY)
    heavy = grasp.replace(mass=SAFETY * grasp.target.mass)
    held = compare(heavy.replace(grip_force=r.grip), steps=8, seconds=1.0)
    assert held.simulation.held
    assert (abs(held.simulation.torques) <= 1.01 * r.torque).all()
    assert held.torque_error < 0.01
    share = 0.75
    less = {name: share * force for name, force in r.grip.items()}
    lost = compare(heavy.replace(grip_force=less), steps=8)
    assert not lost.simulation.held
    record = lost.simulation.record
    slips = (record.friction >= USED).all(axis=1) & (np.array(record.stages) == "load")
    first = record.shares[np.argmax(slips)]
    assert first == pytest.approx(USED * share, rel=0.03)  # what this grip carries; then it slides through
