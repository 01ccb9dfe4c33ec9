"""Every example runs, is held within its torque limits, and yields the number that mechanics asks for."""

import importlib.util
import pathlib
from functools import cache

import numpy as np
import pytest

from handlcp.scene import load
from tests.support.grasp import arrays

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
G = 9.81
CONE = np.cos(np.pi / 8)  # where eight inscribed faces let a finger slide


def script(name):
    spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def solved(name):
    grasp = load(EXAMPLES / f"{name}.toml").build()
    return grasp, grasp.solve()


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_each_scene_is_held_by_its_motors_with_small_motions_and_forces_of_a_few_newtons(file):
    grasp, s = solved(file.stem)
    v = grasp.check(faces=8, solution=s)
    assert v.word == "HELD", "squeezed, then loaded"
    assert {r.code for r in v.warnings} <= {"link_inside", "closing_torque"}
    assert s.torque_check.ok
    assert 0.02 < s.torque_check.utilisation.max() < 0.6
    assert 0.5 < s.normal_force.max() < 10.0
    assert np.linalg.norm(s.object_displacement[3:]) < 0.1
    np.testing.assert_allclose(s.forces_world.sum(0), -arrays(grasp).force, atol=1e-7 * np.abs(s.forces).max())


def test_the_cube_hangs_in_friction_and_its_flanks_pull_against_the_front():
    grasp, s = solved("cube_three_fingers")
    front, left, right = s.forces_world
    # No normal of this cube has a vertical part: friction carries 0.2 kg · g
    assert abs(grasp.frames[:, 2, 2]).max() < 1e-9
    assert s.forces_world[:, 2].sum() == pytest.approx(0.2 * G, rel=1e-9)
    # The flanks' friction balances the front finger's push, half each
    assert left[0] == pytest.approx(-front[0] / 2, rel=1e-6)
    np.testing.assert_allclose(left * (1, -1, 1), right, atol=1e-6)
    assert s.friction_used.max() < CONE


def test_the_cubes_binding_joint_bears_its_fingertips_force_times_its_lever():
    grasp, s = solved("cube_three_fingers")
    assert s.torque_check.binding in ("finger_2_proximal", "finger_3_proximal")
    angle = 2 * np.pi / 3  # finger 2 stands here on a circle of 45 mm; its joints turn about the tangent
    axis = np.array([np.sin(angle), -np.cos(angle), 0.0])
    base = 0.045 * np.array([np.cos(angle), np.sin(angle), 0.0])
    expected = axis @ np.cross(arrays(grasp).positions[1] - base, s.forces_world[1])
    row = s.torque_check["finger_2_proximal"]
    assert row.torque == pytest.approx(expected, rel=1e-9)
    assert row.torque == pytest.approx(0.3035, abs=0.0005)
    assert row.utilisation == pytest.approx(expected / 0.8, rel=1e-9)


def test_the_balls_five_fingers_share_its_weight():
    _, s = solved("ball_five_fingers")
    np.testing.assert_allclose(-s.forces_world[:, 2], 0.3 * G / 5, rtol=1e-4)
    np.testing.assert_allclose(s.normal_force, s.normal_force[0], rtol=1e-4)
    assert set(s.contact_state) == {"sticking"}


def test_the_ring_mirrors_left_and_right_and_its_lower_fingers_bear_the_disc():
    _, s = solved("planar_ring")
    f = s.forces_world
    for left, right in ((3, 0), (2, 1), (4, 5)):
        np.testing.assert_allclose(f[left] * (-1, 1, 1), f[right], atol=1e-6)
    assert f[:, 1].sum() == pytest.approx(0.3 * G, rel=1e-9)
    assert abs(f[:, 2]).max() == 0.0, "nothing acts out of the plane"
    assert s.normal_force[4] > s.normal_force[0] > s.normal_force[1]
    assert abs(s.object_displacement[[0, 5]]).max() < 1e-9, "the disc sinks straight down"
    assert s.object_displacement[1] == pytest.approx(-0.293e-3, abs=0.002e-3)


