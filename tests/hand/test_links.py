"""Contacts on any link: where they are, what is said of them by link, and what is refused."""

import numpy as np
import pinocchio as pin
import pytest

from handlcp.errors import InputError, NotReached
from handlcp.geometry import Box, Cylinder, Sphere
from handlcp.hand import Hand, example_hand
from handlcp.viz.picture.body import hand_bodies, undrawn_tip_shapes
from tests.support.texts import says

# A flat palm, its upper face at z = 0, and a bar beside it that a hinge tilts over it
FLAT = """
<robot name="flat">
  <link name="palm"><collision><origin xyz="0 0 -0.01"/><geometry><box size="0.1 0.1 0.02"/></geometry></collision>
  </link>
  <link name="bar"><collision><origin xyz="0 0 0.04"/><geometry><box size="0.02 0.02 0.08"/></geometry></collision>
  </link>
  <link name="bare"/>
  <joint name="hinge" type="revolute"><parent link="palm"/><child link="bar"/><axis xyz="0 -1 0"/>
    <origin xyz="0.06 0 0"/><limit lower="-0.5" upper="1.5" effort="2" velocity="1"/></joint>
  <joint name="end" type="fixed"><parent link="bar"/><child link="bare"/><origin xyz="0 0 0.08"/></joint>
</robot>
"""
ALONG_Y = pin.SE3(pin.rpy.rpyToMatrix(np.pi / 2, 0.0, 0.0), np.array([0, 0, 0.02]))
CUBE, ROD, BALL = Box(0.04, (0, 0, 0.02)), Cylinder(0.02, 0.06, ALONG_Y), Sphere(0.02, (0, 0, 0.02))
BESIDE = Box(0.04, (0.03, 0, 0.02), mass=0.2)  # on the palm, against the bar


def flat(text=FLAT, **given):
    return Hand.from_urdf(text, **({"fingertips": ["bare"], "joint_stiffness": 5.0, "tip_radius": 0.012} | given))


def on_palm(obj, hand=None, **arguments):
    return (hand or flat()).at([0.0]).grasp(obj, **({"links": "all"} | arguments))


def names(grasp):
    return [c.name for c in grasp.contacts]


def ball_in_five_fingers(hand=None, rotation=None, **arguments):
    hand = hand or example_hand("five_finger", joint_stiffness=6.0)
    place = pin.SE3(np.eye(3) if rotation is None else rotation, np.array([0.0, 0.0, 0.035]))
    given = {"links": "all", "closing_torque": 0.2} | arguments
    return hand.at(hand.neutral).grasp(Sphere(0.03, place, mass=0.3), **given)


# ---------------------------------------------------------------- Where links touch.
def test_a_box_flat_on_a_flat_palm_is_held_at_its_four_corners():
    grasp = on_palm(CUBE)
    assert names(grasp) == ["palm 1", "palm 2", "palm 3", "palm 4"]
    where = np.array([c.position for c in grasp.contacts])
    np.testing.assert_allclose(where[:, 2], 0.0, atol=1e-6)
    assert {(x > 0, y > 0) for x, y in where[:, :2]} == {(True, True), (True, False), (False, True), (False, False)}
    np.testing.assert_allclose(abs(where[:, :2]), 0.02, atol=1e-3)  # at the corners, but for an edge's rounding
    np.testing.assert_allclose([c.normal for c in grasp.contacts], np.tile([0, 0, 1], (4, 1)), atol=1e-6)


def test_a_cylinder_lying_on_a_palm_is_held_at_both_ends():
    grasp = on_palm(ROD)
    assert names(grasp) == ["palm 1", "palm 2"]
    where = np.array([c.position for c in grasp.contacts])
    np.testing.assert_allclose(where[:, [0, 2]], 0.0, atol=1e-6)
    np.testing.assert_allclose(np.sort(where[:, 1]), [-0.03, 0.03], atol=1e-3)


def test_only_links_that_are_named_touch():
    assert {n.partition(" ")[0] for n in names(on_palm(BESIDE))} == {"palm", "bar"}
    assert names(on_palm(BESIDE, links=["bar"])) == ["bar 1", "bar 2", "bar 3", "bar 4"]
    hand = example_hand("five_finger", joint_stiffness=6.0)
    chosen = ["finger_2_distal_link", "finger_4_distal_link"]
    assert names(ball_in_five_fingers(hand, links=chosen)) == chosen


# ---------------------------------------------------------------- What is said by link.
def test_pads_by_link_arrive_at_its_contacts():
    grasp = on_palm(BESIDE, flat(pad_flexibility={"palm": 2e-5, "bar": (1e-4, 2e-4, 3e-4)}))
    E = grasp.flexibility.reshape(grasp.spec.n, 3, grasp.spec.n, 3)
    for i, name in enumerate(names(grasp)):
        if name.startswith("palm"):
            np.testing.assert_allclose(E[i, :, i], 2e-5 * np.eye(3), atol=1e-15)
        else:  # the bar pushes along its x axis, which no joint but the hinge moves
            along = grasp.contacts[i].rotation[:, 2]
            np.testing.assert_allclose(abs(along), [1, 0, 0], atol=1e-6)
            lever = grasp.contacts[i].position[2]
            assert E[i, 2, i, 2] == pytest.approx(1e-4 + lever**2 / 5.0, rel=1e-6)


