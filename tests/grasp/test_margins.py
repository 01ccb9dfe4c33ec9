"""How much of friction and of torque an answer uses, and what is left: against closed forms."""

import numpy as np
import pytest

import handlcp as hl

MU, PUSH = 0.5, 4.0  # [-], [N]
E = 1e-3  # [m/N]


def pinch(pull, law=None, faces="cone", **more):
    """Two fingers that squeeze with 4 N each, pulled across: each bears half of the pull by friction."""
    law = hl.Coulomb(MU) if law is None else law
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), law, tangent=(0, 0, 1)) for s in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -pull, 0, 0, 0), flexibility=E, preload=PUSH * E, **more).solve(faces)


@pytest.mark.parametrize("pull", [0.0, 1.0, 3.0, 3.9])
def test_a_pinch_uses_half_the_pull_over_mu_times_the_push(pull):
    s = pinch(pull)
    np.testing.assert_allclose(s.friction_used, [pull / 2 / (MU * PUSH)] * 2, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(s.friction_margin, [MU * PUSH - pull / 2] * 2, rtol=1e-9)


def test_along_the_lesser_axis_of_an_elliptic_law_the_limit_is_the_lesser_coefficient():
    law = hl.AnisotropicCoulomb(0.25, MU)  # 0.25 along the pull
    s = pinch(1.2, law)
    np.testing.assert_allclose(s.friction_used, [0.6 / (0.25 * PUSH)] * 2, rtol=1e-9)


def test_a_soft_finger_adds_its_moment_to_its_friction():
    """On the ellipsoid: (r_T / μ)² + (r_τ / μ_τ)² = used² r_N²; each finger bears half of force and moment."""
    mu_torsion, turn = 0.01, 0.02
    law = hl.SoftFinger(MU, mu_torsion)
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), law) for s in (-1.0, 1.0)]
    s = hl.Grasp(contacts, (0, 0, -2.0, turn, 0, 0), flexibility=E, preload=PUSH * E).solve("cone")
    used = np.hypot(1.0 / MU, 0.5 * turn / mu_torsion) / PUSH
    np.testing.assert_allclose(s.friction_used, [used] * 2, rtol=1e-6)


def test_what_slides_uses_all_and_has_no_margin():
    """Four fingers, of which the slippery pair bears μ N each and leaves the rest of the pull to the other pair."""
    slippery, pull = 0.02, 3.0
    pairs = [((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(MU)) for s in (-1.0, 1.0)]
    pairs += [((0, s * 0.02, 0), (0, -s, 0), hl.Coulomb(slippery)) for s in (-1.0, 1.0)]
    fingers = [hl.Contact(*each) for each in pairs]
    s = hl.Grasp(fingers, (0, 0, -pull, 0, 0, 0), flexibility=E, preload=PUSH * E).solve("cone")
    assert s.contact_state == ("sticking", "sticking", "sliding", "sliding")
    rest = pull / 2 - slippery * PUSH
    np.testing.assert_allclose(s.friction_used, [rest / (MU * PUSH)] * 2 + [1.0] * 2, rtol=1e-7)
    np.testing.assert_allclose(s.friction_margin, [MU * PUSH - rest] * 2 + [0.0] * 2, rtol=1e-7, atol=1e-7)


def test_there_is_no_number_without_friction_without_force_and_without_an_answer():
    smooth = hl.Grasp([hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Frictionless()) for s in (-1.0, 1.0)],
                      flexibility=E, preload=PUSH * E).solve()  # fmt: skip
    assert np.isnan([smooth.friction_used, smooth.friction_margin]).all()
    lost = hl.Grasp([hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(MU)) for s in (-1.0, 1.0)],
                    (0, 0, -100, 0, 0, 0), flexibility=E, preload=PUSH * E).solve(throw=False)  # fmt: skip
    assert not lost.held
    assert np.isnan([lost.friction_used, lost.friction_margin]).all()
    apart = hl.Grasp(
        [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(MU)) for s in (-1.0, 1.0)]
        + [hl.Contact((0, 0.02, 0), (0, -1, 0), hl.Coulomb(MU))],
        flexibility=E, offset=[(0, 0, -PUSH * E), (0, 0, -PUSH * E), (0, 0, 1e-3)]
    ).solve()  # fmt: skip
    assert apart.contact_state[2] == "separated"
    assert np.isnan(apart.friction_used).tolist() == [False, False, True]
    assert apart.friction_margin[2] == 0.0


def test_torques_use_their_share_of_the_limit_and_leave_the_rest():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, torque_limits=0.25)
    box = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    s = hand.at(hand.close_on(box)).grasp(box, hl.Coulomb(0.8), preload=5e-3).solve()
    np.testing.assert_allclose(s.utilisation, abs(s.torques) / 0.25, rtol=1e-12)
    np.testing.assert_allclose(s.torque_margin, 0.25 - abs(s.torques), rtol=1e-12)
    assert s.torque_margin.min() < 0.0 < s.torque_margin.max(), "some joints are over this limit"
    free = hl.example_hand("three_finger", joint_stiffness=6.0, torque_limits=np.inf)
    grasp = free.at(free.close_on(box)).grasp(box, hl.Coulomb(0.8), preload=5e-3)
    assert np.isinf(grasp.solve().torque_margin).all()


def test_on_a_pyramid_a_contact_slides_from_the_cosine_of_half_a_face_on():
    s = pinch(2 * MU * PUSH * 0.99 * np.cos(np.pi / 6), faces=6)
    assert s.contact_state == ("sticking", "sticking")
    assert s.friction_used[0] == pytest.approx(0.99 * np.cos(np.pi / 6), rel=1e-9)
