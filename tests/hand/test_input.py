"""Bad input to `Hand.from_urdf`, `hand.at` and xacro files: one typed error each that names the argument."""

import os
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, UnknownName, URDFError
from handlcp.geometry import Sphere
from handlcp.hand import Hand, example_hand
from handlcp.hand.library import psyonic, urdf
from tests.support.refusals import refused

from .conftest import MIMIC

LOPSIDED = np.eye(10) + np.triu(np.ones((10, 10)), 1)
RAGGED = [1.0, [2.0, 3.0]]
INDEFINITE = np.eye(10) - 0.5 * np.ones((10, 10))
NAMES = [f"finger_{i}_{k}" for i in range(1, 6) for k in ("proximal", "distal")]
SHIPPED = urdf("three_finger").read_text(encoding="utf-8")
FIXED = """<robot name="r"><link name="palm"/><link name="t_tip"/><joint name="j" type="fixed"><parent link="palm"/>
<child link="t_tip"/></joint></robot>"""


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
    caught = refused(argument, Hand.from_urdf, call.pop("source"), error=kind, **call)
    assert isinstance(caught, ValueError)


@pytest.mark.parametrize(
    "q",
    [np.zeros(9), 0.0, [np.nan] * 10, ["a"] * 10, {"finger_1_distal": 0.0}, dict.fromkeys(NAMES, np.nan)],
)
def test_bad_postures_are_named(five, q):
    """Wrong size, not finite, no numbers, joints left out: InputError about q that lists the joints."""
    refused("q", five.at, q, match="finger_1_proximal")


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
        (FIXED, "movable joints"),
        # Numbers that Pinocchio would drop without a word
        (SHIPPED.replace('radius="0.008"', 'radius="x"', 1), "sphere radius"),
        (SHIPPED.replace('radius="0.008"', 'radius="-1"', 1), "sphere radius"),
        (SHIPPED.replace('<mass value="', '<mass value="1e308" was="', 1), "mass value"),
        (SHIPPED.replace('<mass value="', '<mass value="nan" was="', 1), "mass value"),
        (SHIPPED.replace('<mass value="', '<mass value="-1" was="', 1), "mass value"),
    ],
)
def test_broken_urdfs_say_what_is_wrong(write, text, message, capfd):
    """The parser's own words reach the exception, and nothing leaks to stderr."""
    refused("source", Hand.from_urdf, write(text), error=URDFError, match=message, joint_stiffness=1.0)
    assert capfd.readouterr().err == ""


def test_a_joint_that_hardly_follows_narrows_no_range(write):
    """Its own limits divided by next to nothing are none."""
    hand = Hand.from_urdf(write(MIMIC.replace('multiplier="0.7"', 'multiplier="5e-324"')), joint_stiffness=1.0)
    assert np.isfinite(hand.at(hand.neutral).flexibility).all()


@pytest.mark.parametrize("name", [np.zeros(2), 3])
def test_example_hands_have_names(name):
    refused("name", example_hand, name, error=UnknownName, match="five_finger")


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
        refused("tip_radius", state.grasp, Sphere(0.01), error=URDFError)


def test_meshes_that_are_not_found_are_named(write):
    """A package:// address that leads nowhere: the address and the folders that were tried."""
    mesh = '<link name="d_tip"><collision><geometry><mesh filename="package://here/not.stl"/></geometry></collision></link>'
    path = write(MIMIC.replace('<link name="d_tip"/>', mesh))
    hand = Hand.from_urdf(path, ["d_tip"], joint_stiffness=1.0)
    refused(
        "package_dirs", hand.at(hand.neutral).grasp, Sphere(0.01), error=URDFError, match=r"package://here/not\.stl"
    )


def test_the_error_channel_is_given_back(five, write, capfd):
    """After a failed parse, stderr works as before."""
    with pytest.raises(URDFError):
        Hand.from_urdf(write("<robot name='r'/>"), joint_stiffness=1.0)
    os.write(2, b"still here")
    assert capfd.readouterr().err == "still here"


def test_a_tip_whose_shape_cannot_be_read_names_itself(tmp_path):
    file, root = tmp_path / "empty.urdf", ET.fromstring(SHIPPED)
    for geometry in root.findall("link[@name='finger_1_tip']/collision/geometry"):
        geometry.clear()
    file.write_text(ET.tostring(root, encoding="unicode"))
    hand = hl.Hand.from_urdf(file, joint_stiffness=1.0)
    with pytest.raises(hl.URDFError, match="finger_1_tip"):
        hand.close_on(hl.Sphere(0.03, (0, 0, 0.08)))


# ---------------------------------------------------------------- hands from xacro files: as the URDF that they
LINE = '<xacro:property name="half" value="${0.5 * 1.2}"/>'
HEAD = '<robot name="three_finger" xmlns:xacro="http://www.ros.org/wiki/xacro">'


