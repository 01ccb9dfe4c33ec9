"""Bad input to `Hand.from_urdf` and `hand.at`: one typed error each that names the argument."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, UnknownName, URDFError
from handlcp.geometry import Sphere
from handlcp.hand import Hand, example_hand
from handlcp.hand.library import psyonic, urdf

from .conftest import MIMIC

LOPSIDED = np.eye(10) + np.triu(np.ones((10, 10)), 1)
RAGGED = [1.0, [2.0, 3.0]]
INDEFINITE = np.eye(10) - 0.5 * np.ones((10, 10))


@pytest.mark.parametrize(
    ("arguments", "argument", "kind"),
    [
        ({"joint_stiffness": np.nan}, "joint_stiffness", InputError),
        ({"joint_stiffness": True}, "joint_stiffness", InputError),
        ({"joint_stiffness": {"thumb": 1.0}}, "joint_stiffness", UnknownName),
        ({"joint_stiffness": {"finger_1_distal": 1.0}}, "joint_stiffness", InputError),
        ({"joint_stiffness": [1.0] * 9 + [-1.0]}, "joint_stiffness[9]", InputError),
        ({"joint_stiffness": LOPSIDED}, "joint_stiffness", InputError),
        ({"joint_stiffness": INDEFINITE}, "joint_stiffness", InputError),
        ({"pad_flexibility": np.inf}, "pad_flexibility", InputError),
        ({"pad_flexibility": np.diag([1e-4, 1e-4, -1e-4])}, "pad_flexibility", InputError),
        ({"pad_flexibility": {"finger_1_tip": -1.0}}, "pad_flexibility['finger_1_tip']", InputError),
        ({"torque_limits": [0.5] * 3}, "torque_limits", InputError),
        ({"torque_limits": {"finger_1_distal": -1.0}}, "torque_limits['finger_1_distal']", InputError),
        ({"tip_radius": 0.0}, "tip_radius", InputError),
        ({"fingertips": ["finger_1_tip", "thumb_tip"]}, "fingertips", UnknownName),
        ({"fingertips": [1, 2]}, "fingertips", UnknownName),
        ({"fingertips": ["palm"]}, "fingertips", InputError),
        ({"joint_stiffness": RAGGED}, "joint_stiffness", InputError),
        ({"base": "wrist"}, "base", UnknownName),
        ({"package_dirs": "/no/such/folder"}, "package_dirs", InputError),
        ({"source": "no_such.urdf"}, "source", URDFError),
        ({"source": Path(__file__).parent}, "source", URDFError),
        ({"source": 7}, "source", InputError),
    ],
)
def test_bad_arguments_of_from_urdf_are_named(arguments, argument, kind):
    """One broken argument a time; all are HandLCPError and ValueError."""
    call = {"source": urdf("five_finger"), "joint_stiffness": 1.0} | arguments
    with pytest.raises(kind) as caught:
        Hand.from_urdf(call.pop("source"), **call)
    assert caught.value.argument == argument
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize(
    "q",
    [
        np.zeros(9),
        0.0,
        [np.nan] * 10,
        ["a"] * 10,
        {"finger_1_distal": 0.0},
        {f"finger_{i}_{k}": np.nan for i in range(1, 6) for k in ("proximal", "distal")},
    ],
)
def test_bad_postures_are_named(five, q):
    """Wrong size, not finite, no numbers, joints left out: InputError about q that lists the joints."""
    with pytest.raises(InputError, match="finger_1_proximal") as caught:
        five.at(q)
    assert caught.value.argument == "q"


def test_fingertips_that_are_not_obvious_are_proposed():
    """A robot with two hands: which of its ten fingers are meant, nobody can know."""
    with pytest.raises(UnknownName, match="Left_index_anchor") as caught:
        Hand.from_urdf(psyonic()[0], joint_stiffness=1.0)
    assert "Right_thumb_anchor" in caught.value.valid


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no element found"),
        ("<robot>", "line 1"),
        ("<mujoco/>", "<mujoco>"),
        ("<robot name='r'/>", "No link elements"),
        (MIMIC.replace('<child link="a"/>', '<child link="z"/>'), "child link .z. of joint .z1. not found"),
        (MIMIC.replace('type="revolute"', 'type="hinge"'), "hinge"),
        (MIMIC.replace('xyz="0.05 0 0"', 'xyz="0.05 0 x"'), "origin xyz"),
        (MIMIC.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>'), "axis"),
        (MIMIC.replace('mimic joint="z1"', 'mimic joint="nobody"'), "nobody"),
        (MIMIC.replace('mimic joint="z1"', 'mimic joint="k3"'), "circle"),
        (MIMIC.replace('multiplier="0.7"', 'multiplier="nan"'), "multiplier value"),
        (MIMIC.replace('multiplier="0.7"', 'multiplier="1e300"'), "up to"),
        (MIMIC.replace('offset="0.1"', 'offset="-1e300"'), "up to"),
        (MIMIC.replace('type="continuous"', 'type="floating"'), "one degree of freedom"),
        (
            '<robot name="r"><link name="palm"/><link name="t_tip"/><joint name="j" type="fixed"><parent link="palm"/>'
            '<child link="t_tip"/></joint></robot>',
            "movable joints",
        ),
    ],
)
def test_broken_urdfs_say_what_is_wrong(write, text, message, capfd):
    """The parser's own words reach the exception, and nothing leaks to stderr."""
    with pytest.raises(URDFError, match=message) as caught:
        Hand.from_urdf(write(text), joint_stiffness=1.0)
    assert caught.value.argument == "source"
    assert capfd.readouterr().err == ""


