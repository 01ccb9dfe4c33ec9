"""What looks like a fingertip: names that say so, ends of fingers, and bars of linkages, which are none."""

from __future__ import annotations

import pytest

import handlcp as hl

JOINT = """<joint name="{name}_j" type="revolute"><parent link="{parent}"/><child link="{name}"/><origin xyz="{at}"/>
<axis xyz="0 1 0"/><limit lower="-0.8" upper="0.8" effort="2" velocity="1"/>{mimic}</joint>
<link name="{name}"><collision><origin xyz="0 0 {half}"/><geometry><box size="0.008 0.01 {length}"/></geometry>
</collision></link>"""
PALM = '<link name="palm"><collision><geometry><box size=".1 .03 .02"/></geometry></collision></link>'


def link(name, parent, at, length, follows=None):
    mimic = "" if follows is None else f'<mimic joint="right_knuckle_j" multiplier="{follows}"/>'
    return JOINT.format(name=name, parent=parent, at=at, mimic=mimic, half=length / 2, length=length)


def gripper(bars=True, tip=""):
    """Two fingers that stay parallel: a knuckle and a bar of the same length turn alike, the finger turns back."""
    text = PALM
    for side, way in (("right", 1), ("left", -1)):
        own = None if way > 0 else -1.0
        text += link(f"{side}_knuckle", "palm", f"{0.03 * way} 0 0.01", 0.05, own)
        text += link(f"{side}_finger", f"{side}_knuckle", "0 0 0.05", 0.06, -way)
        if bars:
            text += link(f"{side}_bar", "palm", f"{0.015 * way} 0 0.02", 0.05, way)
        if tip:
            text += f'<joint name="{side}_fixed" type="fixed"><parent link="{side}_finger"/>'
            text += f'<child link="{side}{tip}"/><origin xyz="0 0 0.06"/></joint><link name="{side}{tip}"/>'
    return f'<robot name="g">{text}</robot>'


@pytest.mark.parametrize(
    "tip", ["_tip", "_tip_link", "_fingertip_link", "_tip_1", "_fingertip", "_tip_frame", "Tip", "_tip_link_2"]
)
def test_names_that_say_fingertip_are_taken(tip):
    """Beside bars, whose names do not."""
    hand = hl.Hand.from_urdf(gripper(tip=tip), joint_stiffness=3.0)
    assert hand.fingertips == (f"left{tip}", f"right{tip}")
    assert [t.reason for t in hand.describe().fingertips] == [
        'its name ends in "tip"' if tip.lower().endswith("tip") else "its name says that it is a fingertip"
    ] * 2


@pytest.mark.parametrize("name", ["_stipulated", "_tipped", "_pad_link", "_tooltips"])
def test_names_that_only_hold_the_letters_are_not(name):
    """Frames without geometry at the end of a finger are candidates on their own account."""
    found = hl.describe_urdf(gripper(tip=name)).fingertips
    assert all("without geometry" in tip.reason for tip in found)


def test_bars_of_a_linkage_are_no_fingertips():
    """A bar is pinned to the finger: its end is at one point of it in every posture."""
    hand = hl.Hand.from_urdf(gripper(), joint_stiffness=3.0)
    assert hand.fingertips == ("left_finger", "right_finger") == hl.Hand.from_urdf(
        gripper(bars=False), joint_stiffness=3.0
    ).fingertips  # fmt: skip


def test_a_third_finger_that_follows_is_one():
    """Not pinned to anything, although its joint follows the same motor as the others."""
    third = link("third", "palm", "0 0.05 0.02", 0.09, 0.7)
    text = gripper().replace("</robot>", third + "</robot>")
    assert hl.Hand.from_urdf(text, joint_stiffness=3.0).fingertips == ("left_finger", "right_finger", "third")


LOOP = """<mujoco><worldbody><body name="palm"><geom type="box" size=".05 .02 .01"/>
{sides}</body></worldbody><equality>{pins}</equality>
<actuator><position joint="right_knuckle" kp="3"/><position joint="left_knuckle" kp="3"/></actuator></mujoco>"""
SIDE = """<body name="{n}_knuckle" pos="{x} 0 .02"><joint name="{n}_knuckle" axis="0 1 0" range="-40 40" stiffness="1"/>
<geom type="capsule" size=".004" fromto="0 0 0 0 0 .05"/>
<body name="{n}_finger" pos="0 0 .05"><joint name="{n}_finger" axis="0 1 0" range="-40 40" stiffness="1"/>
<geom type="capsule" size=".005" fromto="0 0 0 0 0 .06"/></body></body>
<body name="{n}_bar" pos="{y} 0 .02"><joint name="{n}_bar" axis="0 1 0" range="-40 40" stiffness="1"/>
<geom type="capsule" size=".003" fromto="0 0 0 0 0 .05"/></body>"""


@pytest.mark.parametrize("order", ['body1="{n}_bar" body2="{n}_finger"', 'body1="{n}_finger" body2="{n}_bar"'])
def test_bars_that_a_constraint_pins_are_no_fingertips(order):
    pytest.importorskip("mujoco")
    anchor = "0 0 0.05" if '1="{n}_bar' in order else "{w} 0 0"
    sides = pins = ""
    for n, way in (("right", 1), ("left", -1)):
        sides += SIDE.format(n=n, x=0.03 * way, y=0.015 * way)
        pins += f'<connect {order.format(n=n)} anchor="{anchor.format(w=-0.015 * way)}"/>'
    hand = hl.Hand.from_mjcf(LOOP.format(sides=sides, pins=pins))
    assert hand.fingertips == ("left_finger", "right_finger")


def test_a_range_narrowed_to_a_point_is_serious_and_has_no_minus_zero():
    """A follower with multiplier -1 and its leader's range: the gripper cannot move at all."""
    ends = 'lower="-0.8" upper="0.8"', 'lower="0" upper="0.9"'
    text = gripper(bars=False).replace(*ends)
    (doubt,) = (d for d in hl.audit_urdf(text).serious if d.about == "range")
    assert doubt.joint == "right_knuckle_j"
    assert "it cannot move: its range [0, 0.9] is narrowed to 0 by the limits of" in doubt.what
    assert "-0" not in doubt.what
    some = gripper(bars=False).replace(ends[0], 'lower="-0.5" upper="0.8"')
    assert [d.severity for d in hl.audit_urdf(some) if "is narrowed to" in d.what] == ["minor"]


@pytest.mark.parametrize("ends", ['lower="0.3" upper="0.3"', 'lower="-0." upper="0"'])
def test_a_range_that_is_written_as_a_point_is_serious(ends):
    text = gripper(bars=False).replace('lower="-0.8" upper="0.8"', ends, 1)
    (doubt,) = (d for d in hl.audit_urdf(text) if d.about == "range" and "both limits are" in d.what)
    assert (doubt.joint, doubt.severity) == ("right_knuckle_j", "serious")
    assert "-0" not in doubt.what
