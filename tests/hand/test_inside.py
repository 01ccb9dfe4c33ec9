"""Links inside an object are found, with the depth that a closed form gives, and a verdict names them."""

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from handlcp.geometry.link_penetration import find_penetrating_links
from tests.support.texts import same, says

from .test_objects import box_file

ONE_LINK = """
<robot name="one"><link name="palm"/>
  <link name="link"><collision>{origin}<geometry>{shape}</geometry></collision></link><link name="link_tip"/>
  <joint name="joint" type="revolute"><parent link="palm"/><child link="link"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="0.5" velocity="1"/></joint>
  <joint name="end" type="fixed"><parent link="link"/><child link="link_tip"/><origin xyz="0 0 0.3"/></joint>
</robot>
"""


def one_link(write, shape, origin=""):
    """A link at the origin, its tip far away."""
    file = write(ONE_LINK.format(shape=shape, origin=origin))
    return hl.Hand.from_urdf(file, joint_stiffness=1.0, tip_radius=0.008)


def depth(hand, obj, q=0.0):
    """Of the one link in the object, none of whose fingertips is meant to touch it."""
    found = find_penetrating_links(hand.at([q]), obj, ())
    return found[0].depth if found else 0.0


BALL = hl.Sphere(0.025)


@pytest.mark.parametrize(
    "shape",  # each reaches 10 mm towards the ball, the cylinder with its side
    ['<sphere radius="0.01"/>', '<cylinder radius="0.01" length="0.2"/>', '<box size="0.02 0.05 0.3"/>'],
)
@pytest.mark.parametrize("overlap", [-1e-3, 0.3e-3, 12e-3])
def test_the_depth_in_a_ball_is_what_the_distance_of_its_centre_says(write, shape, overlap):
    ball = BALL.moved_to((0.025 + 0.01 - overlap, 0.0, 0.0))
    assert depth(one_link(write, shape), ball) == pytest.approx(max(overlap, 0.0), abs=5e-5)


def test_every_kind_of_object_is_known(write, tmp_path):
    hand, overlap = one_link(write, '<sphere radius="0.01"/>'), 5e-3
    at = (0.03 - overlap, 0.0, 0.0)
    lying = pin.SE3(pin.utils.rotate("y", np.pi / 2), np.array(at))
    objects = [
        hl.Box((0.04, 0.1, 0.1), at),
        hl.Cylinder(0.02, 0.1, at),
        hl.Cylinder(0.05, 0.04, lying),
        hl.Ellipsoid((0.02, 0.02, 0.02), at),
        hl.Mesh(box_file(tmp_path, np.array([0.04, 0.1, 0.1])), 1.0, at),
    ]
    for obj in objects:
        assert depth(hand, obj) == pytest.approx(overlap, abs=2e-5), obj


def test_a_cylinder_that_overlaps_a_box_has_a_depth(write):
    """Where coal 3.0.3 returns -1.8e308, NaN or a wrong number: the rim of a tilted cylinder in a face of a box."""
    hand = one_link(write, '<cylinder radius="0.02" length="0.06"/>', '<origin rpy="0 0.5 0"/>')
    lowest = 0.03 * np.cos(0.5) + 0.02 * np.sin(0.5)
    box = hl.Box((0.3, 0.3, 0.1), (0.0, 0.0, -0.05 - lowest + 4e-3))
    assert depth(hand, box) == pytest.approx(4e-3, abs=1e-4)


def test_a_mesh_is_as_deep_as_the_shape_that_it_draws(write, tmp_path):
    mesh = box_file(tmp_path, np.array([0.02, 0.05, 0.3]))
    drawn = one_link(write, f'<mesh filename="{mesh}"/>')
    plain = one_link(write, '<box size="0.02 0.05 0.3"/>')
    for q in (0.0, 0.04, -0.03):
        ball = BALL.moved_to((0.03, 0.004, 0.02))
        assert depth(drawn, ball, q) == pytest.approx(depth(plain, ball, q), abs=5e-5)
        assert depth(plain, ball, q) > 1e-3


def test_it_moves_with_the_joint(write):
    hand, ball = one_link(write, '<box size="0.02 0.05 0.3"/>'), BALL.moved_to((0.035, 0.0, 0.1))
    assert depth(hand, ball) == 0.0
    # The face x = 10 mm turns towards the ball: its distance to the centre is x cos q - z sin q - 10 mm
    q = 0.08
    gap = 0.035 * np.cos(q) - 0.1 * np.sin(q) - 0.01 - 0.025
    assert depth(hand, ball, q) == pytest.approx(-gap, abs=5e-5)


