"""MJCF files of scenes: what is the hand, and what stands around it."""

from __future__ import annotations

import pytest

import handlcp as hl

pytest.importorskip("mujoco")

FINGERS = """<body name="{p}l" pos="0.03 0 0.01"><joint name="{p}lj" axis="0 -1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05" mass="0.01"/></body>
<body name="{p}r" pos="-0.03 0 0.01"><joint name="{p}rj" axis="0 1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05" mass="0.01"/></body>"""
PALM = '<body name="{p}palm" pos="{at}">{free}<geom type="box" size=".05 .02 .01" mass="0.1"/>' + FINGERS + "</body>"
MOTORS = '<position joint="{p}lj" kp="30" forcerange="-1 1"/><position joint="{p}rj" kp="30" forcerange="-1 1"/>'
CUBE = '<body name="cube" pos="0 0 0.06"><freejoint/><geom type="box" size=".015 .015 .015" mass="0.1"/></body>'
TABLE = '<body name="table" pos="0 0 -0.1"><geom type="box" size=".5 .5 .01"/></body>'
DOOR = '<body name="door" pos="1 0 0"><joint name="hinge"/><geom type="box" size=".1 .1 .1" mass="3"/></body>'
GROUND = '<geom type="plane" size="1 1 .1"/><geom type="box" size=".2 .2 .01" pos="0 0 -0.2"/><light pos="0 0 1"/>'


def scene(*parts, free="", robots=("",), more=""):
    palms = "".join(PALM.format(p=p, at=f"{2 * i} 0 0", free=free) for i, p in enumerate(robots))
    motors = "".join(MOTORS.format(p=p) for p in robots)
    world = "".join(parts)
    return f"<mujoco><worldbody>{world}{palms}</worldbody>{more}<actuator>{motors}</actuator></mujoco>"


def said(text):
    return " | ".join(d.what for d in hl.audit_urdf(text) if d.about in ("scene", "robots"))


@pytest.mark.parametrize("free", ["", "<freejoint/>"])
def test_a_hand_in_a_scene_is_the_hand_without_it(free):
    """Its links, joints and mass; a base that floats stays a hand's."""
    alone = hl.describe_urdf(scene(free=free))
    among = hl.describe_urdf(scene(GROUND, TABLE, CUBE, DOOR, free=free))
    assert among.mass == alone.mass == pytest.approx(0.12)
    assert [link.name for link in among.links] == [link.name for link in alone.links] == ["world", "palm", "l", "r"]
    assert [j.name for j in among.joints] == ["lj", "rj"]
    assert among.size == pytest.approx(alone.size)


def test_what_is_left_out_of_a_scene_is_said():
    what = said(scene(GROUND, TABLE, CUBE, DOOR))
    for part in ("cube (free to move)", "table (without a joint)", "door (that no actuator drives)", "the world body"):
        assert part in what
    assert not said(scene())


def test_a_link_of_the_scene_can_be_asked_for():
    """By base: another part of the file is read then."""
    wall = f'<body name="wall"><geom type="box" size=".1 .1 .1"/>{DOOR}</body>'
    hand = hl.describe_urdf(scene(CUBE, wall), base="wall")
    assert [j.name for j in hand.joints] == ["hinge"]
    assert not [d for d in hand.audit if d.about == "scene"]


def test_what_ties_the_hand_to_its_scene_is_no_doubt():
    """A hand that a mocap body carries by a weld."""
    carrier = '<body name="carrier" mocap="true"><geom type="sphere" size=".01" contype="0" conaffinity="0"/></body>'
    weld = '<equality><weld body1="carrier" body2="palm"/></equality>'
    audit = hl.audit_urdf(scene(carrier, free="<freejoint/>", more=weld))
    assert not [d for d in audit if "constraint" in d.what]
    assert "carrier (free to move)" in said(scene(carrier, free="<freejoint/>", more=weld))


def test_fingers_that_stand_in_the_world_keep_it_as_their_palm():
    world = '<geom type="box" size=".05 .02 .01" mass="0.1"/>' + FINGERS.format(p="")
    text = f"<mujoco><worldbody>{world}{CUBE}</worldbody><actuator>{MOTORS.format(p='')}</actuator></mujoco>"
    hand = hl.Hand.from_mjcf(text, ["l", "r"])
    assert [s.name for s in hand.link_surfaces] == ["world", "l", "r"]
    assert "cube" in said(text)


def test_two_hands_in_one_world_are_a_serious_doubt_until_one_is_named():
    text = scene(CUBE, robots=("a_", "b_"))
    (doubt,) = (d for d in hl.audit_urdf(text).serious if d.about == "robots")
    assert "a_palm, b_palm" in doubt.what
    one = hl.Hand.from_mjcf(text, ["b_l", "b_r"], base="b_palm")
    assert one.joint_names == ("b_lj", "b_rj")
    assert not [d for d in one.audit() if d.about in ("robots", "scene")]


def test_two_arms_of_a_urdf_are_a_serious_doubt_and_fingers_are_none():
    def chain(name, count):
        links = "".join(f'<link name="{name}{k}"/>' for k in range(count))
        joints = "".join(
            f'<joint name="{name}_j{k}" type="revolute"><parent link="{f"{name}{k - 1}" if k else "stand"}"/>'
            f'<child link="{name}{k}"/><axis xyz="0 1 0"/><origin xyz="0 0 0.1"/>'
            '<limit lower="-1" upper="1" effort="3" velocity="1"/></joint>'
            for k in range(count)
        )
        return links + joints

    def doubts(count):
        text = f'<robot name="r"><link name="stand"/>{chain("a", count)}{chain("b", count)}</robot>'
        return [d.what for d in hl.audit_urdf(text).serious if d.about == "robots"]

    assert doubts(5) == []
    assert doubts(6) == ["the file holds several robots, which are read as one hand: a0, b0"]
