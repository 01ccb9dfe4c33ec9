"""A hand that closes: until it touches, and with what its tendons and motors pull."""

import re

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, NotReached, UnknownName
from handlcp.geometry import Box, Cylinder, Ellipsoid, Mesh, Sphere
from handlcp.hand import example_hand
from tests.support.grasp import arrays
from tests.support.hand import gaps
from tests.support.refusals import refused
from tests.support.texts import says

from .test_objects import box_file

L1, L2 = 0.06, 0.045
MIDDLE = np.array([0.036, 0.042])  # of the object, with a radius of 30 mm

LINK = """<link name="{name}"><inertial><mass value="0.05"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0"
iyz="0"/></inertial><collision><origin xyz="{half} 0 0" rpy="0 1.5707963267948966 0"/><geometry>
<cylinder radius="0.008" length="{length}"/></geometry></collision></link>"""
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{x} 0 0"/>
<axis xyz="0 0 1"/><limit lower="-1.5" upper="2" effort="2" velocity="1"/></joint>"""


def finger(**stiffness):
    links = [LINK.format(name=name, length=length, half=length / 2) for name, length in
             (("proximal", L1), ("distal", L2))]  # fmt: skip
    joints = [
        JOINT.format(name="root", kind="revolute", parent="base", child="proximal", x=0.0),
        JOINT.format(name="end", kind="revolute", parent="proximal", child="distal", x=L1),
        JOINT.format(name="fixed", kind="fixed", parent="distal", child="tip", x=L2),
    ]
    text = f'<robot name="finger"><link name="base"/>{"".join(links)}<link name="tip"/>{"".join(joints)}</robot>'
    return hl.Hand.from_urdf(text, ["tip"], tip_radius=0.002, **stiffness)


def closed(arms, tension, springs=0.02):
    """Around a cylinder that is kept in place: the path, the state at the end of the squeeze, the posture before."""
    tendon = hl.Tendons({"flexor": dict(zip(("root", "end"), arms, strict=True))}, 1e4, springs)
    hand = finger(joint_stiffness=tendon)
    obj = hl.Cylinder(0.03, 0.1, placement=(*MIDDLE, 0.0))
    pull = dict(zip(("root", "end"), np.multiply(arms, tension), strict=True))
    grasp = hand.at([-0.8, 0.0]).grasp(
        obj, friction=0.0, links=["proximal", "distal"], closing_torque=pull, hold_object=True, gravity=(0, 0, 0)
    )  # fmt: skip
    path = grasp.follow(order="squeeze")
    return path, path.steps.states[closed_at(path)], grasp.state.q


def closed_at(path):
    """The last step of the first stage."""
    return np.flatnonzero(path.steps.stage == 0)[-1]


def by_statics(q, torque):
    """Birglen and Gosselin: contact forces of both phalanges, f = J⁻ᵀ τ, with the contacts at k1, k2 along them."""
    a, b = q[0], q[0] + q[1]
    end = L1 * np.array([np.cos(a), np.sin(a)])
    k1, k2 = MIDDLE @ [np.cos(a), np.sin(a)], (MIDDLE - end) @ [np.cos(b), np.sin(b)]
    f2 = torque[1] / k2
    return (torque[0] - f2 * (k2 + L1 * np.cos(q[1]))) / k1, f2, k1, k2


@pytest.mark.parametrize("tension", [5.0, 20.0])
def test_both_phalanges_press_as_the_statics_of_underactuated_fingers_says(tension):
    arms = (0.016, 0.005)
    path, squeezed, _ = closed(arms, tension)
    forces, q = squeezed.read.forces[:, 2], squeezed.where.q
    assert path.steps.names == ("proximal", "distal")
    *exact, _, _ = by_statics(q, squeezed.read.torque)
    np.testing.assert_allclose(forces, exact, rtol=1e-4)
    *pulled, _, _ = by_statics(q, np.multiply(arms, tension))
    np.testing.assert_allclose(forces, pulled, rtol=1e-3)


@pytest.mark.parametrize("springs", [0.02, 0.2])
def test_a_tendon_winds_until_it_pulls_with_its_tension_however_far_the_finger_swings(springs):
    """Arms that make the proximal phalanx leave the object: the finger swings round it, against its springs."""
    arms, tension = (0.012, 0.008), 10.0
    path, _, q = closed(arms, tension, springs)
    swung = path.steps.q[closed_at(path)] - q
    assert abs(swung).max() > 0.1
    at_tendon = path.steps.torques[closed_at(path)] + springs * swung
    np.testing.assert_allclose(at_tendon, np.multiply(arms, tension), rtol=2e-3)


@pytest.mark.parametrize(("arms", "stays"), [((0.016, 0.005), True), ((0.012, 0.008), False)])
def test_a_proximal_phalanx_stays_if_the_arms_ratio_is_above_that_of_the_levers(arms, stays):
    _, squeezed, q = closed(arms, 10.0)
    *_, k2 = by_statics(q, np.ones(2))
    assert bool(arms[0] / arms[1] > 1.0 + L1 * np.cos(q[1]) / k2) is stays
    assert bool(squeezed.read.forces[0, 2] > 0.0) is stays


def test_an_object_that_is_kept_in_place_does_not_move_until_it_is_let_go():
    path, squeezed, _ = closed((0.016, 0.005), 10.0)
    assert "let go" in path.stages
    moved = path.steps.geometry.displacement(squeezed.where.pose)
    assert np.linalg.norm(moved[:3]) < 1e-6
    assert not path.reached  # without friction one finger pushes it away


def test_each_finger_closes_until_one_of_its_motors_pulls_with_the_closing_torque():
    """Also where the hand begins open: then friction has taken another way, with steps that are finite."""
    hand = example_hand("two_finger")
    ball, tips, ends = hl.Sphere(0.02, (0.0, 0.0, 0.09)), list(hand.fingertips), []
    for q in (hand.close_on(ball, wrap=True), hand.neutral):
        grasp = hand.at(q).grasp(ball, links=tips, closing_torque=0.1, hold_object=True, gravity=(0, 0, 0))
        path = grasp.follow(order="squeeze")
        ends.append(path.steps.torques[closed_at(path)].reshape(2, 2))
    np.testing.assert_allclose(abs(ends[0]).max(axis=1), 0.1, rtol=1e-3)
    np.testing.assert_allclose(*ends, rtol=0.02)


def test_a_strong_finger_stops_where_it_would_drive_a_weak_one_beyond_its_torque():
    """What one finger presses the other has to bear, and the verdict names the one that could do more."""
    hand = example_hand("two_finger", joint_stiffness=6.0)
    ball = hl.Sphere(0.02, (0.0, 0.0, 0.09), mass=0.01)
    torque = {name: 0.05 if "finger_1" in name else 0.3 for name in hand.joint_names}
    grasp = hand.at(hand.close_on(ball)).grasp(ball, closing_torque=torque, gravity=(0, 0, 0))
    path = grasp.follow(order="squeeze")
    weak, strong = np.abs(path.steps.torques[-1]).reshape(2, 2)
    assert 0.95 * 0.05 < weak.max() < 1.12 * 0.05
    assert strong.max() < 0.5 * 0.3
    (warned,) = grasp.check().about("closing_torque")
    short, beyond = warned.sentence.split("; ")
    assert "finger_2" in short
    assert "finger_1" not in short
    assert "drive finger_1" in beyond


def test_fingers_that_are_not_asked_to_pull_stay_where_they_are(three):
    ball = hl.Sphere(0.03, (0.0, 0.0, 0.09), mass=0.1)
    q = three.close_on(ball)
    alone = {name: 0.2 for name in three.joint_names if "finger_3" not in name}
    grasp = three.at(q).grasp(ball, closing_torque=alone, hold_object=True)
    path = grasp.follow(order="squeeze")
    torques = abs(path.steps.torques[closed_at(path)]).reshape(3, 2)
    np.testing.assert_allclose(torques[:2].max(axis=1), 0.2, rtol=2e-3)
    assert not grasp.joint_offset[4:].any()


def test_an_object_that_is_lost_when_it_is_let_go_is_lost_in_that_stage(three):
    ball = hl.Sphere(0.035, (0.0, 0.0, 0.04), mass=0.3)
    one = dict.fromkeys(("finger_1_proximal", "finger_1_distal"), 0.3)  # it alone presses, and nothing presses back
    path = three.at(three.neutral).grasp(ball, links="all", closing_torque=one, hold_object=True).follow()
    assert (path.lost_stage, path.lost_at) == ("let go", 0.0)
    assert "kept in place" not in path.why


# ---------------------------------------------------------------- closing the hand: touching to tolerance, inside the
@pytest.mark.parametrize("name", ["two_finger", "three_finger", "five_finger"])
@pytest.mark.parametrize("shape", ["sphere", "cylinder", "ellipsoid", "box", "mesh"])
def test_upright_hands_touch(name, shape, tmp_path):
    """Every upright hand closes on every kind of object to the tolerance, inside its joint ranges."""
    at = (0.002, -0.001, 0.085)
    obj = {
        "sphere": lambda: Sphere(0.03, at),
        "cylinder": lambda: Cylinder(0.025, 0.08, at),
        "ellipsoid": lambda: Ellipsoid((0.025, 0.02, 0.03), at),
        "box": lambda: Box((0.03, 0.035, 0.06), at),
        "mesh": lambda: Mesh(box_file(tmp_path, np.array([0.03, 0.035, 0.06])), 1.0, at),
    }[shape]()
    hand = example_hand(name)
    q = hand.close_on(obj)
    assert abs(gaps(hand, q, obj)).max() <= 1e-6
    assert ((hand.lower <= q) & (q <= hand.upper)).all()
    np.testing.assert_array_equal(hand.close_on(obj), q)  # deterministic, bit by bit
    assert arrays(hand.at(q).grasp(obj)).n == len(hand.fingertips)


def test_the_ring_closes_on_a_disc():
    """Six fingers in a plane, from straight (a dead point: no joint moves the tip inward) and from bent."""
    hand = example_hand("planar_ring")
    disc = Cylinder(0.03, 0.02)
    for q0 in (hand.neutral, np.tile([0.5, -0.9], 6)):
        q = hand.close_on(disc, q0)
        assert abs(gaps(hand, q, disc)).max() <= 1e-6
        assert abs(hand.at(q).tip_positions[:, 2]).max() < 1e-12


def test_allegro_and_psyonic_close():
    """Four joints a finger with a posture outside the ranges to start from; and coupled fingers on a bar."""
    allegro = example_hand("allegro")
    ball = Sphere(0.035, (0.06, 0.0, 0.07))
    q = allegro.close_on(ball, np.zeros(16), fingers=["link_3.0_tip", "link_7.0_tip", "link_11.0_tip"])
    assert abs(gaps(allegro, q, ball)[:3]).max() <= 1e-6
    assert q[allegro.joint_names.index("joint_12.0")] == pytest.approx(0.263)  # zero is outside its range
    psyonic = example_hand("psyonic")
    tips = psyonic.at(psyonic.neutral + 0.4 * (psyonic.upper > 1)).tip_positions
    bar = Sphere(0.01, tips[1])
    q = psyonic.close_on(bar, fingers=["Left_index_anchor"])
    assert abs(gaps(psyonic, q, bar)[1]) <= 1e-6


def test_squeeze_is_overlap(five):
    """Squeezing by 3 mm leaves each tip 3 mm inside."""
    ball = Sphere(0.03, (0, 0, 0.09))
    np.testing.assert_allclose(gaps(five, five.close_on(ball, squeeze=3e-3), ball), -3e-3, atol=1e-6)


def test_other_fingers_stay(five):
    """Only the named fingers move."""
    q0 = np.full(10, 0.1)
    q = five.close_on(Sphere(0.03, (0, 0, 0.09)), q0, fingers=["finger_2_tip"])
    moved = {name for name, a, b in zip(five.joint_names, q, q0, strict=True) if a != b}
    assert moved == {"finger_2_proximal", "finger_2_distal"}


def test_unreachable_fingers_are_named_with_what_is_left(five):
    """An object on one side: the near fingers touch, the far ones are reported with gaps and posture."""
    ball = Sphere(0.01, (0.045, 0.0, 0.1))
    with pytest.raises(NotReached) as caught:
        five.close_on(ball)
    error = caught.value
    assert "finger_1_tip" not in error.gaps
    assert {"finger_3_tip", "finger_4_tip"} <= set(error.gaps)
    left = dict(zip(five.fingertips, gaps(five, error.q, ball), strict=True))
    assert error.gaps == pytest.approx({name: left[name] for name in error.gaps}, abs=1e-12)
    assert ((five.lower <= error.q) & (error.q <= five.upper)).all()
    with pytest.raises(NotReached):
        five.close_on(Sphere(0.01, (1.0, 0.0, 0.0)))


def test_two_points_on_one_finger_are_said_to_share_its_joints():
    """The link in the middle has no joint of its own: with it the whole finger would move."""
    tips = ["finger_1_tip", "finger_1_proximal_link", "finger_2_tip"]
    hand = example_hand("three_finger", joint_stiffness=6.0, fingertips=tips)
    with pytest.raises(NotReached) as caught:
        hand.close_on(Sphere(0.02, (0.0, 0.0, 0.09)))
    assert "finger_1_proximal_link" in caught.value.gaps
    without = re.sub(r", got .*", "", str(caught.value))
    says(without, "no joint moves finger_1_proximal_link without finger_1_tip")
    with pytest.raises(NotReached) as alone:  # fingers with joints of their own are out of reach, and nothing else
        hand.close_on(Sphere(0.01, (1.0, 0.0, 0.0)), fingers=["finger_2_tip"])
    assert "without" not in str(alone.value)


@pytest.mark.parametrize(
    ("arguments", "argument", "kind"),
    [
        ({"obj": "ball"}, "obj", InputError),
        ({"q0": [0.0]}, "q0", InputError),
        ({"squeeze": -1.0}, "squeeze", InputError),
        ({"tolerance": 0.0}, "tolerance", InputError),
        ({"fingers": ["thumb"]}, "fingers", UnknownName),
    ],
)
def test_bad_arguments_are_named(five, arguments, argument, kind):
    """One broken argument a time."""
    obj = arguments.pop("obj", Sphere(0.03, (0, 0, 0.09)))
    refused(argument, five.close_on, obj, error=kind, **arguments)
