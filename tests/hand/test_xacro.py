"""Hands from xacro files: as the URDF that they expand to, and what is said of files that don't."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import handlcp as hl
from tests.support.hand import urdf

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
