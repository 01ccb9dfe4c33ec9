"""Dry friction at the joints of a loading that is followed: closed forms, energy, and MuJoCo."""

from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, UnknownName
from handlcp.hand import Hand, example_hand

from .levers import PAD, C, K, L, lever_hand, lever_pinch

RUBS = 0.05  # N·m
SHUT, BACK = 0.06, 0.03  # rad, commanded


RUBBING = {
    "of the joint": {"joint_friction": RUBS}, "of the drive": {"motors": hl.Motor(20.0, friction=RUBS)},
    "of both": {"joint_friction": 0.4 * RUBS, "motors": hl.Motor(20.0, friction=0.6 * RUBS)},
}  # fmt: skip


def pinch(write, whose="of the joint", **more):
    return lever_pinch(lever_hand(write, **RUBBING[whose]), (0.0, 0.0, 0.0), **more)


@pytest.mark.parametrize("whose", RUBBING)
def test_a_joint_that_closes_presses_less_by_its_friction_and_one_that_opens_more(write, whose):
    """N = (θ ∓ τ_f / K) L / C on both sides of a hysteresis loop, and between them as it was."""
    stages = [hl.Stage("close", joint_offset=[SHUT] * 2), hl.Stage("open", joint_offset=[BACK] * 2)]
    path = pinch(write, whose).follow(order=stages, steps=7, geometry="fixed")
    for k, stage in enumerate(stages):
        here = np.flatnonzero(path.steps.stage == k)[1:]
        angle, force = path.steps.command[here, 0], path.steps.forces[here, 0, 2]
        closing = np.maximum(angle - RUBS / K, 0.0) * L / C
        most = (SHUT - RUBS / K) * L / C
        expected = closing if stage.name == "close" else np.minimum((angle + RUBS / K) * L / C, most)
        np.testing.assert_allclose(force, expected, rtol=1e-7, atol=1e-7 * most)


@pytest.mark.parametrize(("steps", "whose"), [(3, "of the joint"), (40, "of the drive")])
def test_the_area_of_a_hysteresis_loop_is_the_work_that_friction_takes(write, steps, whose):
    """Around it each joint goes PAD / C (Δθ - 2 τ_f / K) there and back, against τ_f; however long steps are."""
    angles = [SHUT, BACK, SHUT]
    stages = [hl.Stage(f"turn {k}", joint_offset=[angle] * 2) for k, angle in enumerate(angles)]
    path = pinch(write, whose).follow(order=stages, steps=steps, geometry="fixed")
    ends = [int(np.flatnonzero(path.steps.stage == k)[-1]) for k in range(3)]
    around = slice(ends[0], ends[2] + 1)
    taken = path.steps.dissipated[ends[2]] - path.steps.dissipated[ends[0]]
    goes = PAD / C * (SHUT - BACK - 2 * RUBS / K)
    np.testing.assert_allclose(taken, 2 * 2 * RUBS * goes, rtol=1e-7)  # two joints, there and back
    angle, pulled = path.steps.command[around, 0], path.steps.pulled[around, 0]
    area = 2 * float(np.sum(0.5 * (pulled[1:] + pulled[:-1]) * np.diff(angle)))
    if steps > 3:  # the corners of the loop are cut by long steps
        np.testing.assert_allclose(area, taken, rtol=0.02)
    held = path.steps
    np.testing.assert_allclose(held.forces[ends[2]], held.forces[ends[0]], rtol=1e-7, atol=1e-9)  # the loop closes


def test_a_joint_pushed_back_stands_still_until_twice_its_friction_is_overcome(write):
    """The finger behind is rigid but for its pad while the one before follows as it closed: 1 / (1 / C + 1 / PAD). Once
    it has turned from -τ_f to τ_f, both give way: C / 2.
    """
    grasp = pinch(write, joint_offset=[SHUT] * 2)
    path = grasp.follow([8.0, 0.0, 0.0, 0.0, 0.0, 0.0], steps=40, geometry="fixed")
    load, moved = path.steps.load[:, 0], path.steps.displacement[:, 0]
    first, stiff = 2 * RUBS / L * (1 + PAD / C), 1 / (1 / C + 1 / PAD)
    assert 1.0 < first < 4.0
    expected = np.where(load < first, stiff * load, stiff * first + (load - first) * C / 2)
    np.testing.assert_allclose(moved, expected, atol=1e-7 * expected.max())