@pytest.fixture
def folder(tmp_path):
    """A package: one file with the hand as a macro, one that calls it."""
    inside = SHIPPED[SHIPPED.index("<link") : SHIPPED.index("</robot>")]
    inside = inside.replace('effort="0.8"', 'effort="${half + 0.2}"')
    parts = f'{HEAD}<xacro:macro name="hand" params="half">{inside}</xacro:macro></robot>'
    (tmp_path / "parts.xacro").write_text(parts, encoding="utf-8")
    (tmp_path / "package.xml").write_text("<package><name>my_hand</name></package>", encoding="utf-8")
    main = f'{HEAD}<xacro:include filename="$(find my_hand)/parts.xacro"/>{LINE}<xacro:hand half="${{half}}"/></robot>'
    (tmp_path / "hand.urdf.xacro").write_text(main, encoding="utf-8")
    return tmp_path


def test_a_xacro_file_is_the_hand_that_its_urdf_is(folder):
    pytest.importorskip("xacrodoc")
    hand = hl.Hand.from_urdf(folder / "hand.urdf.xacro", joint_stiffness=6.0)
    plain = hl.Hand.from_urdf(urdf("three_finger"), joint_stiffness=6.0)
    assert hand.joint_names == plain.joint_names
    np.testing.assert_allclose(hand.torque_limits, plain.torque_limits)
    np.testing.assert_allclose(hand.at(hand.neutral).tip_positions, plain.at(plain.neutral).tip_positions)
    assert len(hl.audit_urdf(folder / "hand.urdf.xacro")) == len(hl.audit_urdf(urdf("three_finger")))


@pytest.mark.parametrize(
    "body", ["${1/0}", "<xacro:nothing/>", '<xacro:include filename="$(find nowhere)/a.xacro"/>', "<open>"]
)
def test_a_xacro_file_that_cannot_be_expanded_is_refused(tmp_path, body):
    pytest.importorskip("xacrodoc")
    file = tmp_path / "hand.xacro"
    file.write_text(f"{HEAD}{body}</robot>", encoding="utf-8")
    with pytest.raises(hl.URDFError, match=r"hand\.xacro"):
        hl.Hand.from_urdf(file, joint_stiffness=6.0)


def test_without_xacrodoc_the_error_says_what_to_install(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "xacrodoc", None)
    with pytest.raises(hl.Unsupported, match="pip install 'xacrodoc>="):
        hl.Hand.from_urdf(folder / "hand.urdf.xacro", joint_stiffness=6.0)


def test_macros_in_a_text_are_sent_to_a_file():
    with pytest.raises(hl.URDFError, match="path of a xacro file"):
        hl.Hand.from_urdf(f"{HEAD}{LINE}</robot>", joint_stiffness=6.0)


FINGER = """<xacro:macro name="finger" params="n x"><link name="${n}"><collision><geometry><sphere radius="0.01"/>
</geometry></collision></link><joint name="j_${n}" type="revolute"><parent link="palm"/><child link="${n}"/>
<origin xyz="${x} 0 0"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</xacro:macro>"""
TWO = '<link name="palm"/><xacro:finger n="l" x="0.03"/><xacro:finger n="r" x="-0.03"/>'


@pytest.fixture
def relative(tmp_path):
    """A file that includes one of a folder beside it, which includes one beside itself, both by relative paths."""
    pytest.importorskip("xacrodoc")
    (tmp_path / "parts" / "deep").mkdir(parents=True)
    (tmp_path / "elsewhere" / "parts").mkdir(parents=True)
    (tmp_path / "parts" / "deep" / "finger.xacro").write_text(f"{HEAD}{FINGER}</robot>", encoding="utf-8")
    within = f'{HEAD}<xacro:include filename="deep/finger.xacro"/></robot>'
    (tmp_path / "parts" / "all.xacro").write_text(within, encoding="utf-8")
    main = f'{HEAD}<xacro:include filename="parts/all.xacro"/>{TWO}</robot>'
    (tmp_path / "main.urdf.xacro").write_text(main, encoding="utf-8")
    other = f"{HEAD}{FINGER.replace('j_', 'other_')}</robot>"
    (tmp_path / "elsewhere" / "parts" / "all.xacro").write_text(other, encoding="utf-8")
    return tmp_path


def test_a_relative_include_is_looked_up_beside_the_file_that_includes(relative, monkeypatch):
    """Wherever the process stands, also where a file of the same name lies; and for a relative path of the file."""
    for folder, path in ((relative / "elsewhere", "../main.urdf.xacro"), (relative, "main.urdf.xacro")):
        monkeypatch.chdir(folder)
        for source in (path, relative / "main.urdf.xacro"):
            assert hl.Hand.from_urdf(source, ["l", "r"], joint_stiffness=3.0).joint_names == ("j_l", "j_r")


def test_a_file_that_failed_leaves_nothing_behind_for_the_next_one(relative):
    """Xacro keeps which files it reads in a variable of its module."""
    bad = relative / "parts" / "bad.xacro"
    bad.write_text(f'{HEAD}<xacro:include filename="deep/finger.xacro"/>${{1/0}}</robot>', encoding="utf-8")
    wrong = relative / "wrong.xacro"
    wrong.write_text(f'{HEAD}<xacro:include filename="parts/bad.xacro"/><xacro:finger/></robot>', encoding="utf-8")
    for _ in range(2):
        with pytest.raises(hl.URDFError, match=r"wrong\.xacro"):
            hl.audit_urdf(wrong)
        assert hl.audit_urdf(relative / "main.urdf.xacro").doubts
