"""Soft fingers on a hand: the moment about a normal loads the joints, and they turn the fingertip under it."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from tests.support.grasp import arrays, with_friction
from tests.support.texts import says

SOFT = hl.SoftFinger(0.6, 0.006, 2.0)
BOX = hl.Box(0.05, (0, 0, 0.08), mass=0.2)


def held(law=SOFT, **more):
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4)
    state = hand.at(hand.close_on(BOX))
    return state.grasp(BOX, law, preload=0.006, **({"wrench": (0, 0, 0, 0.01, 0.02, 0.03)} | more))


@pytest.mark.parametrize("faces", [8, "cone"])
def test_torques_do_the_work_of_forces_and_moments_on_every_joint(faces):
    """Virtual work: τ·δq = Σ f·δp + r_τ n·δφ for the motion that each joint gives the contact points."""
    g = held()
    s = g.solve(faces)
    assert abs(s.torsion).max() > 1e-4
    hand, q, h = g.state.hand, g.state.q, 1e-6
    for j in range(hand.nv):
        step = np.eye(hand.nv)[j] * h
        work = 0.0
        for i, c in enumerate(g.contacts):
            ends = [hand.at(q + sign * step) for sign in (1.0, -1.0)]
            arm = g.state.tip_rotations[i].T @ (c.position - g.state.tip_positions[i])
            p1, p0 = (e.tip_positions[i] + e.tip_rotations[i] @ arm for e in ends)
            R = ends[0].tip_rotations[i] @ ends[1].tip_rotations[i].T
            turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
            work += (s.forces_world[i] @ (p1 - p0) + s.torsion[i] * (c.normal @ turn)) / (2 * h)
        assert s.torques[j] == pytest.approx(work, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("faces", [8, "cone"])
def test_slip_and_spin_are_what_object_and_joints_leave_between_them(faces):
    g = held()
    s = g.solve(faces)
    u, deflection = s.object_displacement, s.joint_deflection
    for i, c in enumerate(g.contacts):
        turned = c.normal @ u[3:] + g.turning[i] @ deflection + SOFT.torsional_flexibility * s.torsion[i]
        assert s.spin[i] == pytest.approx(turned, abs=1e-9)
        moved = c.rotation.T @ (u[:3] + np.cross(u[3:], c.position - g.reference))
        moved = moved + g.jacobian[3 * i : 3 * i + 3] @ deflection + 2e-4 * s.forces[i] + g.offset[i]
        np.testing.assert_allclose([*s.slip[i], s.gap[i]], moved, atol=1e-9)


def test_without_torsion_the_hand_is_the_same_bit_by_bit():
    plain, soft = held(hl.Coulomb(0.6), wrench=None), held(hl.SoftFinger(0.6, 0.0), wrench=None)
    np.testing.assert_array_equal(plain.solve().forces, soft.solve().forces)
    np.testing.assert_array_equal(plain.solve().torques, soft.solve().torques)


def test_a_commanded_joint_turns_the_tip_as_well():
    """Joints commanded beyond the posture preload the moments: the scene's spin is -T δq."""
    g = held()
    command = np.linspace(-0.02, 0.03, g.state.hand.nv)
    moved = g.replace(joint_offset=command)
    np.testing.assert_allclose(arrays(moved).spin / SOFT.lever, -g.turning @ command, atol=1e-15)
    direct = held(joint_offset=command)
    np.testing.assert_allclose(direct.solve("cone").torsion, moved.solve("cone").torsion, atol=1e-12)


def test_a_saturated_joint_feels_the_moment_too():
    g = held()
    free = g.solve("cone")
    limit = 0.9 * abs(free.torques).max()
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4, torque_limits=limit)
    tight = hand.at(g.state.q).grasp(
        BOX, SOFT, (0, 0, 0, 0.01, 0.02, 0.03), preload=0.006, effects=[hl.TorqueSaturation()]
    )
    s = tight.solve("cone")
    assert s.joint_yield.any()
    assert abs(s.torques).max() <= limit * (1 + 1e-9)
    torques = s.forces.ravel() @ tight.jacobian + s.torsion @ tight.turning
    np.testing.assert_allclose(torques, s.torques, atol=1e-8 * limit)


def test_a_hand_given_its_own_flexibility_again_is_the_same_bit_by_bit():
    """Flexibility is that of the points; what the joints turn by comes with it, also beside a table."""
    for more in ({}, {"environment": hl.Table((0, 0, 0.055), flexibility=1e-3)}):
        g = held(**more)
        again = g.replace(flexibility=g.flexibility[:9, :9])
        np.testing.assert_array_equal(arrays(again).flexibility, arrays(g).flexibility)
        assert abs(arrays(g).flexibility[:9, 3 * arrays(g).n :]).max() > 0.0
        softer = g.replace(flexibility=g.flexibility[:9, :9] + 1e-4 * np.eye(9))
        assert np.linalg.eigvalsh(arrays(softer).flexibility).min() > -1e-15


def test_a_flexibility_below_that_of_the_joints_is_refused():
    """Joints that turn a fingertip move it, too: no E could have the one without the other."""
    with pytest.raises(hl.InputError) as caught:
        held().replace(flexibility=1e-6)
    assert caught.value.argument == "flexibility"
    says(caught.value.expected, "beside")
    rigid = arrays(held().replace(flexibility=0.0)).flexibility
    np.testing.assert_array_equal(np.diag(rigid)[:9], 0.0)
    assert np.diag(rigid)[9:].all()  # the pads' own


@pytest.mark.parametrize("effects", [[], [hl.TorqueSaturation(), hl.SoftWrist([1e-4] * 3 + [0.1] * 3)]])
def test_patches_that_lose_their_friction_leave_the_grasp_of_smooth_fingers(effects):
    """Who is soft may change: flexibility, limits and torques follow."""
    smooth, made = with_friction(held(effects=effects), 0.0), held(hl.Frictionless(), effects=effects)
    np.testing.assert_array_equal(arrays(smooth).flexibility, arrays(made).flexibility)
    np.testing.assert_array_equal(smooth.problem().M, made.problem().M)
    assert smooth.turning.shape == (0, 6)
    assert smooth.solve(throw=False).status is hl.Status.NOT_HOLDABLE


def test_moments_stay_with_the_fingers_that_are_soft():
    g = held({"finger_1_tip": SOFT, "finger_2_tip": hl.Coulomb(0.6), "finger_3_tip": SOFT})
    s = g.solve("cone")
    assert s.torsion[1] == 0.0
    assert abs(s.torsion[[0, 2]]).min() > 0.0
    assert g.turning.shape == (2, g.state.hand.nv)
