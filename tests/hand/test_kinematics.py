"""Jacobians, flexibility and coupling of a hand against finite differences and against their definitions."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pinocchio as pin
import pytest

from handlcp.hand import Hand, example_hand
from tests.support.hand import configuration, deflection, elastic_flexibility, jacobian_at, mimic

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


def test_rotations_are_those_of_the_tip_frames(five):
    """Tip rotations agree with Pinocchio's, and moving a point with its tip is v + ω × p."""
    q = inside(five, 5)
    state = five.at(q)
    model, data = five.model, five.model.createData()
    pin.framesForwardKinematics(model, data, q)
    for name, R in zip(five.fingertips, state.tip_rotations, strict=True):
        np.testing.assert_allclose(R, data.oMf[model.getFrameId(name)].rotation, atol=1e-15)
    local = np.random.default_rng(0).normal(size=(5, 3)) * 0.01

    def points(q):
        s = five.at(q)
        return s.tip_positions + (s.tip_rotations @ local[:, :, None])[:, :, 0]

    J = jacobian_at(state, points(q))
    for j in range(five.nv):
        d = np.eye(five.nv)[j] * STEP
        np.testing.assert_allclose(J[:, :, j], (points(q + d) - points(q - d)) / (2 * STEP), atol=1e-9)


def test_flexibility_is_j_kinv_jt_plus_pads(hand):
    """E against J K⁻¹ Jᵀ + c I, symmetric to the last bit and PSD; the joints alone leave it singular."""
    state = hand.at(inside(hand, 1))
    J, n = state.jacobian, len(hand.fingertips)
    expected = J @ np.linalg.inv(hand.joint_stiffness) @ J.T + 1e-4 * np.eye(3 * n)
    np.testing.assert_allclose(state.flexibility, expected, rtol=1e-12, atol=1e-16)
    assert (state.flexibility == state.flexibility.T).all()
    bare = elastic_flexibility(hand, J)
    eig = np.linalg.eigvalsh(bare)
    assert eig[0] > -1e-16
    assert np.linalg.matrix_rank(bare, tol=1e-12) <= min(hand.nv, 3 * n)


def test_tendons_couple_the_joints(five):
    """A full SPD K: E = J K⁻¹ Jᵀ and the joint deflection K⁻¹ τ, without an inverse in the code."""
    rng = np.random.default_rng(3)
    A = rng.normal(size=(10, 10))
    K = A @ A.T + 10 * np.eye(10)
    hand = example_hand("five_finger", joint_stiffness=K, pad_flexibility=0.0)
    state = hand.at(inside(hand, 2))
    expected = state.jacobian @ np.linalg.solve(K, state.jacobian.T)
    np.testing.assert_allclose(state.flexibility, expected, rtol=1e-10, atol=1e-14)
    assert (state.flexibility == state.flexibility.T).all()
    tau = rng.normal(size=10)
    np.testing.assert_allclose(deflection(hand, tau), np.linalg.solve(K, tau), rtol=1e-10)
    assert np.linalg.matrix_rank(state.flexibility) <= 10


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


def test_q_by_name_and_by_position_agree(hand):
    """A mapping in any order gives the same bits as the vector."""
    q = inside(hand, 9)
    named = dict(reversed(list(zip(hand.joint_names, q, strict=True))))
    np.testing.assert_array_equal(hand.at(named).jacobian, hand.at(q).jacobian)


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
    with pytest.raises(AttributeError, match="immutable"):
        five.stiffness = None
    with pytest.raises(AttributeError, match="immutable"):
        first.q = kept[0]
    with pytest.raises(AttributeError):
        first.jacobian = kept[1]


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
    postures = [inside(five, seed) for seed in range(64)]
    alone = [five.at(q).jacobian for q in postures]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda q: five.at(q).jacobian, postures))
    for a, b in zip(alone, together, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_pinocchio_model_makes_the_same_hand(five):
    """From the model instead of the file, and later changes of the model change nothing."""
    model = five.model
    hand = Hand.from_urdf(model, joint_stiffness=1.0, pad_flexibility=1e-4)
    q = inside(five, 6)
    model.jointPlacements[1].translation = np.ones(3)
    np.testing.assert_array_equal(hand.at(q).flexibility, five.at(q).flexibility)
    np.testing.assert_array_equal(hand.torque_limits, five.torque_limits)


def test_fingers_weight_is_the_gradient_of_their_potential_energy(coupled):
    """g(q) over the independent joints against differences of the potential energy, gravity in any direction."""
    gravity = np.array([1.0, -3.0, -9.0])
    model = coupled.model
    model.gravity.linear = gravity
    data = model.createData()

    def energy(q):
        return float(pin.computePotentialEnergy(model, data, configuration(coupled, q)))

    q = np.array([0.3, 1.0])
    slope = [(energy(q + d) - energy(q - d)) / (2 * STEP) for d in np.eye(2) * STEP]
    np.testing.assert_allclose(coupled.at(q).gravity_torque(gravity), slope, atol=1e-8)
    assert not np.allclose(coupled.at(q).gravity_torque(), coupled.at(q).gravity_torque(gravity))
