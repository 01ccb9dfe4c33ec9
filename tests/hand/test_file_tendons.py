"""Tendons along paths in space that servos of an MJCF file draw in: a hand without a further word is the one made by
hand, and what cannot be had is said.
"""

import pickle

import numpy as np
import pytest

import handlcp as hl
from tests.support.hand import tendons_of

from .test_routed_hands import twenty_text

mujoco = pytest.importorskip("mujoco")

KP, GEAR, PULL, OWN = 3e3, -2.0, 30.0, 0.5  # N/m at the actuator, –, N, N·m/rad
TIPS = [f"finger_{k}_2" for k in range(5)]
NAMES = [f"{size} {side} {k}" for k in range(5) for size in ("long", "short") for side in ("flexor", "extensor")]


def winches(names=NAMES, words=""):
    """A servo for each tendon; a negative gear pulls with positive forces."""
    each = (f'<position name="to {n}" tendon="{n}" kp="{KP}" gear="{GEAR}" {words}/>' for n in names)
    return f"<actuator>{''.join(each)}</actuator>"


def hand_of(more, stiffness=OWN, **arguments):
    joints = f' stiffness="{stiffness}"' if stiffness else ""
    return hl.Hand.from_mjcf(twenty_text(more, joints), TIPS, pad_flexibility=1e-4, **arguments)


def about(hand, words):
    return [d for d in hand.audit() if words in d.what]


def test_a_hand_of_a_file_with_twenty_tendons_is_the_one_made_by_hand():
    """K = K_p + Rᵀ kp gear² R in every posture, and no tendon bears more than its actuator pulls with."""
    text = winches(words=f'forcerange="-5 {PULL}"')
    hand = hand_of(text)
    tendons = hl.Tendons(hl.tendon_routes(twenty_text()), KP * GEAR**2, OWN, limits=abs(GEAR) * PULL)
    by_hand = hand_of("", stiffness=0.0, joint_stiffness=tendons)
    for q in (hand.neutral, np.tile([0.4, 0.6, 0.2], 5)):
        ours, theirs = (tendons_of(h.at(q).hand) for h in (hand, by_hand))
        assert ours.names == theirs.names
        np.testing.assert_allclose(ours.stiffness_matrix, theirs.stiffness_matrix, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(ours.cables.springs, theirs.cables.springs, rtol=1e-12)
        np.testing.assert_array_equal(ours.cables.limits, theirs.cables.limits)
        np.testing.assert_array_equal(ours.cables.pretension, theirs.cables.pretension)
    assert pickle.loads(pickle.dumps(hand)).stiffness.is_from_file


def test_its_stiffness_is_that_of_mujoco_s_own_forces():
    """How joint forces change with the joints at a fixed command, tendons slackened by none."""
    model = mujoco.MjModel.from_xml_string(twenty_text(winches(), f' stiffness="{OWN}"'))
    hand, data, h = hand_of(winches()), mujoco.MjData(model), 1e-5
    q = np.tile([0.3, 0.5, 0.4], 5)
    at = [model.joint(name).qposadr[0] for name in hand.joint_names]

    def forces(q):
        data.qpos[at] = q
        mujoco.mj_forward(model, data)
        return np.array(data.qfrc_actuator[at] + data.qfrc_passive[at])

    data.qpos[at] = q
    mujoco.mj_forward(model, data)
    data.ctrl[:] = data.actuator_length  # no tension here: how arms change does not matter
    K = -np.array([(forces(q + h * e) - forces(q - h * e)) / (2 * h) for e in np.eye(len(q))]).T
    np.testing.assert_allclose(hand.at(q).hand.joint_stiffness, K, atol=1e-6 * abs(K).max())


def test_where_its_numbers_come_from_is_said():
    said = hand_of(winches(words=f'forcerange="-5 {PULL}"'))
    for described in (said.describe(), hl.describe_urdf(twenty_text(winches(), f' stiffness="{OWN}"'))):
        words = "stiffness: kp of position actuators, along their tendons, and springs of joints"
        assert words in " ".join(str(described).split())
        assert [row.name for row in described.tendons] == NAMES
        assert any(d.what.startswith("joint stiffness is kp") for d in described.audit)
    assert "tension limit: forcerange of its actuators" in str(said.describe())
    assert not about(said, "path in space")
    passed = hand_of(winches(), joint_stiffness=1.0)
    assert len(about(passed, "path in space; here each joint has a spring")) == 1
    assert tendons_of(passed.replace(joint_stiffness="file")).is_from_file
    other = hl.Tendons(hl.tendon_routes(twenty_text()), 1e4, OWN)
    assert not tendons_of(hand_of(winches(), joint_stiffness=other)).is_from_file


def test_motors_by_name_of_the_file_s_tendons_are_theirs():
    named = {"long flexor 0": hl.Motor(0.02, 0.06, reduction=500.0), "joint_4_0": hl.Motor(0.3)}
    later = hand_of(winches()).replace(motors=named)
    for hand in (hand_of(winches(), motors=named), later.replace(motors=named, joint_stiffness="file"), later):
        assert tendons_of(hand).is_from_file
        np.testing.assert_array_equal(tendons_of(hand).cables.limits, [10.0] + [np.inf] * 19)
        assert hand.torque_limits[hand.joint_names.index("joint_4_0")] == 0.3
    with pytest.raises(hl.InputError, match=r"motors: .*long flexor 0"):
        hand_of(winches(), motors=hl.Motor(0.3))


def test_tendons_that_leave_joints_loose_are_no_hand():
    left = [name for name in NAMES if not name.endswith("4")]
    words = r"Tendons\(hl.tendon_routes.*nothing that springs back .*joint_4_0"
    with pytest.raises(hl.InputError, match=words) as error:
        hand_of(winches(left), stiffness=0.0)
    assert error.value.argument == "joint_stiffness"
    assert tendons_of(hand_of(winches(left))).names == tuple(left)


def test_a_hand_that_is_cut_out_keeps_the_tendons_on_its_links():
    text = twenty_text(winches(), f' stiffness="{OWN}"')
    assert len(tendons_of(hl.Hand.from_mjcf(text, TIPS, base="palm")).names) == 20
    with pytest.raises(hl.InputError, match="joint_stiffness"):
        hl.Hand.from_mjcf(text, TIPS[:1], base="finger_0_0")  # its tendons begin on the palm


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ('<position joint="joint_0_0" kp="1"/>', "beside servos of joints"),
        ('<position tendon="long flexor 0" kp="9" forcerange="1 5"/>', "only push, which no cable does:"),
    ],
)
def test_what_of_a_file_cannot_be_had_is_said(more, words):
    names = [name for name in NAMES if name != "long flexor 0"]
    text = winches(names).replace("</actuator>", f"{more}</actuator>")
    if "joint=" in more:
        with pytest.raises(hl.InputError, match="joint_stiffness"):
            hand_of(text, stiffness=0.0)
    else:
        assert tendons_of(hand_of(text)).names == tuple(names)
    assert about(hand_of(text, joint_stiffness=1.0), words)


