"""Actuators whose limits are those of several joints, or of one that follows: UNDECIDED where torque decides."""

from __future__ import annotations

import pytest

import handlcp as hl

pytest.importorskip("mujoco")

HAND = """<mujoco><worldbody><body name="palm"><geom type="box" size=".05 .02 .01"/>
<body name="l" pos="0.04 0 0.01"><joint name="lj" axis="0 -1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05"/><site name="l_tip" pos="0 0 .05"/></body>
<body name="m" pos="0.04 0.03 0.01"><joint name="mj" axis="0 -1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05"/><site name="m_tip" pos="0 0 .05"/></body>
<body name="r" pos="-0.04 0 0.01"><joint name="rj" axis="0 1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05"/><site name="r_tip" pos="0 0 .05"/></body></body></worldbody>
{rest}</mujoco>"""
TENDONS = """<tendon><fixed name="sum"><joint joint="lj" coef="1"/><joint joint="rj" coef="1"/></fixed>
<fixed name="diff"><joint joint="lj" coef="1"/><joint joint="rj" coef="-1"/></fixed></tendon>"""
THIRD = '<position name="third" joint="mj" kp="30" forcerange="-1 1"/>'
ONE, TWO = (f'<position name="{n}" joint="{j}" kp="30" forcerange="-1 1"/>' for n, j in (("one", "lj"), ("two", "rj")))
EACH = f"<actuator>{THIRD}{ONE}{TWO}</actuator>"
DIFFERENTIAL = f"""{TENDONS}<actuator>{THIRD}<position name="one" tendon="sum" kp="30" forcerange="-1 1"/>
<position name="two" tendon="diff" kp="30" forcerange="-1 1"/></actuator>"""
ONE_PULLS_TWO = (
    f"""{TENDONS}<actuator>{THIRD}<position name="one" tendon="sum" kp="30" forcerange="-1 1"/></actuator>"""
)
FOLLOWS = '<equality><joint joint1="lj" joint2="rj"/></equality>'
SPLIT = f'{TENDONS}{FOLLOWS}<actuator>{THIRD}<position name="one" tendon="sum" kp="30" forcerange="-1 1"/></actuator>'
BOX = hl.Box((0.07, 0.08, 0.04), (0, 0.01, 0.05), mass=0.05)


def hand(rest, **more):
    return hl.Hand.from_mjcf(HAND.format(rest=rest), ["l_tip", "m_tip", "r_tip"], tip_radius=0.006, **more)


def doubts(hand):
    return [d for d in hand.audit().serious if d.about == "shared limit"]


@pytest.mark.parametrize(
    ("rest", "actuators", "joints"),
    [(DIFFERENTIAL, "(one, two)", "lj, rj"), (SPLIT, "(one)", "rj"), (f"{FOLLOWS}{EACH}", "(one)", "rj")],
    ids=["a differential", "one actuator for both", "the follower driven"],
)
def test_the_actuators_are_named_and_the_verdict_is_undecided_until_limits_are_passed(rest, actuators, joints):
    """HELD at 78 % "of 2 N·m" where a motor of 1 N·m needs 1.56; 50 N read where 100 are right."""
    made = hand(rest, joint_stiffness=30.0)
    (doubt,) = doubts(made)
    assert actuators in doubt.what
    assert doubt.joint == joints
    given = made.replace(torque_limits=dict.fromkeys(made.joint_names, 1.0))
    assert not doubts(given)
    if len(made.joint_names) < 3:  # both fingers move as one: they cannot be closed one by one
        posture = made.neutral
        assert made.at(posture).hand.doubts == made.doubts
        return
    words = []
    for one in (made, given):
        grasp = one.at(one.close_on(BOX)).grasp(BOX, friction=0.8, grip_force=3.0)
        words.append((grasp.check().word, grasp.solve().verdict.word))
        (reason, *_) = (*grasp.check().about("limit_shared"), None)
        assert (reason is None) == (one is given)
    assert words == [("UNDECIDED", "UNDECIDED"), ("HELD", "HELD")]


@pytest.mark.parametrize(
    "rest",
    [EACH, ONE_PULLS_TWO, DIFFERENTIAL.replace('forcerange="-1 1"', "")],
    ids=["one for each", "one alone for two", "without limits"],
)
def test_limits_that_a_joint_has_on_its_own_are_no_doubt(rest):
    """One actuator of several joints pulls no harder than the joint asks that asks for most; "tendon" doubts it."""
    assert not doubts(hand(rest, joint_stiffness=30.0))


def test_a_limit_of_the_tendon_itself_counts():
    """Actuatorfrcrange of a tendon, where it is below what its actuators pull with."""
    plain = ONE_PULLS_TWO.replace('<joint joint="rj" coef="1"/></fixed>\n', "</fixed>", 1)
    limits = []
    for text in (plain, plain.replace('name="sum"', 'name="sum" actuatorfrcrange="-0.4 0.4"')):
        made = hand(text, joint_stiffness=3.0)
        limits.append(float(made.torque_limits[made.joint_names.index("lj")]))
    assert limits == [1.0, 0.4]


def test_a_hand_that_does_not_hold_is_not_held_whatever_its_limits():
    made = hand(DIFFERENTIAL, joint_stiffness=30.0)
    grasp = made.at(made.close_on(BOX)).grasp(BOX, friction=0.01, grip_force=0.5, wrench=(0, 0, -30, 0, 0, 0))
    assert grasp.check().word == "NOT HELD"
