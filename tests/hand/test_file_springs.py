"""Springs of joints that an MJCF file states: a part of the stiffness that no servo commands, beside MuJoCo."""

import numpy as np
import pytest

import handlcp as hl
from tests.hand.test_servos import FINGER
from tests.support.hand import servos_of

mujoco = pytest.importorskip("mujoco")

K, REST = 0.8, -0.4  # N·m/rad, rad: the spring of joint a
SPRUNG = f' stiffness="{K}" springref="{REST}"'
SERVOS = '<actuator><position name="sa" joint="a" kp="3"/><position name="sb" joint="b" kp="2"/>{}</actuator>'
ALL = SERVOS.format('<position name="sc" joint="c" kp="1"/>')


def text(a=SPRUNG, c="", more=ALL):
    return FINGER.format(more=more, a=a).replace('name="c"', f'name="c"{c}')


def finger(a=SPRUNG, c="", more=ALL, **arguments):
    return hl.Hand.from_mjcf(text(a, c, more), **arguments)


def doubts(hand):
    return [d for d in hand.audit() if d.about == "spring"]


def test_a_spring_adds_to_the_kp_of_its_joint_and_of_the_joint_that_this_follows():
    np.testing.assert_allclose(finger().joint_stiffness, np.diag([3.0 + K, 2.0, 1.0]), rtol=1e-12)
    follows = '<equality><joint joint1="a" joint2="b" polycoef="0.1 0.5 0 0 0"/></equality>'
    both = finger(more=ALL + follows).joint_stiffness
    np.testing.assert_allclose(both, np.diag([2.0 + 0.25 * (3.0 + K), 1.0]), rtol=1e-12)
    np.testing.assert_allclose(finger(joint_stiffness=2.0).joint_stiffness, 2.0 * np.eye(3))
    assert finger().scale_stiffness(2.0).joint_stiffness[0, 0] == pytest.approx(2.0 * (3.0 + K))


def test_a_loaded_finger_stands_in_mujoco_where_its_joints_give_way_to():
    """Servos hold a posture, spring included, and are told to go on by δq; under a force at its tip the finger stands
    at δq - C τ in MuJoCo's own forces, wherever its spring is at rest. The servo of joint a pulls with what we say, and
    with what holds the spring in the grasp's posture.
    """
    q, told = np.array([0.3, 0.4, 0.2]), np.array([0.1, 0.05, 0.2])
    force = np.array([0.5, 0.0, -0.8])
    hand, model = finger(), mujoco.MjModel.from_xml_string(text())
    model.opt.gravity[:] = 0.0
    data, kp = mujoco.MjData(model), np.array([3.0, 2.0, 1.0])
    held = np.array([K * (q[0] - REST), 0.0, 0.0])
    # kp (u - q) = K δq where nothing pushes: servos are told q, what holds the spring, and what commands δq
    data.ctrl[:] = q + (held + hand.joint_stiffness @ told) / kp
    site, J = model.site("a_tip").id, np.zeros((3, 3))
    moved = q + told
    for _ in range(50):  # the force acts where the tip is: its arms are those of the end
        data.qpos[:] = moved
        mujoco.mj_forward(model, data)
        mujoco.mj_jacSite(model, data, J, None, site)
        moved = q + told - hand.stiffness.deflection(-J.T @ force)
    torque = -J.T @ force  # that the joints hold
    np.testing.assert_allclose(data.qfrc_actuator + data.qfrc_passive, torque, atol=1e-9)
    np.testing.assert_allclose(hand.stiffness.actuator_torque(torque, told), data.qfrc_actuator - held, atol=1e-9)


def test_a_joint_with_a_spring_alone_gives_way_and_is_commanded_by_nothing():
    hand = finger(c=' stiffness="0.3"', more=SERVOS.format(""))
    np.testing.assert_allclose(hand.joint_stiffness, np.diag([3.0 + K, 2.0, 0.3]), rtol=1e-12)
    np.testing.assert_allclose(abs(hand.stiffness.command_directions), np.eye(3)[:, :2], atol=1e-12)
    np.testing.assert_allclose(hand.stiffness.unmade_torque(np.array([0.1, 0.1, 0.2])), [0.0, 0.0, 0.06], atol=1e-12)
    assert not hand.stiffness.unmade_torque(np.array([0.1, 0.1, 0.0])).any()
    assert "stiffness of c: springs of joints" in str(hand.describe())
    (doubt,) = doubts(hand)
    assert (doubt.joint, doubt.what[:17]) == ("c", "no actuator turns")
    with pytest.raises(hl.InputError, match=r"joint_stiffness.*none"):
        finger(c=' stiffness="0.3"', more="")