def around(ball):
    """(name, contact) of three fingertips around a ball."""
    for k, a in enumerate((0.0, 2.1, 4.2)):
        n = -np.array([np.cos(a), np.sin(a), 0.0])
        yield f"finger_{k + 1}_tip", hl.Contact(ball.center_of_mass - 0.03 * n, n, hl.Coulomb(0.8))


def test_a_ball_deep_in_the_palm_is_not_called_held(three):
    ball = hl.Sphere(0.03, (0.0, 0.0, 0.03 - 4.5e-3), mass=0.05)
    known = three.at(three.neutral).grasp(dict(around(ball)), preload=1e-3, gravity=(0, 0, 0))
    assert not known.solve().verdict.about("link_inside"), "contacts alone say nothing of the object's shape"
    found = find_penetrating_links(three.at(three.neutral), ball, ())
    assert [one.link for one in found] == ["palm"]
    assert found[0].depth == pytest.approx(4.5e-3, abs=5e-5)


def test_links_other_than_the_tips_decide_the_verdict(three):
    box = hl.Box((0.05, 0.05, 0.13), (0.0, 0.0, 0.05), mass=0.1)  # down through the palm
    v = three.at(three.close_on(box)).grasp(box, hl.Coulomb(0.8), preload=2e-3).solve().verdict
    assert v.word == "UNDECIDED"
    decides = [r for r in v.about("link_inside") if r.severity == "decides"]
    same("hand/test_inside: the palm", "; ".join(r.sentence for r in decides), "palm")
    assert decides[0].values["links"][0]["depth_m"] == pytest.approx(0.015, abs=1e-4), "below the palm's top at z = 0"


def test_a_fingertips_own_link_may_be_as_deep_as_its_tip(three):
    """Tips 3 mm inside a box are preloaded by 3 mm; their links are with them and not deeper."""
    box = hl.Box(0.05, (0.0, 0.0, 0.08), mass=0.1)
    state = three.at(three.close_on(box, squeeze=3e-3))
    assert not state.grasp(box, hl.Coulomb(0.8)).solve().verdict.about("link_inside")
    assert find_penetrating_links(state, box, ()), "without a tip that is meant to be there they are inside"


@pytest.mark.parametrize(("past", "word", "severity"), [(0.01, "HELD", "warning"), (0.2, "UNDECIDED", "decides")])
def test_a_joint_past_its_range_is_named(three, past, word, severity):
    q = np.zeros(6)
    q[1] = -past  # the distal joints' ranges begin at 0
    state = three.at(q)
    centre = state.tip_positions.mean(axis=0)
    contacts = [hl.Contact(p, (centre - p) / np.linalg.norm(centre - p), hl.Coulomb(0.8)) for p in state.tip_positions]
    v = state.grasp(contacts, preload=1e-3).solve().verdict
    (found,) = v.about("joint_range")
    assert (v.word, found.severity) == (word, severity)
    assert found.values["joint"] == three.joint_names[1] == "finger_1_distal"
    says(found.sentence, "finger_1_distal")


def test_a_can_with_links_of_fingers_inside_it_is_not_called_held(three):
    """A can of 40 mm between fingers whose axes stand on a circle of 45 mm and that are 7 mm thick: 2 mm too wide."""
    can = hl.Cylinder(0.04, 0.1, (0.0, 0.0, 0.05), mass=0.1)
    state = three.at(three.close_on(can))
    grasp = state.grasp(can, hl.Coulomb(0.8), squeeze=3e-3)
    one = grasp.solve("cone")
    assert one.held
    for v, when in ((one.verdict, "in the given posture"), (grasp.check(solution=one), "before stage 'squeeze'")):
        assert v.word != "HELD"
        first = next(r for r in v.about("link_inside") if r.severity == "decides")
        assert first.sentence.startswith(f"{when}, finger_")
        deep = [link for r in v.about("link_inside") if r.severity == "decides" for link in r.values["links"]]
        assert {link["link"] for link in deep} == {f"finger_{k}_proximal_link" for k in (1, 2, 3)}
        assert all(link["depth_m"] == pytest.approx(2e-3, abs=3e-4) for link in deep), "they lean out a little"


def test_a_link_that_the_loading_brings_into_the_object_is_said_to_be_there_at_its_end(three):
    """The same ball deep in the palm, as the place where hand and object end."""
    state = three.at(three.neutral)
    ball = hl.Sphere(0.03, (0.0, 0.0, 0.03 - 4.5e-3), mass=0.05)
    mechanism = state.grasp(dict(around(ball)), preload=1e-3).spec.mechanism
    said = [r.sentence for r in mechanism.report.end_reasons(np.zeros(6), np.zeros(6), (state, ball))]
    says("; ".join(sentence for sentence in said if "palm" in sentence), "palm", "at the end of the loading")
