"""What a hand says of itself, of its file, and of what a loading counts."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand.library import psyonic, urdf


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


# ---------------------------------------------------------------- what files state of drives besides: read, said
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
    assert facts(hand, "finger_3_proximal").properties.reduction is None
    assert stated(hand)["reduction"].values == {"finger_1_proximal": 50.0, "finger_2_proximal": 35.5}


def test_soft_limits_that_are_narrower_are_said_and_not_applied():
    soft = '<safety_controller soft_lower_limit="-0.2" soft_upper_limit="1.0" k_velocity="1"/>'
    hand, plain = hand_of(soft), hand_of()
    assert facts(hand).properties.soft_limits == (-0.2, 1.0)
    assert (hand.lower == plain.lower).all()
    assert (hand.upper == plain.upper).all()
    (doubt,) = (d for d in hand.audit() if "soft limits" in d.what)
    assert (doubt.joint, doubt.about) == ("finger_1_proximal", "range")
    assert "soft limits: -0.2 to 1 rad, 1 joint" in str(hand.describe())


@pytest.mark.parametrize("end", ["9", "0", None], ids=["wider", "not filled in", "none"])
def test_soft_limits_that_leave_out_nothing_are_no_doubt(end):
    ends = "" if end is None else f'soft_lower_limit="-{end}" soft_upper_limit="{end}"'
    assert not [d for d in hand_of(f'<safety_controller {ends} k_velocity="1"/>').audit() if "soft" in d.what]


@pytest.mark.parametrize(
    ("about", "number"), [("friction", "-1"), ("friction", "much"), ("friction", "0.5"), ("gear", "0")]
)
def test_what_cannot_be_is_doubted(about, number):
    """Friction below 0, a word, more than half of the motor; a reduction of 0."""
    friction = f'<dynamics friction="{number}"/>'
    text = stating(friction) if about == "friction" else stating("", GEARS.replace(">50<", f">{number}<"))
    (doubt,) = (d for d in hl.audit_urdf(text) if d.about == about)
    assert doubt.joint == "finger_1_proximal"


def test_a_reduction_that_is_no_number_is_doubted_and_not_described():
    hand = hand_of("", GEARS.replace(">50<", ">fifty<"))
    assert stated(hand)["reduction"].values == {"finger_2_proximal": 35.5}
    for audit in (hand.audit(), hl.audit_urdf(stating("", GEARS.replace(">50<", ">fifty<")))):
        (doubt,) = (d for d in audit if d.about == "gear")
        assert (doubt.joint, doubt.what.endswith("is no number")) == ("finger_1_proximal", True)


@pytest.mark.parametrize("friction", ["-0.1", "much", "nan"])
def test_friction_that_no_joint_has_is_refused_with_the_name_of_the_joint(friction):
    with pytest.raises(hl.URDFError, match=f"≥ 0 in <dynamics friction=…> of .*finger_1_proximal', got '{friction}"):
        hand_of(f'<dynamics friction="{friction}"/>')


def test_every_number_says_where_it_came_from():
    hand = hand_of(torque_limits={"finger_1_distal": 0.3}, pad_flexibility={"finger_1_tip": 1e-4})
    rows = hand.describe().origins
    sources = {(row.number, name): row.source for row in rows for name in row.of}
    said = {
        ("torque limit", "finger_1_distal"): "given",
        ("torque limit", "finger_1_proximal"): "<limit effort>",
        ("range", "finger_1_proximal"): "<limit lower upper>",
        ("stiffness", "finger_1_proximal"): "given",
        ("pad", "finger_1_tip"): "given",
        ("pad", "finger_2_tip"): "default: rigid",
        ("shape of a tip", "finger_1_tip"): "given",
    }
    assert said.items() <= sources.items()
    assert "mass" in {row.number for row in rows}


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


NAMED = TEXT.replace("finger_1", "thumb").replace("finger_2", "index").replace("finger_3", "middle")
SIDED = TEXT.replace("finger_1", "left_jaw").replace("finger_2", "right_jaw")


@pytest.mark.parametrize(
    ("text", "joints"),
    [
        (with_effort("finger_2_proximal", 0.2), ["finger_2_proximal"]),
        (with_effort("left_jaw_distal", 0.1, SIDED), ["left_jaw_distal, right_jaw_distal"]),
        (TEXT, []),  # proximal and distal have other motors
        (with_effort("finger_2_proximal", 0.79), []),
        (with_effort("thumb_proximal", 3.0, NAMED), []),
        (SIDED, []),
    ],
    ids=["a finger", "a side", "along a finger", "nearly the same", "a thumb", "equal sides"],
)
def test_what_is_unlike_its_like_is_doubted(text, joints):
    assert unlike(text) == joints


@pytest.mark.parametrize("name", ["allegro", "psyonic"])
def test_hands_whose_like_joints_are_alike_raise_no_alarm(name):
    assert not [d for d in hl.example_hand(name).audit() if d.about == "unlike"]


# ---------------------------------------------------------------- `explain()` lists all that a loading counts of
CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
FOLLOWED = "followed loadings alone"
ARMS = {f"cable_{k}": {f"finger_{k}_proximal": 0.012, f"finger_{k}_distal": 0.008} for k in (1, 2, 3)}


def grasp(**more):
    hand = hl.example_hand("three_finger", **({"joint_stiffness": 6.0} | more))
    return hand.at(hand.close_on(CUBE)).grasp(CUBE, friction=0.8, squeeze=0.009)


def lines(g):
    return {line.title: line for line in g.explain().effects if line.on}


RUBBING = {
    "joint friction": {"joint_friction": 0.04},
    "motor friction": {"motors": hl.Motor(0.012, 0.04, reduction=50, friction=0.04)},
    "tendon friction": {"joint_stiffness": hl.Tendons(ARMS, 2e4, 4.0, friction=0.3)},
}


@pytest.mark.parametrize("title", RUBBING)
def test_friction_that_loadings_count_and_a_solve_does_not_is_listed_so(title):
    rubs = grasp(**RUBBING[title])
    found = lines(rubs)[title]
    assert found.answers == FOLLOWED
    said = " ".join(str(rubs.explain()).split())
    assert f"on {title}: " in said
    assert "check, follow, load_limit" in said
    plain = grasp(joint_stiffness=hl.Tendons(ARMS, 2e4, 4.0)) if "tendon" in title else grasp()
    assert title not in lines(plain)
    one, other = (g.solve().forces for g in (rubs, plain))
    assert abs(one - other).max() < 1e-9 * abs(other).max(), "one solve does not count it"
    ends = [g.follow(order="squeeze", steps=8).steps.forces[-1] for g in (rubs, plain)]
    assert abs(ends[0] - ends[1]).max() > 0.02 * abs(ends[1]).max(), "a loading does"


def test_an_effect_of_one_solve_alone_is_listed_so():
    bent = grasp().replace(effects=[hl.GeometricStiffness()])
    assert lines(bent)["geometric stiffness"].answers == "one solve alone"
    assert all(line.answers == "" for line in grasp().explain().effects if line.on)
    assert grasp().explain().notes == ()