def test_friction_by_link_and_by_contact_stays_when_a_grasp_is_made_again():
    grasp = on_palm(BESIDE, friction={"palm": 0.9, "palm 2": 0.4})
    found = {c.name: c.mu for c in grasp.contacts}
    assert [found[f"palm {k}"] for k in (1, 2, 3, 4)] == [0.9, 0.4, 0.9, 0.9]
    assert {found[f"bar {k}"] for k in (1, 2, 3, 4)} == {0.6}  # as of every contact of which nothing is said
    for made in (grasp.replace(mass=0.3), grasp.replace(gravity=(0, 9.81, 0)), grasp.replace(load=(1, 0, 0, 0, 0, 0))):
        assert {c.name: c.mu for c in made.contacts} == found
    new = {c.name: c.mu for c in grasp.replace(friction={"palm": 0.5}).contacts}
    assert new == {name: 0.5 if name.startswith("palm") else 0.6 for name in found}


# ---------------------------------------------------------------- The same grasp said in another way.
def test_links_that_are_all_fingertips_make_the_grasp_of_the_fingertips():
    hand, cube = example_hand("three_finger", joint_stiffness=6.0), Box(0.05, (0, 0, 0.08), mass=0.2)
    state = hand.at(hand.close_on(cube))
    tips = state.grasp(cube, friction=0.8, squeeze=0.005)
    links = state.grasp(cube, friction=0.8, squeeze=0.005, links=list(hand.fingertips))
    assert names(links) == list(hand.fingertips)
    np.testing.assert_allclose(links.solve().forces_world, tips.solve().forces_world, atol=1e-9)
    np.testing.assert_allclose(links.solve().torques, tips.solve().torques, atol=1e-9)
    assert links.check().word == tips.check().word == "HELD"


def test_the_order_of_fingertips_and_how_a_ball_is_turned_do_not_matter():
    hand = example_hand("five_finger", joint_stiffness=6.0)
    backwards = hand.replace(fingertips=list(reversed(hand.fingertips)))
    first = ball_in_five_fingers(hand)
    forces = dict(zip(names(first), first.solve().forces_world, strict=True))
    turned = pin.rpy.rpyToMatrix(0.3, -0.7, 1.1)
    for other in (ball_in_five_fingers(backwards), ball_in_five_fingers(hand, turned)):
        np.testing.assert_allclose(other.state.q, first.state.q, atol=1e-6)
        assert set(names(other)) == set(forces)
        for name, force in zip(names(other), other.solve().forces_world, strict=True):
            np.testing.assert_allclose(force, forces[name], atol=1e-3 * np.linalg.norm(force))


def test_a_grasp_made_again_closes_again():
    grasp = ball_in_five_fingers()
    tighter = grasp.replace(closing_torque=0.3)
    expected = ball_in_five_fingers(closing_torque=0.3)
    assert names(tighter) == names(expected)
    np.testing.assert_allclose(tighter.joint_offset, expected.joint_offset, atol=1e-12)
    assert names(grasp.replace(links=["finger_1_distal_link"])) == ["finger_1_distal_link"]


# ---------------------------------------------------------------- What is refused, or judged.

_REFUSED = {
    "a link that there is not": ({"links": ["plam"]}, "links", "did you mean 'palm'"),
    "links beside fingers": ({"fingers": ["bare"]}, "fingers", "None beside links"),
    "an object held without a command": ({"hold_object": True}, "hold_object", "closing_torque"),
    "two commands": ({"closing_torque": 0.1, "squeeze": 1e-3}, "closing_torque", "at most one of"),
    "a torque that opens": ({"closing_torque": -0.1}, "closing_torque", "≥ 0"),
    "a torque of no joint": ({"closing_torque": {"plam": 0.1}}, "closing_torque", "a joint among [hinge]"),
    "friction of no link": ({"friction": {"plam": 0.5}}, "friction", "did you mean 'palm'"),
}


@pytest.mark.parametrize(("arguments", "argument", "text"), _REFUSED.values(), ids=_REFUSED)
def test_what_makes_no_sense_is_refused(arguments, argument, text):
    with pytest.raises(InputError) as e:
        on_palm(Sphere(0.02, (0.02, 0, 0.02)), **arguments)
    assert e.value.argument == argument
    assert text in str(e.value)


def test_a_link_without_collision_geometry_cannot_touch():
    hand = flat(fingertips=["bar"], tip_radius=None)
    with pytest.raises(InputError, match=r"links: expected links with collision geometry .*, got bare, which has none"):
        on_palm(BALL, hand, links=["palm", "bare"])