ONE = '<actuator><position joint="a" kp="3"/><position tendon="both" kp="4"/></actuator>'


def test_springs_of_joints_hold_what_a_servo_s_tendon_leaves_free():
    """A finger of one motor: K = K_p + kp a aᵀ, and no motion is taken to be stiffer than the file has it."""
    sprung = text(c=' stiffness="0.2"', more=ONE).replace('name="b"', 'name="b" stiffness="0.1"')
    hand = hl.Hand.from_mjcf(sprung)
    arms = np.array([0.0, 1.0, 0.5])
    expected = np.diag([3.0 + K, 0.1, 0.2]) + 4.0 * np.outer(arms, arms)
    np.testing.assert_allclose(hand.joint_stiffness, expected, rtol=1e-12)
    assert not servos_of(hand).widened
    assert hand.stiffness.command_directions.shape == (3, 2)
    assert not hand.stiffness.unmade_torque(hand.stiffness.command_directions @ [0.1, 0.2]).any()
    assert not [d for d in hand.audit() if d.about == "tendon"]


@pytest.mark.parametrize(("limit", "said"), [(2.0, True), (5.0, False), (None, False)])
def test_a_spring_in_no_torque_that_takes_a_tenth_of_the_limit_is_doubted(limit, said):
    """One servo pulls b and c, and turns neither on its own. In the middle of the range, 0 rad, the spring of c pulls
    with K times its rest angle, 0.32 N·m.
    """
    sprung = text("", SPRUNG, ONE).replace('name="b"', 'name="b" stiffness="0.1"')
    hand = hl.Hand.from_mjcf(sprung, torque_limits=None if limit is None else {"c": limit})
    assert bool(doubts(hand)) is said
    assert hand.stiffness.parallel_spring_torque(hand.neutral) is None
    if said:
        assert doubts(hand)[0].joint == "c"
        assert "16 % of what drives give" in doubts(hand)[0].what
        assert not doubts(finger(joint_stiffness=1.0, torque_limits=limit))
        assert not doubts(finger(torque_limits={"a": limit}))  # in the torques


# ---------------------------------------------------------------- a servo pulls against the spring of its joint
KP, OWN, AWAY, LONG = 5.0, 1.5, 0.4, 0.08  # N·m/rad, N·m/rad; rad: springs open the fingers; m
BOTH = OWN * AWAY  # N·m that servos hold against springs where the fingers touch
ASIDE = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def levers(rest=AWAY, squeeze=4e-3, **arguments):
    """A box between two fingers of one joint. rest : where springs are at rest; None: servos alone, as stiff in all."""
    bodies, spring = "", "" if rest is None else f'stiffness="{OWN}" springref="{{}}"'
    for name, s in (("left", -1.0), ("right", 1.0)):
        own = spring.format(s * (rest or 0.0))
        bodies += f"""<body name="{name}" pos="{0.015 * s} 0 0"><joint name="{name}" axis="0 1 0" range="-1 1" {own}/>
          <geom type="capsule" size=".004" fromto="0 0 0 0 0 .06"/><site name="{name}_tip" pos="0 0 {LONG}"/></body>"""
    kp = KP + OWN if rest is None else KP
    servos = "".join([f'<position name="s_{n}" joint="{n}" kp="{kp}" forcerange="-9 9"/>' for n in ("left", "right")])
    text = f"""<mujoco><compiler angle="radian" autolimits="true"/><worldbody>{bodies}</worldbody>
      <actuator>{servos}</actuator></mujoco>"""
    hand = hl.Hand.from_mjcf(text, ["left_tip", "right_tip"], tip_radius=0.005, pad_flexibility=1e-4, **arguments)
    box = hl.Box(0.02, placement=(0, 0, LONG), mass=0.02)
    return hand.at([0.0, 0.0]).grasp(box, friction=0.8, squeeze=squeeze)


