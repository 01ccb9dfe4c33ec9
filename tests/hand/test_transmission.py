"""Tendons and synergies, against fingertip stiffnesses written down, mimic joints, and hands with plain springs."""

import dataclasses
import pickle
import re

import numpy as np
import pytest

from handlcp import Box, Sphere, Synergies, Tendons
from handlcp.errors import InputError, UnknownName, Unsupported
from handlcp.hand import Hand, example_hand
from tests.support.hand import full_positions

from .chains import A, B, chain_hand
from .conftest import MIMIC
from .levers import L, lever_hand, lever_pinch

P1, P2, R1, R2, KT = 0.3, 0.2, 0.008, 0.005, 4e4  # N·m/rad, m, N/m
BALL = Sphere(0.03, (0, 0, 0.085), mass=0.2)
OTHER = {"right_root": 1.0, "right_end": 1.0}


def one_tendon(write, k=KT, **passive):
    flexor = {"left_root": R1, "left_end": R2}
    return chain_hand(write, joint_stiffness=Tendons({"flexor": flexor}, k, passive | OTHER))


# ---------------------------------------------------------------- written down
def test_one_tendon_over_two_joints_gives_the_fingertip_this_stiffness(write):
    """J = (A + B, B) sideways: E = ((A + B)² K₂₂ - 2 (A + B) B K₁₂ + B² K₁₁) / det K."""
    hand = one_tendon(write, left_root=P1, left_end=P2)
    E = hand.at(np.zeros(4)).flexibility
    det = P1 * P2 + KT * (P2 * R1**2 + P1 * R2**2)
    K11, K22, K12 = P1 + KT * R1**2, P2 + KT * R2**2, KT * R1 * R2
    by_hand = ((A + B) ** 2 * K22 - 2 * (A + B) * B * K12 + B**2 * K11) / det
    np.testing.assert_allclose(E[0, 0], by_hand, rtol=1e-9)
    np.testing.assert_allclose(E[3, 3], (A + B) ** 2 + B**2, rtol=1e-9)
    np.testing.assert_array_equal(E[:3, 3:], 0.0)
    np.testing.assert_allclose(E[2], 0.0, atol=1e-18)


def test_a_tendon_over_two_fingers_is_a_differential(write):
    """K = p + k r² (1, 1; 1, 1): pushed apart, one finger gives way less where the other is pushed too."""
    p, r, k = 2.0, 0.01, 3e4
    tendon = Tendons({"pulley": {"left_joint": r, "right_joint": r}}, k, p)
    hand = lever_hand(write, joint_stiffness=tendon, pad_flexibility=0.0)
    g = lever_pinch(hand, preload=5e-3)
    det = p * (p + 2 * k * r * r)
    E = g.flexibility
    np.testing.assert_allclose(E[2, 2], L * L * (p + k * r * r) / det, rtol=1e-9)
    np.testing.assert_allclose(E[2, 5], -L * L * k * r * r / det, rtol=1e-9)
    s = g.solve()
    # both push with N: each retreats by L² N / (p + 2 k r²), and the tendon carries what the springs don't
    N = 5e-3 * (p + 2 * k * r * r) / L**2
    np.testing.assert_allclose(s.normal_force, N, rtol=1e-9)
    np.testing.assert_allclose(s.tendon_tension, [2 * k * r * L * N / (p + 2 * k * r * r)], rtol=1e-9)
    assert s.actuator_force is None
    assert "pulley" in str(s)


