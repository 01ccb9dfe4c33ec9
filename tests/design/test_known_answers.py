"""Answers that are known before they are computed: laws of similarity, linear elasticity, and levers."""

from functools import cache

import numpy as np
import pytest

import handlcp as hl

G = 9.81


def made(length=1.0, force=1.0, stiffness=4.0, distal=0.04):
    """A three-finger hand whose lengths, and whose forces at the same angles, are so many times as large."""
    return hl.finger_hand(
        fingers=3, link_lengths=(0.05 * length, distal * length), palm_radius=0.04 * length, link_radius=0.008 * length,
        joint_stiffness=stiffness * force * length, torque_limits=5.0 * force * length,
        pad_flexibility=1e-4 / force * length,
    )  # fmt: skip


def brief(force=1.0):
    return hl.Brief(
        objects=hl.Sphere(0.03, mass=0.1 * force), loads={"twist": (0, 0, 0, 0, 0, 0.02 * force)}, friction=0.6,
        grip_force=5.0 * force, tries=2,
    )  # fmt: skip


@cache
def plain():
    return hl.evaluate(made(), brief())


def grasp_of(hand, length=1.0, **closing):
    """The grasp that was found, its object placed as many times as far away and as large."""
    found = plain().cases["object"].candidate
    there = found.object.placement
    there.translation *= length
    ball = hl.Sphere(0.03 * length, mass=0.1, placement=there)
    return hand.at(found.q).grasp(ball, friction=0.6, **(closing or {"grip_force": 5.0}))


@pytest.mark.parametrize("times", [0.2, 40.0])
def test_forces_of_another_scale_hold_as_many_times_as_much_with_the_same_motion(times):
    """Loads, grip, stiffness and 1 / pads times a: nothing in the equations knows a unit of force."""
    there = hl.evaluate(made(force=times), brief(times))
    assert there.payload == pytest.approx(times * plain().payload, rel=1e-9)
    assert there.torque == pytest.approx(times * plain().torque, rel=1e-9)
    assert there.motion == pytest.approx(plain().motion, rel=1e-9)
    assert there.cases["object"].factors["twist"] == pytest.approx(plain().cases["object"].factors["twist"], rel=1e-9)


@pytest.mark.parametrize("times", [0.5, 3.0])
def test_a_hand_of_another_size_holds_the_same_with_as_many_times_the_torque(times):
    """Lengths times s at the same angles and forces: torques times s. Contacts slide as many times as far."""
    small, large = grasp_of(made()), grasp_of(made(length=times), times)
    assert large.payload(max_slip=1e-3 * times).mass == pytest.approx(small.payload(max_slip=1e-3).mass, rel=1e-6)
    ends = [grasp.follow().solution for grasp in (small, large)]
    np.testing.assert_allclose(ends[1].torques, times * ends[0].torques, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(ends[1].object_displacement[:3], times * ends[0].object_displacement[:3], atol=1e-9)


@pytest.mark.parametrize("stiffness", [400.0, 1600.0])
def test_a_stiff_hand_moves_by_what_its_flexibility_says(stiffness):
    """Where nothing slides the object moves by (G E⁻¹ Gᵀ)⁻¹ w under a small load w, and a small grip does not turn."""
    grasp = grasp_of(made(stiffness=stiffness), grip_force=0.05).replace(mass=0.0)
    load = 0.01 * np.array([0.2, -0.1, 0.3, 0.0, 0.0, 0.0])
    R, arms = grasp.spec.frames, grasp.spec.positions - grasp.reference
    rows = np.concatenate([np.hstack([F.T, np.cross(arm, F.T)]) for F, arm in zip(R, arms, strict=True)])
    K = rows.T @ np.linalg.solve(grasp.spec.flexibility, rows)
    path = grasp.follow(load)
    stage = path.steps.stage
    moved = path.steps.displacement[-1] - path.steps.displacement[np.flatnonzero(stage == stage[-1])[0] - 1]
    expected = np.linalg.solve(K, load)
    for part in (slice(0, 3), slice(3, 6)):  # moved [m], turned [rad]
        np.testing.assert_allclose(moved[part], expected[part], rtol=0, atol=2e-3 * abs(expected[part]).max())


@pytest.mark.parametrize("distal", [0.036, 0.04, 0.044])
def test_torques_are_forces_times_their_levers_whatever_the_link_s_length(distal):
    """τ = a · (x - p) × f of each joint with axis a through p, forces f at x."""
    hand = made(distal=distal)
    case = hl.evaluate(hand, brief(), near=plain()).cases["object"]
    solution = case.candidate.grasp.solve()
    forces, where = -solution.forces_world, case.candidate.grasp.spec.positions
    for j in range(hand.nv):
        step, q = 1e-6, case.candidate.q.copy()
        q[j] += step
        there = hand.at(q)
        tips = [hand.fingertips.index(name) for name in case.candidate.grasp.fingertips]
        turned = there.tip_rotations[tips] @ case.candidate.state.tip_rotations[tips].transpose(0, 2, 1)
        arms = where - case.candidate.state.tip_positions[tips]
        moved = (there.tip_positions[tips] + np.einsum("nij,nj->ni", turned, arms) - where) / step
        assert -solution.torques[j] == pytest.approx((moved * forces).sum(), rel=1e-3, abs=1e-4)
