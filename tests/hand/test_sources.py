"""Where hands come from: a path, a text, a pinocchio.Model, a RobotWrapper; what is too large, or in other units."""

from __future__ import annotations

import pickle
import re
import time

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from handlcp.hand.library import allegro, psyonic, urdf

BALL = hl.Sphere(0.03, (0, 0, 0.09))


def test_the_text_of_a_urdf_is_as_good_as_its_path():
    text = urdf("three_finger").read_text()
    of_file, of_text = (hl.Hand.from_urdf(s, joint_stiffness=1.0) for s in (urdf("three_finger"), f"\n  {text}"))
    q = of_file.close_on(BALL)
    np.testing.assert_array_equal(of_text.close_on(BALL), q)
    np.testing.assert_array_equal(of_text.at(q).jacobian, of_file.at(q).jacobian)
    assert of_text.source == "three_finger"


def test_meshes_of_a_text_are_found_through_package_dirs():
    file, share = psyonic()
    anchors = {"base": "LeftPsyonicAbilityBaseLink", "joint_stiffness": 1.0}
    hand = hl.Hand.from_urdf(file.read_text(), package_dirs=share, **anchors)
    assert len(hand.link_surfaces) == len(hl.Hand.from_urdf(file, **anchors).link_surfaces) > 10
    with pytest.raises(hl.URDFError, match="package_dirs"):
        _ = hl.Hand.from_urdf(file.read_text(), **anchors).link_surfaces


def test_a_model_makes_the_hand_of_its_file():
    model = pin.buildModelFromUrdf(str(urdf("five_finger")))
    hand, same = hl.Hand.from_model(model, joint_stiffness=1.0), hl.example_hand("five_finger")
    q = np.linspace(0, 0.5, 10)
    np.testing.assert_array_equal(hand.at(q).jacobian, same.at(q).jacobian)
    np.testing.assert_array_equal(hand.torque_limits, same.torque_limits)
    assert hand.describe().mass == pytest.approx(same.describe().mass)
    with pytest.raises(hl.URDFError, match="no geometry"):
        hand.close_on(BALL)


@pytest.fixture
def wrapped():
    """The three-finger hand, from Pinocchio's RobotWrapper."""
    return hl.Hand.from_model(pin.RobotWrapper.BuildFromURDF(str(urdf("three_finger"))), joint_stiffness=1.0)


def test_a_robot_wrapper_brings_its_collision_geometry(wrapped):
    """The same contacts, and the same links seen inside an object, as from the file."""
    hand = hl.Hand.from_urdf(urdf("three_finger"), joint_stiffness=1.0)
    q = hand.close_on(BALL)
    np.testing.assert_allclose(wrapped.close_on(BALL), q, atol=1e-12)
    one, other = (h.at(q).grasp(BALL).spec for h in (hand, wrapped))
    np.testing.assert_allclose(other.positions, one.positions, atol=1e-12)
    assert [s.name for s in wrapped.link_surfaces] == [s.name for s in hand.link_surfaces]
    assert wrapped.describe().size == pytest.approx(hand.describe().size)


def test_meshes_of_a_robot_wrapper_come_too():
    file, share = allegro()
    hand = hl.Hand.from_model(pin.RobotWrapper.BuildFromURDF(str(file), [str(share)]), joint_stiffness=1.0)
    same = hl.Hand.from_urdf(file, joint_stiffness=1.0)
    for one, other in zip(hand.link_surfaces, same.link_surfaces, strict=True):
        assert one.name == other.name
        np.testing.assert_allclose(one.net[0], other.net[0], atol=1e-12)


def test_hands_of_wrappers_pickle(wrapped):
    again = pickle.loads(pickle.dumps(wrapped))
    np.testing.assert_array_equal(again.close_on(BALL), wrapped.close_on(BALL))


@pytest.mark.parametrize("source", [None, 3, "two_finger.urdf", object()])
def test_what_is_no_model_is_refused(source):
    with pytest.raises(hl.InputError, match=r"pinocchio\.Model") as caught:
        hl.Hand.from_model(source, joint_stiffness=1.0)
    assert caught.value.argument == "model"


