"""Tests that others publish, again in MuJoCo: levers of a finger, a ball that is pulled out, one that is shaken."""

import numpy as np
import pytest

pytest.importorskip("mujoco")

import mujoco

import handlcp as hl
from handlcp.simulator import SimulatorSettings, simulate_limit
from handlcp.studies.published.lift_and_shake import SHAKE_ACCELERATION, shake_grasp
from tests.mujoco.case import started
from tests.support.published import gripper
from tests.support.squeezed import MU, G

FORCE, WIDE, DOWN, HERTZ = 10.0, 0.05, np.array([0.0, 0.0, 1.0]), 2.0
SOFT = hl.SoftFinger(MU, 0.01)  # so that the ball does not turn about the line between two points


def ball(folder, mass, grip=FORCE):
    """Under the largest weight of the shake, between two jaws that press with all their force, or less."""
    hand = gripper(folder, FORCE)
    obj = hl.Sphere(0.5 * WIDE, placement=(0, 0, 0.1), mass=mass)
    gravity = (G + SHAKE_ACCELERATION) * DOWN
    return hand.at(hand.close_on(obj)).grasp(obj, friction=SOFT, gravity=gravity, grip_force=grip)


def test_a_finger_that_presses_has_the_levers_of_mujocos_jacobian():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    cube = hl.Box(0.05, placement=(0, 0, 0.08))
    grasp = hand.at(hand.close_on(cube)).grasp(cube)
    model, data, _ = started(grasp)
    for row in hl.finger_strength(hand, postures={"on the cube": grasp.state.q}).rows:
        J, body = np.zeros((3, model.nv)), model.body(row.finger.replace("_tip", "_distal")).id
        mujoco.mj_jac(model, data, J, None, row.at, body)
        joints = [model.joint(name).dofadr[0] for name in hand.joint_names]
        levers = abs(J.T @ row.direction)[joints]
        with np.errstate(divide="ignore"):
            assert row.force == pytest.approx(float((hand.torque_limits / levers).min()), rel=1e-6)


def test_a_ball_is_pulled_out_with_the_force_of_slip_resistance(tmp_path):
    grasp = ball(tmp_path, 0.0, 0.8 * FORCE)
    found = hl.slip_resistance(grasp)
    theirs = simulate_limit(grasp, np.append(found.axis, np.zeros(3)), 1.3 * found.force, seconds=1.0)
    assert found.force == pytest.approx(2 * MU * 0.8 * FORCE, rel=1e-4)
    assert theirs.factor == pytest.approx(found.force, rel=0.02)
    assert theirs.joint == ""
    assert set(theirs.slides + theirs.gone) == {"left", "right"}


@pytest.mark.long
@pytest.mark.parametrize(("share", "holds"), [(0.9, True), (1.15, False)])
def test_a_ball_that_is_really_shaken_moves_as_far_or_falls(tmp_path, share, holds):
    """Gravity that swings is a hand that is shaken, as the ball feels it, with all its inertia."""
    mass = share * 2 * MU * FORCE / (G + SHAKE_ACCELERATION)
    grasp = ball(tmp_path, mass)
    ours = shake_grasp(grasp, "sphere", WIDE, DOWN)
    assert ours.held is holds
    still = SimulatorSettings(object_mass=mass, object_damping=0.5)
    model, data, state = started(grasp.replace(gravity=G * DOWN), settings=still)
    z = model.jnt_qposadr[model.joint("object z").id]
    path, step, before = list[float](), model.opt.timestep, 0.4
    while data.time < before + 1.5 / HERTZ and abs(data.qpos[z]) < WIDE:
        grown = min(data.time / 0.2, 1.0)
        swing = np.sin(2 * np.pi * HERTZ * max(data.time - before, 0.0))
        state.drive(model, data, grown, np.clip(data.time / 0.2 - 1.0, 0.0, 1.0))
        model.opt.gravity[:] = (G + SHAKE_ACCELERATION * swing) * DOWN
        mujoco.mj_step(model, data, round(1e-3 / step))
        path.append(float(data.qpos[z]))
    fell = abs(path[-1]) >= WIDE
    assert fell is not holds
    if holds:
        assert max(path) == pytest.approx(ours.moved, rel=0.1)