def test_an_unyielding_tendon_ties_joints_like_a_mimic_joint(write):
    """As k grows the error falls as 1 / k, towards q = S z with R S = 0."""
    S = np.array([1.0, -R1 / R2])
    tied = Synergies({"z": {"left_root": 1.0, "left_end": S[1]}, "a": {"right_root": 1.0}, "b": {"right_end": 1.0}},
                     [P1 + P2 * S[1] ** 2, 1.0, 1.0])  # fmt: skip
    limit = chain_hand(write, joint_stiffness=tied).at(np.full(4, 0.3)).flexibility
    k = 1e6
    errors = []
    for stiff in (k, 10 * k, 100 * k):
        E = one_tendon(write, stiff, left_root=P1, left_end=P2).at(np.full(4, 0.3)).flexibility
        errors.append(abs(E - limit).max() / abs(limit).max())
    assert errors[2] < 1e-3
    np.testing.assert_allclose(np.divide(errors[:2], errors[1:]), 10.0, rtol=0.05)


def test_a_synergy_over_a_joint_and_its_mimics_is_the_mimic_joint(write):
    """The URDF's tags, and the same URDF without them."""
    hand = Hand.from_urdf(write(MIMIC), joint_stiffness={"z1": 2.0, "w": 3.0}, tip_radius=0.01)
    free = write(re.sub("<mimic[^>]*/>", "", MIMIC))
    columns = {"grip": {"z1": 1.0, "m2": 0.7, "k3": -1.4}, "swing": {"w": 1.0}}
    loose = Hand.from_urdf(free, joint_stiffness=Synergies(columns, {"grip": 2.0, "swing": 3.0}), tip_radius=0.01)
    q = np.array([0.2, -0.4])
    assert loose.joint_names == tuple(hand.model.names)[1:]
    there, E = full_positions(hand, q), hand.at(q).flexibility
    np.testing.assert_allclose(loose.at(there).flexibility, E, rtol=0, atol=1e-12 * abs(E).max())
    with pytest.raises(Unsupported, match="joint_compliance"):
        _ = loose.joint_stiffness
    assert np.linalg.matrix_rank(loose.joint_compliance) == 2


# ---------------------------------------------------------------- special cases of each other
@pytest.mark.parametrize("kind", ["tendons", "synergies"])
def test_one_for_each_joint_is_the_plain_spring(kind):
    plain = example_hand("five_finger", joint_stiffness=5.0)
    one = np.eye(plain.nv)
    same = {"tendons": Tendons(one, 5.0), "synergies": Synergies(one, np.full(plain.nv, 5.0))}[kind]
    hand = example_hand("five_finger", joint_stiffness=same)
    q = plain.close_on(BALL, squeeze=3e-3)
    s, t = (h.at(q).grasp(BALL, finger_weight=True).solve() for h in (plain, hand))
    np.testing.assert_allclose(t.forces, s.forces, atol=1e-9 * abs(s.forces).max())
    np.testing.assert_allclose(t.joint_deflection, s.joint_deflection, atol=1e-11)
    each = t.tendon_tension if kind == "tendons" else t.actuator_force
    np.testing.assert_allclose(each, t.torques, atol=1e-12)
    assert s.tendon_tension is s.actuator_force is s.effort is None
    np.testing.assert_allclose(hand.joint_stiffness, plain.joint_stiffness, rtol=1e-12)


def test_a_rigid_joint_draws_on_no_tendon(write):
    hand = one_tendon(write, left_root=np.inf, left_end=P2)
    E = hand.at(np.zeros(4)).flexibility
    np.testing.assert_allclose(E[0, 0], B * B / (P2 + KT * R2**2), rtol=1e-9)
    assert hand.joint_stiffness[0, 0] == np.inf
    rigid = chain_hand(write, joint_stiffness=Synergies(np.ones((4, 1)), np.inf))
    np.testing.assert_array_equal(rigid.at(np.zeros(4)).flexibility, 0.0)