def test_the_allegros_thumb_carries_the_ball_and_the_other_two_fingers():
    _, s = solved("allegro_pinch")
    thumb = list(s.names).index("link_15.0_tip")
    up = s.forces_world[:, 2]
    assert up[thumb] == pytest.approx(0.1 * G - np.delete(up, thumb).sum(), rel=1e-9)
    assert up[thumb] > 0.1 * G > 0 > np.delete(up, thumb).max()
    assert s.torque_check.binding == "joint_14.0", "the thumb's own joint gives out first"
    assert s.torque_check["joint_14.0"].utilisation == pytest.approx(0.25, abs=0.02)
    assert [s.torque_check[f"joint_{k}.0"].torque for k in (8, 9, 10, 11)] == [0.0] * 4, "the ring finger is at rest"
    assert s.friction_used.max() < CONE


def test_the_psyonic_holds_the_can_by_friction_alone():
    grasp, s = solved("psyonic_grasp")
    vertical = grasp.frames[:, 0, 2]
    assert abs(vertical).max() < 1e-3, "the can's wall is upright: no normal force can carry it"
    assert s.forces_world[:, 0].sum() == pytest.approx(0.2 * G, rel=1e-7)
    sliding = [used for used, state in zip(s.friction_used, s.contact_state, strict=True) if state == "sliding"]
    assert sliding
    assert all(CONE - 1e-6 <= used <= 1 + 1e-6 for used in sliding)
    assert s.contact_state[0] == "sticking", "the thumb does not slide"


def test_the_psyonics_coupled_joints_bear_what_virtual_work_says():
    grasp, s = solved("psyonic_grasp")
    hand, q = grasp.state.hand, grasp.state.q
    tips = [hand.fingertips.index(name) for name in s.names]
    local = [
        R.T @ (p - t)
        for R, p, t in zip(grasp.state.tip_rotations[tips], arrays(grasp).positions, grasp.state.tip_positions[tips],
                           strict=True)
    ]  # fmt: skip
    for joint in range(hand.nv):
        ahead, behind = (hand.at(q + h * np.eye(hand.nv)[joint]) for h in (1e-6, -1e-6))
        moved = [
            (a.tip_positions[t] + a.tip_rotations[t] @ x) - (b.tip_positions[t] + b.tip_rotations[t] @ x)
            for (a, b), t, x in zip([(ahead, behind)] * len(tips), tips, local, strict=True)
        ]
        work = sum(float(f @ d) for f, d in zip(s.forces_world, moved, strict=True)) / 2e-6
        assert s.torques[joint] == pytest.approx(work, abs=1e-6)


def test_the_table_bears_most_of_the_box_and_of_the_push():
    grasp, s = solved("box_on_table")
    fingers, table = s.forces_world[:2], s.forces_world[2:]
    assert -table[:, 2].sum() == pytest.approx(0.5 * G + fingers[:, 2].sum(), rel=1e-9)
    assert 0.1 * 0.5 * G < -fingers[:, 2].sum() < 0.2 * 0.5 * G, "the box sinks, and the fingers bear some of it"
    assert s.normal_force[:2].mean() == pytest.approx(1.4, abs=0.05), "they were told 1.5 N on a box that stays"
    assert s.contact_state[2:] == ("sticking",) * 4
    assert table[:, 0].sum() == pytest.approx(-0.956, abs=0.001), "of 1 N"
    # A foot that sticks sinks by its flexibility times its force, and the rigid box with it
    u, arms = s.object_displacement, arrays(grasp).positions[2:] - grasp.reference
    sunk = u[:3] + np.cross(u[3:], arms)
    np.testing.assert_allclose(sunk, -1e-4 * table, rtol=1e-9, atol=1e-15)


def test_the_quickstart_runs_and_its_own_assertions_hold(capsys):
    s = script("quickstart").main()
    assert s.held
    assert s.torque_check.binding in capsys.readouterr().out


def test_the_quickstart_is_the_same_grasp_as_the_scene_file():
    _, s = solved("ball_five_fingers")
    np.testing.assert_allclose(script("quickstart").main().forces, s.forces, rtol=1e-9, atol=1e-12)
