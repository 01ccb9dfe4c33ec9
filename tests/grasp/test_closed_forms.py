"""Each effect against an answer that can be written down by hand."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import pinch

C = 1e-4  # m/N, the pinch's flexibility


def test_squeeze_divided_by_flexibility_is_the_normal_force_of_a_pinch():
    s = pinch(squeeze=1e-3, load=(0, 0, 0)).solve()
    np.testing.assert_allclose(s.normal_force, 10.0, rtol=1e-12)  # 1e-3 m on each of two springs of 1e-4 m/N
    assert s.contact_state == ("sticking", "sticking")


def test_a_sticking_pinch_sinks_by_its_tangential_flexibility():
    s = pinch(load=(0, 0, -1.0)).solve()
    np.testing.assert_allclose(s.forces_world.sum(0), [0, 0, 1.0], atol=1e-12)
    np.testing.assert_allclose(s.object_displacement[:3], [0, 0, -0.5 * C], atol=1e-15)  # two springs share 1 N
    np.testing.assert_allclose(s.slip, 0, atol=1e-15)


def test_a_planar_pinch_above_the_reference_carries_the_moment_of_its_load():
    # 50 mm above the origin 1 N along -y has the moment (0.05, 0, 0) about it, which no finger in that plane sees
    contacts = [hl.Contact((x, 0, 0.05), (-np.sign(x), 0, 0), hl.Coulomb(0.5)) for x in (-0.03, 0.03)]
    plane = dict(flexibility=C, preload=1e-3, plane=(0, 0, 1))
    s = hl.Grasp(contacts, (0, -1.0, 0, 0.05, 0, 0), **plane).solve()
    np.testing.assert_allclose(abs(s.forces), [[0.5, 0, 10.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(s.object_displacement, [0, -0.5 * C, 0, 0, 0, 0], atol=1e-15)
    with pytest.raises(hl.InputError) as e:
        hl.Grasp(contacts, (0, -1.0, 0, 0, 0, 0), **plane)
    assert e.value.argument == "wrench"


def test_a_sideways_push_moves_force_from_one_finger_to_the_other():
    s = pinch(load=(4.0, 0, 0)).solve()  # towards the right finger
    np.testing.assert_allclose(s.normal_force, [8.0, 12.0], rtol=1e-12)
    np.testing.assert_allclose(s.object_displacement[0], 4.0 * C / 2, rtol=1e-12)


def test_a_finger_lets_go_when_the_push_exceeds_its_preload():
    s = pinch(load=(25.0, 0, 0)).solve()
    np.testing.assert_allclose(s.normal_force, [0, 25.0], atol=1e-11)
    assert s.contact_state[0] == "separated"
    # right retreats by 25 C = 2.5 mm from where 1 mm of squeeze had it; the left tip's own 1 mm is used up
    np.testing.assert_allclose(s.gap, [25 * C - 2e-3, 0], atol=1e-15)


LIMIT = 2 * 10.0 * 0.25 * np.cos(np.pi / 4)  # N, straight through a face of the inscribed 4-face pyramid, both fingers


def test_friction_holds_up_to_the_limit_of_the_pyramid():
    s = pinch(mu=0.25, load=(0, 0, -LIMIT * (1 - 1e-9))).solve(4)
    np.testing.assert_allclose(abs(s.tangential_force[:, 0]), LIMIT / 2, rtol=1e-8)


def test_beyond_the_limit_no_answer_is_made_up_and_more_squeeze_holds():
    too_much = pinch(mu=0.25, load=(0, 0, -LIMIT * 1.001)).solve(4, throw=False)
    assert too_much.status is hl.Status.NO_EQUILIBRIUM  # it is holdable: with more normal force
    assert 0.99e-6 <= too_much.required_preload <= 1.12e-6, "0.001 of 1 mm, rounded up to two digits"
    assert pinch(mu=0.25, load=(0, 0, -LIMIT * 1.001), squeeze=1.01e-3).solve(4).held


def test_nothing_without_friction_holds_a_pinched_weight():
    contacts = [hl.Contact((-x, 0, 0), (x, 0, 0), hl.Frictionless()) for x in (1, -1)]
    s = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=C, preload=1e-3).solve(throw=False)
    assert s.status is hl.Status.NOT_HOLDABLE
    assert s.certificate[2] < 0
    assert np.isnan(s.forces).all()


def test_the_total_bound_opens_the_hand_at_the_bound():
    # three frictionless fingers in a plane press on a disc; preload 10 N each, at most 18 N in all
    angles = np.deg2rad([90, 210, 330])
    contacts = [hl.Contact((np.cos(a), np.sin(a)), (-np.cos(a), -np.sin(a)), hl.Frictionless()) for a in angles]
    g = hl.Grasp(contacts, (0, 0, 0), flexibility=0.1, preload=1.0, effects=[hl.TotalForceBound(18.0)])
    s = g.solve()
    np.testing.assert_allclose(s.normal_force, 6.0, rtol=1e-12)
    np.testing.assert_allclose(s.extra["z̄"], 0.4, rtol=1e-12)  # 1 m of squeeze, 0.6 m used
    loose = hl.Grasp(contacts, (0, 0, 0), flexibility=0.1, preload=1.0, effects=[hl.TotalForceBound(40.0)]).solve()
    np.testing.assert_allclose(loose.normal_force, 10.0, rtol=1e-12)
    np.testing.assert_allclose(loose.extra["z̄"], 0.0, atol=1e-12)


def test_a_prescribed_force_joins_the_load_and_moves_fingers_that_share_a_joint():
    # finger 0 is force-controlled at 2 N along its normal; finger 1 opposes it
    contacts = [hl.Contact((-x, 0, 0), (x, 0, 0), hl.Frictionless()) for x in (1, -1)]
    E = np.zeros((6, 6))
    E[2, 2] = E[5, 5] = C
    E[2, 5] = E[5, 2] = 0.25 * C  # a shared joint: each normal force moves the other tip, too
    g = hl.Grasp(contacts, None, flexibility=E, effects=[hl.PrescribedForce(0, (0, 0, 2.0))])
    s = g.solve()
    np.testing.assert_allclose(s.forces[0], [0, 0, 2.0])
    np.testing.assert_allclose(s.normal_force[1], 2.0, rtol=1e-12)
    # the object follows the retreat of finger 1: own force and the shared joint's
    np.testing.assert_allclose(s.object_displacement[0], 2.0 * C + 0.25 * C * 2.0, rtol=1e-12)
    assert (s.gap[0], *s.slip[0], s.contact_state[0]) == (0, 0, 0, "sticking")  # it follows the object


def test_rigid_fingers_hold_what_statics_determines():
    # a pinch of rigid fingers cannot be squeezed (no force is determined by motion), but a weight on three props is
    p = np.array([[1.0, 0, 0], [-0.5, 0.8, 0], [-0.5, -0.8, 0]])
    contacts = [hl.Contact(a, (0, 0, 1), hl.Frictionless()) for a in p]
    s = hl.Grasp(contacts, (0, 0, -6.0, 0, 0, 0)).solve()
    np.testing.assert_allclose(s.normal_force, 2.0, rtol=1e-9)
    assert s.uniqueness.forces_determined
    assert s.uniqueness.loose_motions == 3  # it slides and turns on its props


def test_rigid_redundant_props_leave_forces_undetermined_and_the_even_member_is_given():
    p = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
    contacts = [hl.Contact(a, (0, 0, 1), hl.Frictionless()) for a in p]
    s = hl.Grasp(contacts, (0, 0, -8.0, 0, 0, 0)).solve()
    assert not s.uniqueness.forces_determined
    np.testing.assert_allclose(s.normal_force, 2.0, rtol=1e-9)  # least norm


def test_a_planar_contact_slides_at_mu_exactly():
    # a block on one soft-sided prop pushed sideways: planar friction has no pyramid
    contacts = [
        hl.Contact((0, 0), (0, 1), hl.Coulomb(0.3), tangent=(1, 0)),
        hl.Contact((1, 0), (0, 1), hl.Coulomb(0.3), tangent=(1, 0)),
        hl.Contact((1.0, 0.1), (-1, 0), hl.Frictionless()),
    ]
    s = hl.Grasp(contacts, (5.0, -10.0, -5.0), flexibility=1e-3).solve()
    assert s.contact_state[0] == s.contact_state[1] == "sliding"
    np.testing.assert_allclose(s.tangential_force[:2, 0], -0.3 * s.normal_force[:2], rtol=1e-12)
    np.testing.assert_allclose(s.normal_force[2], 5.0 - 0.3 * 10.0, rtol=1e-9)