def test_tendons_that_are_only_pushed_are_said_with_the_sign_that_pulls():
    with pytest.raises(hl.InputError, match=r"got none: servos .* only push.*forcerange below 0 for a gear above 0"):
        hand_of(winches(words='forcerange="-5 0"'), stiffness=0.0)


def test_friction_and_ranges_of_tendons_are_left_out_and_said():
    text = twenty_text(winches(), f' stiffness="{OWN}"')
    more = text.replace('name="long flexor 0"', 'name="long flexor 0" frictionloss="2" range="0.1 0.2"', 1)
    assert [d.about for d in about(hl.Hand.from_mjcf(more, TIPS), "of tendons (long flexor 0)")] == [
        "friction",
        "range",
    ]
    assert not about(hand_of(winches()), "of tendons (")


def test_springs_that_take_much_of_what_tendons_bear_are_doubted():
    """Return springs that are at rest with the fingers open pull with 0.5 N·m/rad times 1 rad in the middle."""
    joints, words = f' stiffness="{OWN}" springref="-0.6"', 'forcerange="0 {}"'
    found = [hl.Hand.from_mjcf(twenty_text(winches(words=words.format(most)), joints), TIPS) for most in (30.0, 3e3)]
    assert [len(about(hand, "springs of the file pull with up to")) for hand in found] == [1, 0]
    assert not about(hl.Hand.from_mjcf(twenty_text(winches(), joints), TIPS), "springs of the file")
