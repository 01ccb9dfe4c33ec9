"""Numbers of a hand by the names of `vary`: the same grasp with others, derivatives by them, and chances."""

from types import SimpleNamespace

import numpy as np
import pytest

import handlcp as hl
from tests.support.design import varied_by

NAMES = ("joint_stiffness", "finger_1_distal.stiffness", "finger_1_tip.pad", "finger_1_distal.length")
LENGTH, RADIUS = "finger_1_distal.length", "finger_2_tip.radius"


@pytest.fixture(scope="module")
def grasp():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.3)
    return hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)


# ---------------------------------------------------------------- the same grasp
def test_springs_and_pads_leave_the_posture_as_it_is(grasp):
    other = hl.vary_grasp(grasp, {"joint_stiffness": 3.0, "finger_1_tip.pad": 2e-4})
    assert np.array_equal(other.state.q, grasp.state.q)
    hand = grasp.state.hand.replace(joint_stiffness=3.0).vary({"finger_1_tip.pad": 2e-4})
    made = hand.at(grasp.state.q).grasp(grasp.target, friction=0.8, squeeze=0.005)
    assert np.array_equal(other.solve().forces, made.solve().forces)


@pytest.mark.parametrize(
    "changes", [{LENGTH: 0.044}, {RADIUS: 0.011}, {"finger_3_proximal.position": (-0.02, -0.04, 0)}]
)
def test_another_shape_moves_joints_and_object_until_all_fingertips_touch(grasp, changes):
    other = hl.vary_grasp(grasp, changes)
    assert abs(other.spec.mechanism.stand_off).max() < 1e-9, "[m]"
    assert other.fingertips == grasp.fingertips
    assert np.linalg.norm(other.target.frame[1] - grasp.target.frame[1]) < 0.02
    assert other.solve().held


def test_fingertips_that_cannot_touch_any_more_are_told(grasp):
    with pytest.raises(hl.NoGraspFound, match="do not come to touch"):
        hl.vary_grasp(grasp, {LENGTH: 0.4})
    with pytest.raises(hl.UnknownName, match=r"did you mean 'finger_1_distal\.length'"):
        hl.vary_grasp(grasp, {"finger_1_distl.length": 0.04})


# ---------------------------------------------------------------- derivatives
def test_derivatives_by_springs_and_pads_are_those_of_the_answer_itself(grasp):
    """A squeeze is a command that neither of them changes."""
    found, exact = hl.slopes(grasp, NAMES[1:3]), grasp.solve().sensitivity()
    np.testing.assert_allclose(found.normal_force[:, 0], exact.forces_by_stiffness[:, 2, 1], rtol=1e-5)
    np.testing.assert_allclose(found.torques[:, 0], exact.torques_by_stiffness[:, 1], rtol=1e-5)
    np.testing.assert_allclose(found.displacement[:, 0], exact.displacement_by_stiffness[:, 1], rtol=1e-4, atol=1e-9)
    np.testing.assert_allclose(found.normal_force[:, 1], exact.forces_by_pads[:, 2, 0], rtol=1e-5)
    assert found.kinks == ()


def test_a_length_and_a_radius_are_smooth_and_agree_with_larger_steps(grasp):
    found = hl.slopes(grasp, (LENGTH, RADIUS))
    assert found.kinks == ()
    for k, name in enumerate(found.names):
        step = 0.005 * found.values[k]
        ends = [hl.vary_grasp(grasp, {name: found.values[k] + h}).solve() for h in (step, -step)]
        slope = (ends[0].torques - ends[1].torques) / (2.0 * step)
        np.testing.assert_allclose(found.torques[:, k], slope, rtol=0.01, atol=1e-3 * abs(slope).max())
    assert found.to_dict()["values"] == [pytest.approx(0.04), 0.008]
    assert "finger_1_distal.length" in str(found)


def test_a_derivative_with_two_sides_is_called_a_kink(grasp, monkeypatch):
    """Of answers that a stub gives: forces |v - v0|, and the same smooth."""

    def stub(shape):
        def answer(changes):
            (value,) = changes.values()
            x = shape(value - 6.0)
            return SimpleNamespace(forces_world=np.full((3, 3), 1.0 + x), normal_force=np.full(3, 1.0 + x),
                                   torques=np.full(6, 1.0 + x), object_displacement=np.full(6, 1.0 + x))  # fmt: skip

        return lambda _, changes: SimpleNamespace(solve=lambda faces: answer(changes))

    for shape, kinks in ((abs, NAMES[:1]), (lambda x: 3.0 * x + x * x, ())):
        varied_by(monkeypatch, stub(shape))
        assert hl.slopes(grasp, NAMES[:1]).kinks == kinks


def test_round_fingertips_of_the_file_have_a_radius_too():
    """As those of `finger_hand`, and of no radius that was passed."""
    hand = hl.finger_hand(3, joint_stiffness=6.0)
    cube = hl.Box(0.05, placement=(0, 0, 0.085), mass=0.2)
    grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.003)
    assert hl.slopes(grasp, [RADIUS, "tip_radius"]).values.tolist() == [0.008, 0.008]
    hl.reliability(grasp, {RADIUS: 1e-5}, samples=64)


@pytest.mark.parametrize(
    ("names", "fact"),
    [
        ((), "names: expected .*at least one"), ((LENGTH, LENGTH), "names: expected .*each once"),
        (3, "names: expected"),
        (("finger_9_distal.length",), "names: expected a number of the hand .*did you mean 'finger_3_distal.length'"),
    ],
)  # fmt: skip
def test_names_that_are_no_numbers_are_told(grasp, names, fact):
    with pytest.raises(hl.InputError, match=fact):
        hl.slopes(grasp, names)


# ---------------------------------------------------------------- chances
def test_springs_by_their_name_for_vary_are_those_of_reliability_sample_by_sample(grasp):
    one = hl.reliability(grasp, {"friction": 0.2, "stiffness": 0.2}, 64)
    other = hl.reliability(grasp, {"friction": 0.2, "joint_stiffness": 0.2}, 64)
    assert other.counts == one.counts
    np.testing.assert_allclose(other.outcomes.margin, one.outcomes.margin, rtol=1e-9)
    assert other.influences[1].name == "joint_stiffness"


def test_a_length_varies_and_a_hand_that_no_longer_reaches_is_undecided(grasp):
    from scipy import stats

    found = hl.reliability(grasp, {LENGTH: stats.uniform(0.035, 0.1)}, 64)
    assert 0 < found.counts["UNDECIDED"] < 64
    assert any("do not come to touch" in why for why in found.why_not.values())


def test_what_moves_contacts_is_not_said_beside_numbers_that_do(grasp):
    with pytest.raises(hl.InputError, match="no positions beside numbers of the hand"):
        hl.reliability(grasp, {LENGTH: 0.01, "positions": 1e-3}, 64)
    with pytest.raises(hl.UnknownName, match=r"a number of the hand, .*did you mean 'finger_1_distal\.length'"):
        hl.reliability(grasp, {"finger_1_distl.length": 0.01}, 64)
