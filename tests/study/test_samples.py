"""The grasps of samples are those that the public names make, one change at a time."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.robot.servo_stiffness import ServoStiffness
from tests.support.study import grasp_with

HAND = hl.example_hand("three_finger", joint_stiffness=6.0)
CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
Q = HAND.close_on(CUBE)
PULL = (0.3, 0, 0, 0, 0, 0)


def grasp(hand=HAND, **more):
    return hand.at(Q).grasp(CUBE, **({"friction": 0.8, "squeeze": 0.005, "wrench": PULL} | more))


@pytest.fixture(scope="module")
def nominal():
    return grasp()


def same(one, other):
    a, b = one.solve(), other.solve()
    np.testing.assert_allclose(a.forces, b.forces, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(a.torques, b.torques, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(a.object_displacement, b.object_displacement, rtol=1e-8, atol=1e-10)


def commanded(g):
    """The same with the nominal command of the joints, which stays when springs, pads and contacts change."""
    return g.replace(joint_offset=grasp().joint_offset)


def test_friction_mass_and_load_are_those_of_replace(nominal):
    made = grasp_with(nominal, friction=0.7, mass=0.25, load=2.0)
    same(made, nominal.replace(friction=0.7, mass=0.25).replace(load=2 * np.array(PULL)))
    assert made.target.mass == 0.25


def test_a_squeeze_is_a_share_of_the_command(nominal):
    same(grasp_with(nominal, squeeze=1.2), nominal.replace(joint_offset=1.2 * nominal.joint_offset))


def test_springs_and_pads_are_those_of_another_hand_with_the_same_command(nominal):
    stiffer = HAND.replace(joint_stiffness=6.6, pad_flexibility=1.3 * HAND.pad_flexibility)
    made = grasp_with(nominal, stiffness=1.1, pads=1.3)
    same(made, commanded(grasp(stiffer)))
    np.testing.assert_allclose(made.state.flexibility, stiffer.at(Q).flexibility, rtol=1e-12, atol=1e-18)
    assert made.check().word == commanded(grasp(stiffer)).check().word == "HELD"


def test_one_spring_is_that_of_another_hand(nominal):
    joint = HAND.joint_names[1]
    stiffness = dict.fromkeys(HAND.joint_names, 6.0) | {joint: 7.5}
    same(grasp_with(nominal, stiffness={joint: 1.25}), commanded(grasp(HAND.replace(joint_stiffness=stiffness))))


def test_springs_of_a_file_s_servos_change_joint_by_joint():
    joint, own = HAND.joint_names[1], 0.5 * np.eye(HAND.nv)
    hand = HAND.with_parts(stiffness=ServoStiffness(6.0 * np.eye(HAND.nv), np.eye(HAND.nv), own, Q))
    stiffness = dict.fromkeys(HAND.joint_names, 6.0) | {joint: 7.5}
    made = grasp_with(grasp(hand), stiffness={joint: 1.25})
    same(made, commanded(grasp(HAND.replace(joint_stiffness=stiffness))))
    np.testing.assert_allclose(np.diag(made.state.hand.stiffness.passive), [0.5, 0.625, *[0.5] * 4])


def test_joints_that_stand_off_carry_the_fingertips_along():
    """As a hand in that posture whose joints are commanded as far on, with the contacts where they were."""
    contacts = [c.with_name(tip) for c, tip in zip(grasp().contacts, HAND.fingertips, strict=True)]
    load = grasp().spec.wrench

    def given(q, **more):
        return HAND.at(q).grasp(contacts, wrench=load, reference=CUBE.center_of_mass, gravity=(0, 0, 0), **more)

    command, off = grasp().joint_offset, 0.01 * np.cos(np.arange(HAND.nv))
    made = grasp_with(given(Q, joint_offset=command), posture=dict(zip(HAND.joint_names, off, strict=True)))
    same(made, given(Q + off, joint_offset=command + off))
    np.testing.assert_allclose(made.state.q, Q + off)


def test_contacts_slide_on_flat_faces_and_keep_their_normals(nominal):
    made = grasp_with(nominal, positions={"finger_1_tip": (2e-3, -1e-3)})
    R = nominal.frames[0]
    goal = nominal.spec.positions[0] + R[:, :2] @ (2e-3, -1e-3)
    np.testing.assert_allclose(made.spec.positions[0], goal, atol=1e-12)
    np.testing.assert_array_equal(made.frames[0], R)
    np.testing.assert_array_equal(made.spec.positions[1:], nominal.spec.positions[1:])
    contacts = {tip: hl.Contact(p, F[:, 2], 0.8, tangent=F[:, 0])
                for tip, p, F in zip(HAND.fingertips, made.spec.positions, made.frames, strict=True)}  # fmt: skip
    other = HAND.at(Q).grasp(
        contacts, wrench=nominal.spec.wrench, reference=CUBE.center_of_mass, gravity=(0, 0, 0),
        joint_offset=nominal.joint_offset, offset=nominal.tip_offset,
    )  # fmt: skip
    same(made, other)


def test_contacts_slide_on_a_ball_and_their_normals_turn():
    hand, ball = hl.example_hand("five_finger", joint_stiffness=6.0), hl.Sphere(0.035, (0, 0, 0.07), mass=0.2)
    held = hand.at(hand.close_on(ball)).grasp(ball, squeeze=0.003)
    made = grasp_with(held, positions={"finger_3_tip": (3e-3, 2e-3)})
    p, R = made.spec.positions[2], made.frames[2]
    away = p - ball.center_of_mass
    assert np.linalg.norm(away) == pytest.approx(np.linalg.norm(held.spec.positions[2] - ball.center_of_mass))
    np.testing.assert_allclose(R[:, 2], -away / np.linalg.norm(away), atol=1e-12)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.norm(p - held.spec.positions[2]) == pytest.approx(np.hypot(3e-3, 2e-3), rel=1e-2)


def test_fingers_whose_weight_counts_are_weighed_in_the_posture_of_the_sample():
    heavy = grasp(finger_weight=True)
    joint = HAND.joint_names[0]
    made = grasp_with(heavy, posture={joint: 0.05})
    q = Q.copy()
    q[0] += 0.05
    np.testing.assert_allclose(made.gravity_torque, HAND.at(q).gravity_torque(), rtol=1e-12)


def test_a_hand_with_tendons_takes_one_factor_for_all_its_springs_and_no_mapping(nominal):
    arms = 0.01 * np.eye(HAND.nv)[:3]
    coupled = HAND.replace(joint_stiffness=hl.Tendons(arms, 1e4, passive=5.0))
    one = grasp(coupled)
    stiffer = grasp_with(one, stiffness=1.5)
    root = one.mechanism.compliance_factor / np.sqrt(1.5)
    np.testing.assert_allclose(stiffer.mechanism.compliance_factor, root, rtol=1e-9, atol=1e-12)
    with pytest.raises(hl.InputError, match="tendons or synergies"):
        hl.reliability(one, {"stiffness": {HAND.joint_names[0]: 0.1}}, 64)


def test_torque_limits_count_beside_holding_and_the_chance_within_them_is_less():
    weak = HAND.replace(torque_limits=0.34)
    found = hl.reliability(grasp(weak), {"squeeze": 0.15, "mass": 0.2}, 200, workers=1)
    assert found.counts["OVER LIMIT"] > 10
    assert found.chance_within_limits.value < found.chance_held.value
    over = found.codes == 1
    torques = np.array([found.sample(k).solution.torques for k in np.flatnonzero(over)[:5]])
    assert (abs(torques).max(axis=1) > 0.34).all()
    assert (found.margin[over] < 0.0).all()
    if not (found.codes == 2).any():
        assert found.worst.word == found.worst.verdict.word == "OVER LIMIT"


def test_each_sample_may_be_checked_instead_of_solved(nominal):
    found = hl.reliability(nominal, {"mass": 0.5}, 64, by="check")
    for k in (0, 17, 40):
        assert found.sample(k).grasp.check().word == found.sample(k).word
    assert found.sample(17).verdict.loading is not None


def test_slopes_are_the_derivatives_of_the_solution(nominal):
    """Where all contacts stick and friction binds: margin = Σ (μ N - |T|) / Σ μ N."""
    firm = nominal.replace(friction=1.5, squeeze=2e-3, load=(0,) * 6)
    s = firm.solve()
    assert set(s.contact_state) == {"sticking"}
    d, mu, N = s.sensitivity(), 1.5, s.normal_force
    margin, limit = s.friction_margin, (mu * N).sum()

    def slope(margins, normals, mus=0.0):
        return margins.sum() / limit - margin.sum() / limit**2 * (mu * normals + mus * N).sum()

    weight = np.array([0, 0, -9.81 * 0.2, 0, 0, 0])
    command = firm.joint_offset
    joint, K, along = HAND.joint_names[0], 6.0, firm.frames[1][:, 0]
    expected = {
        "friction": 0.15 * slope(d.friction_margin_by_friction.sum(axis=1), d.forces_by_friction[:, 2].sum(axis=1), 1),
        "mass": 0.1 * slope(d.friction_margin_by_wrench @ weight, d.forces_by_wrench[:, 2] @ weight),
        "squeeze": 0.1 * slope(d.friction_margin_by_joint_offset @ command, d.forces_by_joint_offset[:, 2] @ command),
        f"stiffness {joint}": 0.1 * K * slope(d.friction_margin_by_stiffness[:, 0], d.forces_by_stiffness[:, 2, 0]),
        "position finger_2_tip x": 1e-3
        * slope(d.friction_margin_by_positions[:, 1] @ along, d.forces_by_positions[:, 2, 1] @ along),
    }
    spread = {"friction": 0.1, "mass": 0.1, "squeeze": 0.1, "stiffness": {joint: 0.1},
              "positions": {"finger_2_tip": 1e-3}}  # fmt: skip
    found = {f.name: f.slope for f in hl.reliability(firm, spread, 64, workers=1).influences}
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-4, abs=1e-7), name