def test_mimic_joints_of_a_model_are_refused():
    """Pinocchio gives them no column of the Jacobian; the URDF itself says more."""
    text = re.sub(r'(<joint name="finger_1_distal".*?)</joint>', r'\1<mimic joint="finger_1_proximal"/></joint>',
                  urdf("three_finger").read_text(), flags=re.S)  # fmt: skip
    assert hl.Hand.from_urdf(text, joint_stiffness=1.0).nv == 5
    model = pin.buildModelFromXML(text, mimic=True)
    with pytest.raises(hl.InputError, match="mimic=False") as caught:
        hl.Hand.from_model(model, joint_stiffness=1.0)
    assert "finger_1_distal" in str(caught.value)


# ---------------------------------------------------------------- other units
def test_a_hand_in_millimetres_is_asked_about():
    text = urdf("three_finger").read_text()
    with pytest.raises(hl.URDFError, match="millimetres") as caught:
        hl.Hand.from_urdf(scaled(text, 1000.0), joint_stiffness=1.0)
    assert "0.001" in str(caught.value)
    assert hl.Hand.from_urdf(scaled(text, 2.0), joint_stiffness=1.0).nv == 6, "a large hand is one all the same"


def scaled(text, by):
    """Every position of a URDF so many times as large."""

    def longer(m):
        return 'origin xyz="' + " ".join(str(by * float(x)) for x in m[1].split()) + '"'

    return re.sub(r'origin xyz="([^"]*)"', longer, text)


def test_masses_in_grams_are_asked_about():
    text = urdf("three_finger").read_text()
    heavy = re.sub(r'mass value="([^"]*)"', lambda m: f'mass value="{1e4 * float(m[1])}"', text)
    with pytest.raises(hl.URDFError, match="grams"):
        hl.Hand.from_urdf(heavy, joint_stiffness=1.0)


@pytest.mark.parametrize("radius", [8, {"finger_1_tip": 12.0}])
def test_a_tip_radius_in_millimetres_is_asked_about(radius):
    with pytest.raises(hl.InputError, match=r"if millimetres are meant, 0\.0") as caught:
        hl.example_hand("three_finger", tip_radius=radius)
    assert caught.value.argument.startswith("tip_radius")


# ---------------------------------------------------------------- too large
def chain(links):
    """A robot of so many links in a row."""
    limit = '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    rows = [
        f'<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="l{i - 1}"/><child link="l{i}"/>{limit}'
        for i in range(1, links)
    ]
    return f'<robot name="r"><link name="l0"/>{"".join(rows)}</robot>'


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(lambda: chain(100_000), id="100 000 links"),
        pytest.param(lambda: chain(700), id="700 joints"),
        pytest.param(lambda: '<robot name="r">' + '<link name="l"/>' * 3000 + "</robot>", id="3000 links"),
        pytest.param(lambda: "<robot>" + "<link>" * 10_000 + "</link>" * 10_000 + "</robot>", id="nested"),
        pytest.param(lambda: "<robot>" + "<link>" * 2_000_000, id="nested and open"),
        pytest.param(lambda: "<mujoco>" + "<body>" * 10_000 + "</body>" * 10_000 + "</mujoco>", id="nested bodies"),
    ],
)
def test_what_is_too_large_is_refused_at_once(text):
    """By a typed error, and not after minutes or by a crash of a library below."""
    made = text()
    start = time.process_time()
    read = hl.Hand.from_mjcf if made.startswith("<mujoco") else hl.Hand.from_urdf
    with pytest.raises(hl.URDFError):
        read(made, joint_stiffness=1.0)
    with pytest.raises(hl.URDFError):
        hl.describe_urdf(made)
    assert time.process_time() - start < 5.0


def test_names_that_are_no_path_are_refused():
    for name in ("x" * 5000, "a\0b"):
        with pytest.raises(hl.URDFError) as caught:
            hl.Hand.from_urdf(name, joint_stiffness=1.0)
        assert len(str(caught.value)) < 400
