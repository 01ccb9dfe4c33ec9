"""Jacobians, flexibility and coupling of a hand against finite differences and against their definitions."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pinocchio as pin
import pytest

from handlcp.hand import example_hand
from tests.support.hand import deflection, mimic

from .conftest import inside

STEP = 1e-6


def differences(hand, q):
    """Central differences of the tip positions, (3n, nv)."""
    columns = []
    for j in range(hand.nv):
        d = np.eye(hand.nv)[j] * STEP
        columns.append((hand.at(q + d).tip_positions - hand.at(q - d).tip_positions).reshape(-1) / (2 * STEP))
    return np.array(columns).T


def test_jacobian_is_the_derivative_of_the_tip_positions(hand):
    """The stacked Jacobian is d(tip position)/dq in world axes, mimic joints included."""
    for seed in range(3):
        q = inside(hand, seed)
        np.testing.assert_allclose(hand.at(q).jacobian, differences(hand, q), atol=1e-9)


def test_mimic_chain_and_continuous_joint(coupled):
    """A mimic of a mimic and an angle kept as (cos, sin): coupling matrix, positions and derivatives."""
    assert set(coupled.joint_names) == {"z1", "w"}
    q = {"z1": 0.2, "w": 4.0}
    state = coupled.at(q)
    model, data = coupled.model, coupled.model.createData()
    full = pin.neutral(model)
    for name, value in {"z1": 0.2, "m2": 0.7 * 0.2 + 0.1, "k3": -2 * (0.7 * 0.2 + 0.1) + 0.05}.items():
        full[model.joints[model.getJointId(name)].idx_q] = value
    at = model.joints[model.getJointId("w")].idx_q
    full[at : at + 2] = np.cos(4.0), np.sin(4.0)
    pin.framesForwardKinematics(model, data, full)
    for name, position in zip(coupled.fingertips, state.tip_positions, strict=True):
        np.testing.assert_allclose(position, data.oMf[model.getFrameId(name)].translation, atol=1e-15)
    np.testing.assert_allclose(state.jacobian, differences(coupled, state.q), atol=1e-9)


def test_mimic_limits_narrow_the_joint_they_follow(coupled):
    """m2 = 0.7 z1 + 0.1 in [-0.5, 0.5] leaves z1 in [-6/7, 4/7]; a continuous joint has no range."""
    z, w = coupled.joint_names.index("z1"), coupled.joint_names.index("w")
    assert coupled.lower[z] == pytest.approx(-6 / 7)
    assert coupled.upper[z] == pytest.approx(4 / 7)
    assert (coupled.lower[w], coupled.upper[w]) == (-np.inf, np.inf)


def test_psyonic_follows_its_urdf():
    """Six independent joints, the four distal ones read from tags that name joints without their prefix."""
    hand = example_hand("psyonic")
    assert hand.nv == 6
    C, offset = mimic(hand)
    assert C.shape == (10, 6)
    assert sorted(np.unique(C[C > 0])) == [1.0, 1.05851325]
    assert sorted(np.unique(offset)) == [0.0, 0.72349796]
    assert hand.finger_joints("Left_index_anchor") == ("Left_index_q1",)


def test_rigid_joints_give_no_way(five):
    """Stiffness inf or None: no deflection, and the same E as a joint that is not there."""
    stiff = dict.fromkeys(five.joint_names, 1.0) | {"finger_1_proximal": None, "finger_3_distal": np.inf}
    hand = example_hand("five_finger", joint_stiffness=stiff, pad_flexibility=0.0)
    q = inside(hand, 4)
    J = hand.at(q).jacobian.copy()
    rigid = [hand.joint_names.index(name) for name in ("finger_1_proximal", "finger_3_distal")]
    J[:, rigid] = 0.0
    np.testing.assert_allclose(hand.at(q).flexibility, J @ J.T, atol=1e-17)
    assert (deflection(hand, np.ones(10))[rigid] == 0).all()
    everything = example_hand("two_finger", joint_stiffness=np.inf, pad_flexibility=0.0)
    assert not everything.at(everything.neutral).flexibility.any()


def test_stiffness_by_name_vector_and_matrix_agree(five):
    """One K in four spellings."""
    k = np.arange(1.0, 11.0)
    spellings = [dict(zip(five.joint_names, k, strict=True)), k, list(k), np.diag(k)]
    states = [example_hand("five_finger", joint_stiffness=s).at(inside(five, 0)).flexibility for s in spellings]
    for E in states[1:]:
        np.testing.assert_allclose(E, states[0], rtol=1e-13, atol=1e-18)


def test_pads_turn_with_the_tips():
    """An anisotropic pad is given in tip axes: its block in world axes is R P Rᵀ."""
    P = np.diag([1e-4, 2e-4, 5e-4])
    hand = example_hand("three_finger", joint_stiffness=np.inf, pad_flexibility=P)
    same = example_hand("three_finger", joint_stiffness=np.inf, pad_flexibility=[1e-4, 2e-4, 5e-4])
    named = example_hand("three_finger", joint_stiffness=np.inf, pad_flexibility={"finger_2_tip": P})
    state = hand.at(inside(hand, 7))
    for i, R in enumerate(state.tip_rotations):
        block = state.flexibility[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]
        np.testing.assert_allclose(block, R @ P @ R.T, atol=1e-18)
    np.testing.assert_array_equal(same.at(state.q).flexibility, state.flexibility)
    only = named.at(state.q).flexibility
    np.testing.assert_array_equal(only[3:6, 3:6], state.flexibility[3:6, 3:6])
    assert not only[:3].any()
    assert not only[6:].any()


def test_states_are_immutable_and_outlive_the_next_call(five):
    """Nothing in a state is a view that the next posture overwrites; nothing can be written."""
    first = five.at(np.zeros(10))
    kept = first.tip_positions.copy(), first.jacobian.copy()
    five.at(np.ones(10))
    np.testing.assert_array_equal(first.tip_positions, kept[0])
    np.testing.assert_array_equal(first.jacobian, kept[1])
    for array in (first.q, first.tip_positions, first.tip_rotations, first.jacobian, first.flexibility, five.lower):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    for owner, name in ((five, "stiffness"), (first, "q"), (first, "jacobian")):
        with pytest.raises(AttributeError, match="immutable"):
            setattr(owner, name, kept[0])


def test_hands_and_states_pickle(hand):
    """A hand that went through pickle gives the same bits."""
    q = inside(hand, 3)
    again = pickle.loads(pickle.dumps(hand))
    np.testing.assert_array_equal(again.at(q).flexibility, hand.at(q).flexibility)
    state = pickle.loads(pickle.dumps(hand.at(q)))
    np.testing.assert_array_equal(state.jacobian, hand.at(q).jacobian)
    assert again.fingertips == hand.fingertips


def test_threads_do_not_mix(five):
    """Each thread has its own Data: many threads at once give what one gives alone."""
    postures = [inside(five, seed) for seed in range(24)]
    alone = [five.at(q).jacobian for q in postures]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda q: five.at(q).jacobian, postures))
    for a, b in zip(alone, together, strict=True):
        np.testing.assert_array_equal(a, b)
