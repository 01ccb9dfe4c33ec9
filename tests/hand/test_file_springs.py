"""Springs of joints that an MJCF file states: a part of the stiffness that no servo commands, beside MuJoCo."""

from __future__ import annotations

from typing import Any

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


def text(a: str = SPRUNG, c: str = "", more: str = ALL) -> str:
    return FINGER.format(more=more, a=a).replace('name="c"', f'name="c"{c}')


def finger(a: str = SPRUNG, c: str = "", more: str = ALL, **arguments: Any) -> hl.Hand:
    return hl.Hand.from_mjcf(text(a, c, more), **arguments)


def doubts(hand: hl.Hand) -> list[hl.Doubt]:
    return [d for d in hand.audit() if d.about == "spring"]


def test_a_spring_adds_to_the_kp_of_its_joint_and_of_the_joint_that_this_follows() -> None:
    np.testing.assert_allclose(finger().joint_stiffness, np.diag([3.0 + K, 2.0, 1.0]), rtol=1e-12)
    follows = '<equality><joint joint1="a" joint2="b" polycoef="0.1 0.5 0 0 0"/></equality>'
    both = finger(more=ALL + follows).joint_stiffness
    np.testing.assert_allclose(both, np.diag([2.0 + 0.25 * (3.0 + K), 1.0]), rtol=1e-12)
    np.testing.assert_allclose(finger(joint_stiffness=2.0).joint_stiffness, 2.0 * np.eye(3))
    assert finger().stiffer(2.0).joint_stiffness[0, 0] == pytest.approx(2.0 * (3.0 + K))


def test_a_loaded_finger_stands_in_mujoco_where_its_joints_give_way_to() -> None:
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
    np.testing.assert_allclose(hand.stiffness.pulled(torque, told), data.qfrc_actuator - held, atol=1e-9)


def test_a_joint_with_a_spring_alone_gives_way_and_is_commanded_by_nothing() -> None:
    hand = finger(c=' stiffness="0.3"', more=SERVOS.format(""))
    np.testing.assert_allclose(hand.joint_stiffness, np.diag([3.0 + K, 2.0, 0.3]), rtol=1e-12)
    np.testing.assert_allclose(abs(hand.stiffness.commands), np.eye(3)[:, :2], atol=1e-12)
    np.testing.assert_allclose(hand.stiffness.beyond(np.array([0.1, 0.1, 0.2])), [0.0, 0.0, 0.06], atol=1e-12)
    assert not hand.stiffness.beyond(np.array([0.1, 0.1, 0.0])).any()
    assert "stiffness of c: springs of joints" in str(hand.describe())
    (doubt,) = doubts(hand)
    assert (doubt.joint, doubt.what[:17]) == ("c", "no actuator turns")
    with pytest.raises(hl.InputError, match=r"joint_stiffness.*none"):
        finger(c=' stiffness="0.3"', more="")


def test_springs_of_joints_hold_what_a_servo_s_tendon_leaves_free() -> None:
    """A finger of one motor: K = K_p + kp a aᵀ, and no motion is taken to be stiffer than the file has it."""
    one = '<actuator><position joint="a" kp="3"/><position tendon="both" kp="4"/></actuator>'
    sprung = text(c=' stiffness="0.2"', more=one).replace('name="b"', 'name="b" stiffness="0.1"')
    hand = hl.Hand.from_mjcf(sprung)
    arms = np.array([0.0, 1.0, 0.5])
    np.testing.assert_allclose(
        hand.joint_stiffness, np.diag([3.0 + K, 0.1, 0.2]) + 4.0 * np.outer(arms, arms), rtol=1e-12
    )
    assert not servos_of(hand).widened
    assert hand.stiffness.commands.shape == (3, 2)
    assert not hand.stiffness.beyond(hand.stiffness.commands @ [0.1, 0.2]).any()
    assert not [d for d in hand.audit() if d.about == "tendon"]


@pytest.mark.parametrize(("limit", "said"), [(2.0, True), (5.0, False), (None, False)])
def test_a_rest_angle_that_takes_a_tenth_of_the_torque_limit_is_doubted(limit: float | None, said: bool) -> None:
    """In the middle of the range, 0 rad, the spring pulls with K times its rest angle, 0.32 N·m."""
    hand = finger(torque_limits=None if limit is None else {"a": limit})
    assert bool(doubts(hand)) is said
    if said:
        assert doubts(hand)[0].joint == "a"
        assert "16 % of what drives give" in doubts(hand)[0].what
        assert not doubts(finger(joint_stiffness=1.0, torque_limits=limit))
        limited = text(more=ALL.replace('name="sa"', f'name="sa" forcerange="-{limit} {limit}"'))
        assert [d.what for d in hl.audit_urdf(limited) if d.about == "spring"] == [doubts(hand)[0].what]
