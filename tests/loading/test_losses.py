"""What loses an object, where, and what is said of it; events on the way."""

import re

import numpy as np
import pytest

import handlcp as hl
from tests.loading.hands import G, ball, box_on_a_table, cube


def test_a_soft_hand_drops_a_ball_that_one_solve_calls_held():
    g = ball(stiffness=1.0, squeeze=1e-3)
    assert g.solve("cone").held
    h = g.follow()
    assert not h.reached
    assert h.lost_stage == "load"
    assert 0.0 < h.lost_at < 1.0
    assert h.why.startswith("lost in stage 'load' at")
    assert h.steps.share[-1] <= h.lost_at
    assert [e.kind for e in h.events if e.kind == "lost"] == ["lost"]


def test_a_larger_load_is_lost_earlier():
    at = [ball().follow((0, 0, pull, 0, 0, 0), steps=20) for pull in (20.0, 40.0)]
    assert [h.reached for h in at] == [False, False]
    assert [h.stages for h in at] == [("squeeze", "weight", "load")] * 2  # the weight comes first, and all of it
    assert 20.0 * at[0].lost_at == pytest.approx(40.0 * at[1].lost_at, rel=0.003)


def test_torque_limits_are_events_at_the_share_where_they_are_passed():
    g = ball(limits=0.14)
    h = g.follow(order="squeeze")
    over = [e for e in h.events if e.kind == "over limit"]
    torque = abs(h.steps.torques)
    first = int(np.argmax((torque > 0.14).any(axis=1)))
    assert over
    assert over[0].share == pytest.approx(h.steps.share[first])
    assert torque[first].max() == pytest.approx(0.14, rel=0.01)


def test_a_saturated_joint_yields_and_never_exceeds_its_limit():
    h = ball(limits=0.12, effects=[hl.TorqueSaturation()]).follow(steps=10)
    assert h.reached
    assert abs(h.steps.torques).max() <= 0.12 * (1 + 1e-9)
    assert any(e.kind == "yields" for e in h.events)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ({"order": "later"}, "order[0]"),
        ({"load": (1.0, 2.0)}, "load"),
        ({"geometry": "moving"}, "geometry"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"order": [hl.Stage("a", joint_offset=[1.0])]}, "order[0].joint_offset"),
    ],
)
def test_bad_arguments_are_named(words, named):
    with pytest.raises(hl.InputError, match=f"^{re.escape(named)}:"):
        cube().follow(**words)


def test_a_grasp_without_a_hand_is_followed_in_its_first_posture_alone():
    contacts = [hl.Contact((x, 0, 0), (-np.sign(x), 0, 0)) for x in (-0.03, 0.03)]
    g = hl.Grasp(contacts, flexibility=1e-3, preload=2e-3)
    with pytest.raises(hl.InputError, match=r"^geometry:"):
        g.follow(geometry="followed")
    h = g.follow((0, 0, -0.5, 0, 0, 0))
    assert h.reached
    assert h.state is None


def test_known_forces_cannot_be_followed():
    g = cube(effects=[hl.PrescribedForce(0, (0, 0, 2.0))])
    with pytest.raises(hl.Unsupported, match="PrescribedForce"):
        g.follow()


def test_stages_of_ones_own_reverse_and_repeat():
    order = [
        hl.Stage("half", squeeze=0.5),
        hl.Stage("whole", squeeze=1.0, weight=1.0),
        hl.Stage("pull", load=(0.2, 0, 0, 0, 0, 0)),
        hl.Stage("release", squeeze=0.0),
    ]
    h = cube().follow(order=order, steps=8)
    assert h.stages == ("half", "whole", "pull", "release")
    assert h.lost_stage == "release"
    half, whole, pull = [int(np.flatnonzero(h.steps.stage == k)[-1]) for k in range(3)]
    np.testing.assert_allclose(h.steps.command[half] * 2, h.steps.command[whole])
    assert h.steps.load[pull][0] == 0.2


def test_a_ball_that_friction_does_not_hold_between_the_fingers_is_squeezed_out():
    """Contacts lie 27 degrees above its middle: a friction angle of 17 degrees cannot keep it."""
    h = ball(friction=hl.Coulomb(0.3)).follow(steps=10)
    assert not h.reached
    assert h.lost_stage == "squeeze"
    assert np.degrees(np.arctan(0.3)) < 27.0


@pytest.mark.parametrize("faces", ["cone", 16])
def test_a_ball_off_the_middle_stays_between_the_fingers_whatever_the_steps(faces):
    """Squeezed, it may slip out or stay: its contacts lie 28 degrees above its middle, friction holds up to 38."""
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    sphere = hl.Sphere(0.034, (0.004, 0, 0.07), mass=0.02)
    g = hand.at(hand.close_on(sphere)).grasp(sphere, hl.Coulomb(0.8), squeeze=0.002)
    ends_ = [g.follow(faces=faces, steps=steps) for steps in (8, 80)]
    assert all(h.reached for h in ends_)
    for h in ends_:
        np.testing.assert_allclose(h.steps.forces_world[-1], g.solve("cone").forces_world, rtol=0.02, atol=0.01)


def test_a_box_that_stands_on_something_rigid_is_held():
    h = box_on_a_table().follow(steps=10)
    assert h.reached
    np.testing.assert_allclose(h.steps.forces_world[-1].sum(axis=0), (0, 0, -0.5 * G), atol=1e-6)
    assert h.steps.forces[-1, 2:, 2].min() > 0.5  # it stands on its four corners


@pytest.mark.long
def test_a_squeeze_that_drives_the_object_away_from_its_first_step_on_is_lost():
    """The state that a path begins with has no stiffness that was measured: what grows is that of the first step."""
    hand = hl.finger_hand(
        link_lengths=(0.05285411551594734, 0.04039950801059604), palm_radius=0.03579713315237314,
        joint_stiffness=3.7532172024869235, torque_limits=1.5,
    )  # fmt: skip
    placement = (0.02171753609086785, -0.03762991905907337, 0.05869252456306288)
    q = [-0.437, 1.840196257165629, 1.3034984620700252, 0.057, -0.437, 1.841396428528706]
    grasp = hand.at(q).grasp(hl.Sphere(0.03, placement=placement, mass=0.1), friction=0.7, grip_force=6.0)
    assert "drives it away" in grasp.check().text