def test_a_finger_pushed_back_is_held_by_its_motor_and_the_friction_of_its_drive_together(write):
    """Once the joint has turned back: τ = τ_m + τ_f. It gives out where that is what both hold, and not before."""
    motor = hl.Motor(1.1 * SHUT * L / C * L, friction=RUBS)
    grasp = lever_pinch(lever_hand(write, motors=motor), (0.0, 0.0, 0.0), joint_offset=[SHUT] * 2)
    found = grasp.load_limit([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], geometry="fixed")
    assert [(c.kind, c.who) for c in found.binds] == [("torque", "right_joint")]
    steps = grasp.follow(found.load, steps=40, geometry="fixed").steps
    np.testing.assert_allclose(steps.torques[-1, 1], motor.for_good + RUBS, rtol=1e-6)
    np.testing.assert_allclose(steps.pulled[-1, 1], motor.for_good, rtol=1e-6)


def test_friction_leaves_a_certified_state_and_the_energy_in_balance():
    ball = hl.Sphere(0.03, (0.0, 0.0, 0.09), mass=0.1)
    hand = example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=1e-4, joint_friction=0.05)
    grasp = hand.at(hand.close_on(ball)).grasp(ball, squeeze=0.003)
    path = grasp.follow()
    assert path.reached
    assert path.solution.held
    assert grasp.check().word == "HELD"
    taken = path.steps.dissipated[-1]
    assert taken > 0.01 * path.steps.work[-1]
    np.testing.assert_allclose(path.steps.work[-1], path.steps.stored[-1] + taken, rtol=1e-4)
    without = hand.replace(joint_friction=None).at(grasp.state.q).grasp(ball, squeeze=0.003).follow()
    assert 0.5 * without.steps.forces[-1, 0, 2] < path.steps.forces[-1, 0, 2] < without.steps.forces[-1, 0, 2]


def test_a_motor_overcomes_the_friction_of_its_joint_and_pulls_with_the_closing_torque():
    """What dry friction takes of that is not left for the contacts; one solve has the forces of the closed hand."""
    ball = hl.Sphere(0.03, (0.0, 0.0, 0.09))
    hand = example_hand("two_finger", joint_friction={"finger_1_proximal": 0.02, "finger_2_proximal": 0.02})
    grasp = hand.at(hand.close_on(ball)).grasp(ball, closing_torque=0.2, hold_object=True, gravity=(0, 0, 0))
    path = grasp.follow(order="squeeze")
    end = np.flatnonzero(path.steps.stage == 0)[-1]
    pulled, torque = np.abs(path.steps.pulled[end]).reshape(2, 2), np.abs(path.steps.torques[end]).reshape(2, 2)
    np.testing.assert_allclose(pulled.max(axis=1), 0.2, rtol=1e-3)
    assert (abs(pulled - torque) <= 0.02 * (1 + 1e-6)).all()
    np.testing.assert_allclose(grasp.solve().torques, path.steps.torques[end], rtol=0.1)


@pytest.mark.parametrize(("of_joint", "of_motor"), [(0.02, 0.04), (0.05, 0.1)])
def test_mujoco_has_the_same_forces_torques_and_motion(of_joint, of_motor):
    """Its friction at joints is regularised: a joint that stands still creeps, too little to matter here. With more
    friction all joints stick under the load and one tip slips.
    """
    pytest.importorskip("mujoco")
    from handlcp.simulator import compare

    box, motors = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2), hl.Motor(1.0, friction=of_motor)
    settings = {"joint_stiffness": 6.0, "pad_flexibility": 1e-4, "joint_friction": of_joint, "motors": motors}
    hand = example_hand("three_finger", **settings)
    found = compare(hand.at(hand.close_on(box)).grasp(box, friction=0.8, squeeze=0.004))
    assert found.both_hold
    assert found.force_error < 0.01
    assert found.torque_error < 0.01
    assert found.motion_error < 0.03


def test_files_state_it():
    """Where it is asked for; a URDF's <dynamics friction> is read as an MJCF's frictionloss is."""
    text = (Path(__file__).parents[2] / "urdf" / "two_finger.urdf").read_text(encoding="utf-8")
    rubbing = text.replace("</joint>", '<dynamics friction="0.03"/></joint>', 1)
    assert Hand.from_urdf(rubbing, joint_stiffness=1.0).joint_friction.max() == 0.0
    hand = Hand.from_urdf(rubbing, joint_stiffness=1.0, joint_friction="file")
    assert sorted(hand.joint_friction.tolist())[-1] == 0.03
    assert np.count_nonzero(hand.joint_friction) <= 1


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        (-0.1, InputError, "joint_friction: expected a finite number ≥ 0"),
        ("much", InputError, 'joint_friction: expected a number, a mapping by joint name, or "file"'),
        ({"thumb": 0.1}, UnknownName, "thumb"),
        ({"finger_1_distal": -1.0}, InputError, r"joint_friction\['finger_1_distal'\]"),
    ],
)
def test_friction_that_cannot_be_is_refused(given, error, words):
    with pytest.raises(error, match=words):
        example_hand("two_finger", joint_friction=given)