def test_a_servo_holds_the_contacts_and_its_joints_spring():
    """τ = Jᵀ f + k (q - θ), in one solve and on a path; forces, motion and energy stay as they are without."""
    sprung, plain = levers(), levers(None)
    one, without = sprung.solve(), plain.solve()
    np.testing.assert_allclose(one.torques - without.torques, [BOTH, -BOTH], rtol=1e-12)
    np.testing.assert_allclose(one.forces, without.forces, atol=1e-12)
    path, bare = sprung.follow(), plain.follow()
    held = OWN * (path.steps.q - np.array([-AWAY, AWAY]))
    np.testing.assert_allclose(path.steps.torques, bare.steps.torques + held, atol=1e-12)
    np.testing.assert_allclose(path.steps.pulled, path.steps.torques, atol=1e-12)
    np.testing.assert_allclose(path.solution.torques, path.steps.torques[-1], rtol=1e-9)
    for name in ("forces", "work", "stored", "displacement"):
        np.testing.assert_allclose(getattr(path.steps, name), getattr(bare.steps, name), atol=1e-12)
    fixed = sprung.follow(geometry="fixed")
    np.testing.assert_allclose(fixed.steps.torques[0], [BOTH, -BOTH], rtol=1e-12)
    assert levers(0.0).solve().torques == pytest.approx(without.torques)  # at rest where the fingers touch


@pytest.mark.parametrize("geometry", ["fixed", "followed"])
def test_limits_are_for_what_the_servo_gives(geometry):
    """As with limits that are lower by what springs take; on the way where the joints stand then."""
    found = levers(torque_limits=BOTH + 0.5).load_limit(ASIDE, geometry=geometry)
    lower = levers(None, torque_limits=0.5).load_limit(ASIDE, geometry=geometry)
    assert found.factor > 1.0
    assert [c.kind for c in found.binds] == [c.kind for c in lower.binds] == ["torque"]
    if geometry == "fixed":
        assert found.factor == pytest.approx(lower.factor, rel=1e-9)
    else:
        there = levers(None).follow(found.load).steps
        gives = there.torques[-1] + OWN * (there.q[-1] - np.array([-AWAY, AWAY]))
        assert abs(gives).max() == pytest.approx(BOTH + 0.5, rel=1e-6)
    assert levers(torque_limits=BOTH + 0.2).check().word == "OVER LIMIT"
    assert levers(None, torque_limits=BOTH + 0.2).check().word == "HELD"


@pytest.mark.long
def test_motors_are_sized_with_what_springs_take():
    needs, bare = levers().required_torque(), levers(None).required_torque()
    np.testing.assert_allclose(needs.torque - bare.torque, BOTH, rtol=0.01)


def test_mujoco_has_the_same_torque_of_the_servos():
    from handlcp.simulator import simulate, to_mujoco

    grasp = levers()
    truth, path = simulate(grasp), grasp.follow()
    np.testing.assert_allclose(path.steps.torques[-1], truth.torques, rtol=2e-3)
    np.testing.assert_allclose(path.solution.forces_world, truth.forces_world, atol=0.01)
    model = mujoco.MjModel.from_xml_string(to_mujoco(grasp)[0])
    at = [model.joint(name).id for name in grasp.state.hand.joint_names]
    np.testing.assert_allclose(model.jnt_stiffness[at], OWN)
    np.testing.assert_allclose(model.qpos_spring[model.jnt_qposadr[at]], [-AWAY, AWAY])


def test_explain_lists_springs_of_the_file_those_beside_servos_apart():
    hand = finger(c=' stiffness="0.3"', more=SERVOS.format(""))
    grasp = hand.at(hand.neutral).grasp(hl.Sphere(0.02, placement=(0.03, 0, 0.12), mass=0.1), max_gap=1.0)
    lines = {line.title: line for line in grasp.explain().effects if line.on}
    assert lines["springs at joints"].why == "at c, up to 0.3 N·m/rad: part of K"
    assert "springs beside actuators" in lines
    assert all(line.answers == "" for line in lines.values()), "every answer counts them"
    assert "springs at joints" not in str(levers(None).explain())
