"""Soft fingers on a hand: the moment about a normal loads the joints, and they turn the fingertip under it."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.grasp import arrays, with_friction
from tests.support.refusals import refused
from tests.support.texts import says

SOFT = hl.SoftFinger(0.6, 0.006, 2.0)
BOX = hl.Box(0.05, (0, 0, 0.08), mass=0.2)


def held(law=SOFT, **more):
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4)
    state = hand.at(hand.close_on(BOX))
    return state.grasp(BOX, law, preload=0.006, **({"wrench": (0, 0, 0, 0.01, 0.02, 0.03)} | more))


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
    caught = refused("flexibility", held().replace, flexibility=1e-6)
    says(caught.expected, "beside")
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