# ---------------------------------------------------------------- everything downstream
def test_a_commanded_tendon_also_pulls_against_the_springs_at_the_joints():
    """A return spring keeps its rest angle: τ = Rᵀ t - K_p δq, whether one solve or the followed path asks."""
    R = np.array([[0.012, 0.008, 0, 0], [0, 0, 0.012, 0.008]])
    springs = np.array([0.2, 0.1, 0.2, 0.1])
    hand = example_hand("two_finger", joint_stiffness=Tendons(R, 2e4, springs))
    box = Box(0.04, (0.0, 0.0, 0.07))
    grasp = hand.at(hand.close_on(box)).grasp(box, gravity=(0, 0, 0), grip_force=3.0)
    s = grasp.solve()
    turned = grasp.joint_offset - s.joint_deflection
    np.testing.assert_allclose(R.T @ s.tendon_tension - springs * turned, s.torques, atol=1e-12)
    assert not grasp.check().about("command_not_made")
    for geometry in ("fixed", "followed"):
        path = grasp.follow(geometry=geometry)
        moved = path.steps.q[-1] - path.steps.q[0]
        tension = path.solution.tendon_tension
        np.testing.assert_allclose(R.T @ tension - springs * moved, path.solution.torques, atol=1e-8)


# ---------------------------------------------------------------- refusals
@pytest.mark.parametrize(
    ("make", "kind", "argument", "words"),
    [
        (lambda: Tendons([[0.01, 0.01, 0, 0]], 1e4), InputError, "Tendons.passive", "left_root, left_end, right_root"),
        (
            lambda: Tendons([[0.01, 0.01, 0, 0]], 1e4, [0, 0, 1, 1]),
            InputError, "Tendons.passive", "left_root, left_end against each other",
        ),
        (lambda: Tendons([[0.0] * 4], 1e4, 1), InputError, "Tendons.moment_arms", "tendon 1"),
        (lambda: Tendons({"a": {"thumb": 1.0}}, 1e4, 1), UnknownName, "Tendons.moment_arms['a']", "left_root"),
        (lambda: Tendons(np.eye(4), -1.0), InputError, "Tendons.stiffness", "> 0"),
        (lambda: Tendons(np.eye(4), np.ones((4, 4))), InputError, "Tendons.stiffness", "positive definite"),
        (lambda: Tendons({"a": {"left_end": 1.0}}, {"b": 1.0}), UnknownName, "Tendons.stiffness", "a tendon among"),
        (lambda: Tendons(np.eye(4), 1.0, -1.0), InputError, "Tendons.passive", "≥ 0"),
        (lambda: Synergies([1.0, 2.0], 1.0), InputError, "Synergies.S", "shape"),
        (lambda: Synergies(np.ones((3, 1)), 1.0), InputError, "Synergies.S", "4 numbers a synergy"),
        (lambda: Synergies(np.ones((4, 2)), {"a": 1.0}), UnknownName, "Synergies.stiffness", "synergy 1"),
        (lambda: Synergies(np.ones((4, 1)), 1.0, -1.0), InputError, "Synergies.joint_stiffness", "> 0"),
        (
            lambda: Synergies(np.ones((4, 1)), 1.0, Tendons(np.eye(4), 1.0)),
            InputError, "Synergies.joint_stiffness", "springs of the joints",
        ),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_named(write, make, kind, argument, words):
    with pytest.raises(kind, match=words) as e:
        chain_hand(write, joint_stiffness=make())
    assert type(e.value) is kind
    assert e.value.argument == argument


def test_each_field_of_a_solution_is_there_whichever_is_read_first():
    """Fields are made when they are asked for; a pickle has all of them."""
    hand = example_hand("five_finger", joint_stiffness=Tendons(np.full((1, 10), 0.01), 2e4, 3.0))
    grasp = hand.at(hand.close_on(BALL, squeeze=3e-3)).grasp(BALL, preload=5e-3)
    every = pickle.loads(pickle.dumps(grasp.solve()))
    assert every.effort is not None
    for field in dataclasses.fields(every):
        first, after = getattr(grasp.solve(), field.name), getattr(every, field.name)
        assert type(first) is type(after), field.name
        if isinstance(first, np.ndarray):
            np.testing.assert_array_equal(first, after, err_msg=field.name)
    assert grasp.solve().tendon_tension is not None
