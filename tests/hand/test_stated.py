"""What files state of drives besides: read, said, doubted where it cannot be; and where every number is from."""

from __future__ import annotations

import pytest

import handlcp as hl
from handlcp.hand.library import urdf

TEXT = urdf("three_finger").read_text(encoding="utf-8")
GEARS = """
<transmission name="t1"><type>transmission_interface/SimpleTransmission</type>
  <joint name="finger_1_proximal"><hardwareInterface>EffortJointInterface</hardwareInterface></joint>
  <actuator name="m1"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>
<ros2_control name="hand" type="system"><joint name="finger_2_proximal"><command_interface name="effort"/></joint>
  <transmission name="t2"><plugin>transmission_interface/SimpleTransmission</plugin>
    <actuator name="m2" role="a"/><joint name="finger_2_proximal" role="j">
      <mechanical_reduction>35.5</mechanical_reduction></joint></transmission></ros2_control>
"""


def stating(inside="", beside="", joint="finger_1_proximal"):
    """The three-finger hand with more in one joint, and beside all."""
    at = TEXT.index(">", TEXT.index(f'<joint name="{joint}"')) + 1
    return (TEXT[:at] + inside + TEXT[at:]).replace("</robot>", f"{beside}</robot>")


def hand_of(*args, **more):
    return hl.Hand.from_urdf(stating(*args), joint_stiffness=6.0, tip_radius=0.008, **more)


def facts(hand, joint="finger_1_proximal"):
    return {f.name: f for f in hand.kinematics.facts}[joint]


def stated(hand):
    return {row.what: row for row in hand.describe().stated}


def test_friction_of_a_urdf_is_a_fact_and_changes_no_answer():
    plain, rubbing = hand_of(), hand_of('<dynamics damping="0.1" friction="0.05"/>')
    assert facts(rubbing).properties.friction == 0.05
    assert facts(plain).properties.friction == 0.0
    row = stated(rubbing)["dry friction"]
    assert row.values == {"finger_1_proximal": 0.05}
    cube = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    held = [h.at(h.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005).solve() for h in (plain, rubbing)]
    assert (held[0].forces == held[1].forces).all()


def test_reductions_are_read_of_transmissions_and_of_ros2_control():
    hand = hand_of("", GEARS)
    assert facts(hand).properties.reduction == 50.0
    assert facts(hand, "finger_2_proximal").properties.reduction == 35.5
    assert facts(hand, "finger_3_proximal").properties.reduction is None
    assert stated(hand)["reduction"].values == {"finger_1_proximal": 50.0, "finger_2_proximal": 35.5}


def test_a_hand_that_is_cut_out_keeps_the_reductions_of_its_joints():
    text = stating("", GEARS)
    base = text.split('<link name="')[1].split('"')[0]
    cut = hl.Hand.from_urdf(text, joint_stiffness=6.0, tip_radius=0.008, base=base)
    assert facts(cut).properties.reduction == 50.0


def test_soft_limits_that_are_narrower_are_said_and_not_applied():
    soft = '<safety_controller soft_lower_limit="-0.2" soft_upper_limit="1.0" k_velocity="1"/>'
    hand, plain = hand_of(soft), hand_of()
    assert facts(hand).properties.soft_limits == (-0.2, 1.0)
    assert (hand.lower == plain.lower).all()
    assert (hand.upper == plain.upper).all()
    (doubt,) = (d for d in hand.audit() if "soft limits" in d.what)
    assert (doubt.joint, doubt.about) == ("finger_1_proximal", "range")
    assert "soft limits: -0.2 to 1 rad, 1 joint" in str(hand.describe())


@pytest.mark.parametrize(
    "soft",
    [
        'soft_lower_limit="-9" soft_upper_limit="9" k_velocity="1"',
        'soft_lower_limit="0" soft_upper_limit="0" k_velocity="1"',
        'k_velocity="1"',
    ],
    ids=["wider", "not filled in", "none"],
)
def test_soft_limits_that_leave_out_nothing_are_no_doubt(soft):
    assert not [d for d in hand_of(f"<safety_controller {soft}/>").audit() if "soft" in d.what]


@pytest.mark.parametrize(
    ("inside", "beside", "about"),
    [
        ('<dynamics friction="-1"/>', "", "friction"),
        ('<dynamics friction="much"/>', "", "friction"),
        ('<dynamics friction="0.5"/>', "", "friction"),
        ("", GEARS.replace(">50<", ">0<"), "gear"),
        ("", GEARS.replace(">50<", ">fifty<"), "gear"),
    ],
    ids=["negative friction", "no number", "more than half the motor", "no reduction", "a word"],
)
def test_what_cannot_be_is_doubted(inside, beside, about):
    (doubt,) = (d for d in hl.audit_urdf(stating(inside, beside)) if d.about == about)
    assert doubt.joint == "finger_1_proximal"


