"""What a hand says of itself, and a file of which nothing else is known."""

from __future__ import annotations

import re

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand import HANDS
from handlcp.hand.library import allegro, psyonic, urdf
from tests.support.texts import says

from .conftest import MIMIC


def test_joints_are_described_as_the_hand_has_them(hand):
    """Ranges, limits, stiffness, and which fingertips a joint moves, against the hand's own arrays."""
    described = hand.describe()
    assert [j.name for j in described] == list(hand.joint_names)
    np.testing.assert_array_equal([(j.lower, j.upper) for j in described], np.stack([hand.lower, hand.upper], axis=1))
    np.testing.assert_array_equal([j.torque_limit for j in described], hand.torque_limits)
    np.testing.assert_array_equal([j.stiffness for j in described], np.diagonal(hand.joint_stiffness))
    moves = hand.moving_joints
    for k, j in enumerate(described):
        assert j.fingertips == tuple(tip for i, tip in enumerate(hand.fingertips) if moves[i, k])
    taken = [t for t in described.fingertips if t.taken]
    assert [t.name for t in taken] == list(hand.fingertips)
    assert len(described) == hand.nv


@pytest.mark.parametrize("name", HANDS)
def test_descriptions_fit_80_columns(name):
    described = hl.example_hand(name).describe()
    assert max(map(len, str(described).splitlines())) <= 80


def test_a_description_is_text_to_read():
    """The whole of it, so that a change of wording is seen."""
    says(str(hl.describe_urdf(urdf("two_finger"))), "two_finger", "finger_1_tip")


def test_size_and_mass_are_those_of_the_links():
    """A box 60 × 40 × 20 mm of 0.3 kg, and a rod 100 mm long of 0.1 kg that stands on it."""
    text = """<robot name="r"><link name="palm"><inertial><mass value="0.3"/><inertia ixx="1e-4" ixy="0" ixz="0"
      iyy="1e-4" iyz="0" izz="1e-4"/></inertial><collision><geometry><box size="0.06 0.04 0.02"/></geometry></collision>
      </link><link name="rod"><inertial><mass value="0.1"/><inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0"
      izz="1e-5"/></inertial><collision><origin xyz="0 0 0.05"/><geometry><cylinder radius="0.01" length="0.1"/>
      </geometry></collision></link><joint name="j" type="revolute"><origin xyz="0 0 0.01"/>
      <parent link="palm"/><child link="rod"/>
      <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
    described = hl.describe_urdf(text)
    assert described.mass == pytest.approx(0.4)
    assert described.size == pytest.approx((0.06, 0.04, 0.12))
    assert {k.name: k.mass for k in described.links} == {"palm": 0.3, "rod": 0.1}


def test_couplings_are_described(coupled):
    """k3 follows m2 follows z1: -2 (0.7 q + 0.1) + 0.05."""
    rows = {c.joint: c for c in coupled.describe().couplings}
    assert rows["m2"][1:] == pytest.approx(("z1", 0.7, 0.1))
    assert rows["k3"].follows == "z1"
    assert (rows["k3"].factor, rows["k3"].offset) == pytest.approx((-1.4, -0.15))
    assert "k3 = -1.4 × z1 - 0.15" in str(coupled.describe())


def test_a_robot_with_two_hands_is_described_with_its_candidates():
    """Nothing is taken, and what could be is said, with the reason."""
    described = hl.describe_urdf(psyonic()[0])
    assert not any(t.taken for t in described.fingertips)
    assert {f"{side}_thumb_anchor" for side in ("Left", "Right")} <= {t.name for t in described.fingertips}
    assert all(t.reason for t in described.fingertips)
    assert "Candidates" in str(described)
    one = hl.describe_urdf(psyonic()[0], base="LeftPsyonicAbilityBaseLink")
    assert sum(t.taken for t in one.fingertips) == 5


def test_meshes_are_not_needed():
    """A file whose meshes are elsewhere is described all the same, and its size is that of its joints."""
    text = re.sub(r"package://[^\"]*/", "package://nowhere/", allegro()[0].read_text())
    described = hl.describe_urdf(text)
    assert max(described.size) > 0.1
    (missing,) = (d for d in described.audit if "mesh files" in d.what)
    assert missing.severity == "information", "the Allegro's meshes are drawn, and nothing else"


def test_names_too_long_for_the_table_get_a_line_of_their_own():
    text = MIMIC.replace('"z1"', f'"{"z" * 70}"')
    lines = str(hl.describe_urdf(text)).splitlines()
    assert max(map(len, lines)) <= 80
    assert any(line.strip() == "z" * 70 for line in lines)


def test_named_fingertips_are_said_to_be_named():
    described = hl.example_hand("two_finger", fingertips={"thumb": ("finger_1_tip", (0, 0, 0.002))}).describe()
    (taken,) = (t for t in described.fingertips if t.taken)
    assert taken[:4] == ("thumb", "finger_1_tip", (0.0, 0.0, 0.002), True)
    assert [t.name for t in described.fingertips if not t.taken] == ["finger_2_tip"]
    says(str(described), "thumb: on finger_1_tip, point (0.0, 0.0, 2.0) mm")
