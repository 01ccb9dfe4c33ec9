"""Hands from xacro files: as the URDF that they expand to, and what is said of files that don't."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand.library import urdf

LINE = '<xacro:property name="half" value="${0.5 * 1.2}"/>'
HEAD = '<robot name="three_finger" xmlns:xacro="http://www.ros.org/wiki/xacro">'


@pytest.fixture
def folder(tmp_path):
    """A package: one file with the hand as a macro, one that calls it."""
    text = urdf("three_finger").read_text(encoding="utf-8")
    inside = text[text.index("<link") : text.index("</robot>")]
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


def test_a_file_of_macros_alone_says_that_it_calls_none(relative):
    with pytest.raises(hl.URDFError, match=r"defines macros \(finger\) and calls none") as refused:
        hl.Hand.from_urdf(relative / "parts" / "deep" / "finger.xacro", joint_stiffness=3.0)
    assert "the one that includes this one" in str(refused.value)
