"""The motors that a brief takes, in MuJoCo: with the answer the object stays, with less grip it slips, and falls."""

from __future__ import annotations

import pytest

pytest.importorskip("mujoco")

from handlcp.simulator import compare
from tests.design.hands import cube_grasp

SAFETY = 1.5


@pytest.mark.long
def test_a_simulated_hand_holds_the_cube_with_these_motors_and_loses_it_with_less_grip():
    grasp = cube_grasp()
    r = grasp.required_torque(safety=SAFETY)
    heavy = grasp.replace(mass=SAFETY * grasp.target.mass)
    safe = {name: 1.03 * force for name, force in r.grip.items()}  # a thousandth less than the grip itself is lost
    held = compare(heavy.replace(grip_force=safe), steps=8, seconds=1.0)
    assert held.simulation.held
    assert (abs(held.simulation.torques) <= 1.04 * r.torque).all()
    assert held.torque_error < 0.01
    share = 0.75
    less = {name: share * force for name, force in r.grip.items()}
    lost = compare(heavy.replace(grip_force=less), steps=8)
    assert not lost.simulation.held
    record = lost.simulation.record
    reached = max(x for x, stage in zip(record.shares, record.stages, strict=True) if stage == "load")
    assert reached == pytest.approx(share, rel=0.03)  # what this grip carries; then it slides through