def test_a_joint_that_hardly_follows_narrows_no_range(write):
    """Its own limits divided by next to nothing are none."""
    hand = Hand.from_urdf(write(MIMIC.replace('multiplier="0.7"', 'multiplier="5e-324"')), joint_stiffness=1.0)
    assert np.isfinite(hand.at(hand.neutral).flexibility).all()


@pytest.mark.parametrize("name", [np.zeros(2), 3])
def test_example_hands_have_names(name):
    with pytest.raises(UnknownName, match="five_finger") as caught:
        example_hand(name)
    assert caught.value.argument == "name"


def test_binary_rubbish_is_no_urdf(tmp_path):
    """A file that is no text at all."""
    path = tmp_path / "noise.urdf"
    path.write_bytes(os.urandom(200))
    with pytest.raises(URDFError, match="noise"):
        Hand.from_urdf(path, joint_stiffness=1.0)


def test_tips_without_geometry_ask_for_a_radius(write, five):
    """No collision geometry, or a Pinocchio model: tip_radius is asked for, once contacts are detected."""
    for source in (write(MIMIC), five.model):
        hand = Hand.from_urdf(source, joint_stiffness=1.0)
        state = hand.at(hand.neutral)
        with pytest.raises(URDFError) as caught:
            state.grasp(Sphere(0.01))
        assert caught.value.argument == "tip_radius"


def test_meshes_that_are_not_found_are_named(write):
    """A package:// address that leads nowhere: the address and the folders that were tried."""
    mesh = '<link name="d_tip"><collision><geometry><mesh filename="package://here/not.stl"/></geometry></collision></link>'
    path = write(MIMIC.replace('<link name="d_tip"/>', mesh))
    hand = Hand.from_urdf(path, ["d_tip"], joint_stiffness=1.0)
    with pytest.raises(URDFError, match=r"package://here/not\.stl") as caught:
        hand.at(hand.neutral).grasp(Sphere(0.01))
    assert caught.value.argument == "package_dirs"


def test_the_error_channel_is_given_back(five, write, capfd):
    """After a failed parse, stderr works as before."""
    with pytest.raises(URDFError):
        Hand.from_urdf(write("<robot name='r'/>"), joint_stiffness=1.0)
    os.write(2, b"still here")
    assert capfd.readouterr().err == "still here"


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('radius="0.008"', 'radius="x"', "sphere radius"),
        ('radius="0.008"', 'radius="-1"', "sphere radius"),
        ('<mass value="', '<mass value="1e308" was="', "mass value"),
        ('<mass value="', '<mass value="nan" was="', "mass value"),
        ('<mass value="', '<mass value="-1" was="', "mass value"),
    ],
)
def test_numbers_that_pinocchio_would_drop_without_a_word_are_refused(tmp_path, old, new, named):
    text = urdf("three_finger").read_text()
    assert old in text
    file = tmp_path / "broken.urdf"
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(URDFError, match=named):
        Hand.from_urdf(file, joint_stiffness=1.0)


def test_a_tip_whose_shape_cannot_be_read_names_itself(tmp_path):
    text = urdf("three_finger").read_text()
    file = tmp_path / "empty.urdf"
    root = ET.fromstring(text)
    for link in root.findall("link"):
        if link.get("name") == "finger_1_tip":
            for geometry in link.findall("collision/geometry"):
                geometry.clear()
    file.write_text(ET.tostring(root, encoding="unicode"))
    hand = hl.Hand.from_urdf(file, joint_stiffness=1.0)
    with pytest.raises(hl.URDFError, match="finger_1_tip"):
        hand.close_on(hl.Sphere(0.03, (0, 0, 0.08)))
