"""Hands whose joints slide: newtons and N/m in audits, reasons, errors and tables, beside N·m of joints that turn."""

from __future__ import annotations

import pytest

import handlcp as hl

SLIDE = """<joint name="{n}_slide" type="prismatic"><parent link="palm"/><child link="{n}"/>
<origin xyz="{x} 0 0.05"/><axis xyz="{way} 0 0"/><limit lower="0" upper="0.04" effort="{effort}" velocity="1"/></joint>
<link name="{n}"><inertial><mass value="0.05"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/>
</inertial><collision><geometry><sphere radius="0.01"/></geometry></collision></link>"""
HINGE = """<joint name="h_hinge" type="revolute"><parent link="palm"/><child link="h"/><origin xyz="0 0.04 0"/>
<axis xyz="1 0 0"/><limit lower="-0.5" upper="1.2" effort="0.8" velocity="1"/></joint><link name="h"><inertial>
<mass value="0.05"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial><collision>
<origin xyz="0 0 0.05"/><geometry><sphere radius="0.01"/></geometry></collision></link>"""
BOX = hl.Box(0.04, (0, 0, 0.05), mass=0.1)


def text(effort=60.0, hinge=False):
    slides = "".join(SLIDE.format(n=n, x=-0.04 * way, way=way, effort=effort) for n, way in (("l", 1), ("r", -1)))
    palm = '<link name="palm"><collision><geometry><box size="0.1 0.02 0.01"/></geometry></collision></link>'
    return f'<robot name="slides">{palm}{slides}{HINGE if hinge else ""}</robot>'


def gripper(stiffness=1e4, **more):
    return hl.Hand.from_urdf(text(**more), ["l", "r"], joint_stiffness=stiffness)


def test_newton_metres_for_the_spring_of_a_slide_are_a_serious_doubt():
    (doubt,) = (d for d in gripper(6.0).audit().serious if d.about == "slide")
    assert doubt.joint == "l_slide, r_slide"
    assert "6 N/m lets a slide give way by 167 mm under 1 N" in doubt.what
    assert not [d for d in gripper().audit().serious if d.about == "slide"]
    mixed = hl.Hand.from_urdf(text(hinge=True), ["l", "r", "h"], joint_stiffness=6.0).audit()
    assert [d.joint for d in mixed.serious if d.about == "slide"] == ["l_slide, r_slide"]


@pytest.mark.parametrize("effort", [60.0, 100.0, 0.0, 5000.0])
def test_the_audit_speaks_of_newtons(effort):
    """No "N·m" in a doubt about a hand whose joints all slide."""
    for audit in (hl.audit_urdf(text(effort)), gripper(effort=effort).audit()):
        said = [f"{d.what} {d.advice}" for d in audit if d.about in ("torque limit", "limit unknown", "stiffness")]
        assert said
        assert not [one for one in said if "N·m" in one]
    both = hl.audit_urdf(text(effort=0.0, hinge=True))
    assert [d.advice for d in both if d.about == "limit unknown"] == ["torque_limits with the actuator's force [N]"]


def test_required_torque_has_newtons_of_slides():
    """In the heads where all joints slide; beside each number where others turn."""
    hand = gripper()
    found = hand.at(hand.close_on(BOX)).grasp(BOX, friction=0.8, grip_force=5.0).required_torque()
    assert found.confirmed
    assert "N·m" not in str(found)
    assert "limit\nN" in found.table.heads[3]
    mixed = hl.Hand.from_urdf(text(hinge=True), ["l", "r"], joint_stiffness=1e4)
    table = mixed.at(mixed.close_on(BOX)).grasp(BOX, friction=0.8, grip_force=5.0).required_torque()
    rows = {row[0]: row for row in table.rows}
    assert rows["l_slide"][3] == "60 N"
    assert rows["h_hinge"][3] == "0.8"
    assert table.table.heads[3] == "limit\nN·m"


def test_a_verdict_speaks_of_newtons():
    hand = gripper(effort=3.0)
    grasp = hand.at(hand.close_on(BOX)).grasp(BOX, friction=0.8, grip_force=5.0)
    verdict = grasp.check()
    assert verdict.word == "OVER LIMIT"
    assert "N of 3 N" in str(verdict)
    assert "N·m" not in str(verdict)


def test_what_a_file_states_has_the_unit_of_its_joint():
    spring = '<dynamics friction="{}"/></joint>'
    rubbing = text(hinge=True).replace("</joint>", spring.format(2), 2).replace("</joint>", spring.format(0.1))
    rubbing = rubbing.replace(spring.format(2)[:-8] + spring.format(0.1), spring.format(2))
    rows = [row for row in hl.describe_urdf(rubbing).stated if row.what == "dry friction"]
    assert {row.unit: sorted(row.values) for row in rows} == {"N·m": ["h_hinge"], "N": ["l_slide", "r_slide"]}