def test_a_reduction_that_is_no_number_is_doubted_and_not_described():
    hand = hand_of("", GEARS.replace(">50<", ">fifty<"))
    assert stated(hand)["reduction"].values == {"finger_2_proximal": 35.5}
    (doubt,) = (d for d in hand.audit() if d.about == "gear")
    assert doubt.what.endswith("is no number")


@pytest.mark.parametrize("friction", ["-0.1", "much", "nan"])
def test_friction_that_no_joint_has_is_refused_with_the_name_of_the_joint(friction):
    with pytest.raises(hl.URDFError, match=f"≥ 0 in <dynamics friction=…> of .*finger_1_proximal', got '{friction}"):
        hand_of(f'<dynamics friction="{friction}"/>')


def test_every_number_says_where_it_came_from():
    mapping = {"finger_1_distal": 0.3}
    hand = hand_of(torque_limits=mapping, pad_flexibility={"finger_1_tip": 1e-4})
    rows = [(row.number, row.of, row.source) for row in hand.describe().origins]
    sources = {(number, name): source for number, of, source in rows for name in of}
    assert sources["torque limit", "finger_1_distal"] == "given"
    assert sources["torque limit", "finger_1_proximal"] == "<limit effort>"
    assert sources["range", "finger_1_proximal"] == "<limit lower upper>"
    assert sources["stiffness", "finger_1_proximal"] == "given"
    assert sources["pad", "finger_1_tip"] == "given"
    assert sources["pad", "finger_2_tip"] == "default: rigid"
    assert sources["shape of a tip", "finger_1_tip"] == "given"
    assert {number for number, *_ in rows} >= {"range", "torque limit", "stiffness", "pad", "mass"}


# ---------------------------------------------------------------- MJCF


def test_springs_friction_and_armature_of_an_mjcf_file_are_facts():
    pytest.importorskip("mujoco")
    from tests.hand.test_servos import finger

    hand = finger(a=' stiffness="0.2" springref="0.4" frictionloss="0.03" armature="0.001"')
    found = facts(hand, "a").properties
    assert (found.stiffness, found.rest, found.friction, found.armature) == (0.2, 0.4, 0.03, 0.001)
    assert facts(hand, "b").properties.stiffness == 0.0
    assert hand.joint_stiffness[0, 0] == pytest.approx(3.2)  # kp and the spring
    text = str(hand.describe())
    for words in ("rest of that spring: 0.4 rad", "0.03 N·m, 1 joint (frictionloss", "ignored: nothing"):
        assert words in text
    assert "stiffness of a: kp of position actuators, and springs of joints" in text
    assert "stiffness of b, c: kp of position actuators" in text


# ---------------------------------------------------------------- like joints


def unlike(text):
    hand = hl.Hand.from_urdf(text, joint_stiffness=6.0, tip_radius=0.008)
    return [d.joint for d in hand.audit() if d.about == "unlike"]


def with_effort(joint, effort, text=TEXT):
    at = text.index("effort=", text.index(f'<joint name="{joint}"'))
    end = text.index('"', at + 8)
    return f'{text[:at]}effort="{effort}{text[end:]}'


def test_one_finger_that_is_unlike_the_others_is_doubted():
    assert unlike(with_effort("finger_2_proximal", 0.2)) == ["finger_2_proximal"]


def test_joints_along_a_finger_and_fingers_in_two_kinds_are_not():
    assert unlike(TEXT) == []  # proximal and distal have other motors
    assert unlike(with_effort("finger_2_proximal", 0.79)) == []
    renamed = TEXT.replace("finger_1", "thumb").replace("finger_2", "index").replace("finger_3", "middle")
    assert unlike(with_effort("thumb_proximal", 3.0, renamed)) == []


def test_two_sides_that_differ_are_doubted():
    sided = TEXT.replace("finger_1", "left_jaw").replace("finger_2", "right_jaw")
    assert unlike(sided) == []
    assert unlike(with_effort("left_jaw_distal", 0.1, sided)) == ["left_jaw_distal, right_jaw_distal"]


@pytest.mark.parametrize("name", ["allegro", "g1", "psyonic", "five_finger"])
def test_hands_whose_like_joints_are_alike_raise_no_alarm(name):
    assert not [d for d in hl.example_hand(name).audit() if d.about == "unlike"]