def test_an_open_hand_that_never_touches_says_how_near_it_came():
    far = Sphere(0.02, (0, 0, 0.3))
    with pytest.raises(NotReached) as e:
        on_palm(far)
    assert set(e.value.gaps) == {"palm", "bar", "bare"}
    assert e.value.gaps["palm"] == pytest.approx(0.28, abs=1e-6)
    with pytest.raises(NotReached, match="when the hand closes"):
        on_palm(far, closing_torque=0.1)


@pytest.mark.parametrize("obj", [Sphere(0.02), Cylinder(0.02, 0.06)])
@pytest.mark.parametrize("closing", [{}, {"closing_torque": 0.1}])
def test_an_object_that_begins_inside_the_palm_is_refused(obj, closing):
    with pytest.raises(InputError, match=r"target: expected an object beside the hand, .*, got palm, \d+ mm inside it"):
        on_palm(obj, **closing)


def test_where_an_object_begins_inside_links_the_verdict_says_how_deep_and_it_can_be_moved_out():
    grasp = on_palm(Box(0.04, (0, 0, 0.018), mass=0.2), flat(pad_flexibility=1e-4))
    (begins,) = grasp.solve(throw=False).verdict.about("link_inside")
    assert begins.severity == "warning"
    assert [(link["link"], link["depth_m"]) for link in begins.values["links"]] == [("palm", pytest.approx(2e-3))]
    says(begins.sentence, "2 mm inside palm")
    assert "the object begins 2 mm inside palm" in str(grasp.payload(geometry="fixed"))
    assert not grasp.out_of_reach
    text, depth, made = grasp.mechanism.variation.move_object_out(grasp.spec)
    assert depth == pytest.approx(2e-3)
    np.testing.assert_allclose(made.mechanism.target.placement.translation, (0, 0, 0.02), atol=1e-5)
    assert not [*made.mechanism.report.start_inside_reasons(made)]
    says(text, "palm")


def test_hundreds_of_contacts_are_refused():
    box = '<collision><origin xyz="{} {} -0.01"/><geometry><box size="0.005 0.005 0.02"/></geometry></collision>'
    many = "".join(box.format(0.01 * i, 0.01 * k) for i in range(-5, 6) for k in range(-5, 6))
    link = FLAT[FLAT.index("<collision>") : FLAT.index("</collision>") + len("</collision>")]
    with pytest.raises(InputError, match=r"links: expected at most 100 contacts \(name fewer links, .*got 484 places"):
        on_palm(Box((0.2, 0.2, 0.04), (0, 0, 0.02)), flat(FLAT.replace(link, many, 1)), links=["palm"])


def test_a_picture_outlines_links_that_are_drawn_elsewhere():
    box = '<geometry><box size="0.1 0.1 0.02"/></geometry>'
    drawn = FLAT.replace("</collision>\n", f'</collision><visual><origin xyz="0 0 -0.06"/>{box}</visual>\n', 1)
    grasp = on_palm(CUBE, flat(drawn))
    (outlined,) = undrawn_tip_shapes(grasp, hand_bodies(grasp.state))  # one for four contacts
    np.testing.assert_allclose(np.ptp(outlined.reshape(-1, 3), axis=0), [0.1, 0.1, 0.02], atol=1e-9)
    as_drawn = on_palm(CUBE)
    assert undrawn_tip_shapes(as_drawn, hand_bodies(as_drawn.state)) == []


def test_a_hand_does_not_close_on_an_object_inside_its_palm():
    with pytest.raises(InputError, match=r"obj: expected an object beside the hand.* got palm, \d+ mm inside it"):
        example_hand("three_finger").close_on(Sphere(0.03, (0, 0, 0)), wrap=True)
    with pytest.raises(InputError, match=r"wrap: expected True, a mapping of joints to speeds"):
        example_hand("three_finger").close_on(Sphere(0.03, (0, 0, 0.045)), wrap="yes")


@pytest.mark.long
def test_a_scene_that_is_its_own_mirror_image_holds_as_much_both_ways_and_check_agrees():
    """A snap of 1.5 mm under 0.2 kg hid in the shortest step after one that only the flow had found."""
    hand = example_hand("three_finger", joint_stiffness=6.0)
    box = Box(0.05, placement=(0.0, 0.0, 0.03), mass=0.3)
    grasp = hand.at(hand.neutral).grasp(box, links="all", closing_torque=0.4, hold_object=True, friction=0.8)
    bare = grasp.replace(gravity=(0.0, 0.0, 0.0))
    one, other = (bare.load_limit((0.0, side * 9.81, 0.0, 0.0, 0.0, 0.0)) for side in (1.0, -1.0))
    np.testing.assert_allclose(one.factor, other.factor, rtol=0.01)
    for side in (1.0, -1.0):
        pulled = grasp.replace(gravity=(0.0, side * 9.81, 0.0), mass=0.9 * one.factor)
        assert pulled.follow().held
        assert not pulled.replace(mass=1.3 * one.factor).follow().held
