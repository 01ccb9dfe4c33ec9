"""Paths whose contacts are followed: what they return to, what they converge to, and what energy they take."""

import numpy as np
import pytest

import handlcp as hl
from tests.loading.hands import ball, cube, gripper

LOAD = (0.3, 0.1, -0.5, 0.002, 0.0, 0.001)
TIGHT = 1e-11


def test_half_the_step_halves_the_error_or_better():
    def end(steps):
        h = cube().follow(LOAD, steps=steps, tolerance=TIGHT)
        return np.concatenate([h.steps.forces_world[-1].ravel(), h.displacement * 1e3])

    coarse, half, quarter, fine = (end(n) for n in (3, 6, 12, 24))
    errors = [abs(x - fine).max() for x in (coarse, half, quarter)]
    assert errors[1] <= errors[0] / 2
    assert errors[2] <= errors[1] / 2


def test_where_fingers_slide_four_times_the_steps_divide_the_error_by_more_than_eight():
    """First order would divide it by four, second order by sixteen."""
    load = 8.0 * np.array((0.3, 0.9, 0.3, 0, 0, 0))
    forces = {n: cube(squeeze=0.005).follow(load, steps=n, accuracy=1.0).steps.forces[-1] for n in (16, 64, 512)}
    coarse, fine = [abs(forces[n] - forces[512]).max() for n in (16, 64)]
    assert 8.0 * fine < coarse < 0.005 * abs(forces[512]).max()


def test_soft_pads_twist_as_their_flexibility_says_while_contacts_are_followed():
    """Two fingers in line: a moment about the line through both turns the box by M c / 2, however stiff joints are."""
    hand, box = hl.example_hand("two_finger", joint_stiffness=6.0), hl.Box(0.05, (0, 0, 0.08), mass=1e-4)
    c, moment = 3.0, 0.002
    g = hand.at(hand.close_on(box)).grasp(box, hl.SoftFinger(0.8, 0.01, torsional_flexibility=c), squeeze=0.005)
    line = g.spec.positions[1] - g.spec.positions[0]
    line /= np.linalg.norm(line)
    h = g.follow(np.append(np.zeros(3), moment * line))
    assert h.steps.contact_state[-1] == ("sticking", "sticking")
    assert line @ h.displacement[3:] == pytest.approx(0.5 * moment * c, rel=1e-4)
    assert max(s.iterates for s in h.steps.states) <= 5  # Newton's steps: no part of the tangent is missing


@pytest.mark.parametrize("grasp", [cube, ball])
def test_with_vanishing_load_and_squeeze_it_tends_to_one_solve(grasp):
    g = grasp(squeeze=3e-3)
    command, wrench = g.joint_offset, g.spec.wrench

    def difference(share):
        small = g.replace(joint_offset=share * command, wrench=share * wrench)
        weight = small.mechanism.weight_of_object(small.reference)[:3]
        load = share * wrench - np.append(weight, np.zeros(3))  # in all, the load is the share of the whole
        h = small.replace(wrench=share * wrench).follow(load, order="together", steps=4)
        one = small.solve("cone")
        assert h.reached
        assert one.held
        return abs(h.steps.forces_world[-1] - one.forces_world).max() / abs(one.forces_world).max()

    large, less, least = (difference(x) for x in (1.0, 0.1, 0.01))
    assert less < 0.2 * large
    assert least < 0.2 * less
    assert least < 1e-3


@pytest.mark.parametrize("make", [lambda: cube(), lambda: ball(finger_weight=True), lambda: ball(stiffness=2.0)])
def test_work_is_stored_or_taken_by_friction(make):
    def balance(steps):
        s = make().follow(steps=steps).steps
        given = s.work - s.work[0]
        return abs(given - (s.stored - s.stored[0]) - s.dissipated).max() / given.max()

    assert balance(40) < 1e-3
    assert balance(40) < 0.6 * balance(20)


def test_the_last_step_is_a_certified_solution_of_its_own():
    for g in (cube(), ball(friction=hl.SoftFinger(0.6, 0.003), wrench=(0, 0, 0, 0, 0, 0.01))):
        h = g.follow(steps=10)
        assert h.solution.held
        np.testing.assert_allclose(h.solution.forces, h.steps.forces[-1], atol=1e-10)
        np.testing.assert_allclose(h.solution.torques, h.steps.torques[-1], atol=1e-10)
        np.testing.assert_allclose(h.solution.gap, h.steps.gap[-1], atol=1e-12)


def test_the_whole_balances_in_the_posture_that_it_ends_in():
    g = ball(stiffness=2.0)
    h = g.follow()
    centre, state = h.object.center_of_mass, h.state
    again = state.grasp(h.object, friction=hl.Coulomb(0.6), gravity=(0, 0, 9.81), max_gap=1e-2)
    force = h.steps.forces_world[-1]
    np.testing.assert_allclose(force.sum(axis=0), (0, 0, -0.3 * 9.81), atol=1e-8)
    arms = np.array([c.position for c in again.contacts]) - centre
    np.testing.assert_allclose(np.cross(arms, force).sum(axis=0), 0.0, atol=1e-4 * abs(force).max())
    # Joints are springs to where they were commanded
    deflection = g.state.q + g.joint_offset - state.q
    np.testing.assert_allclose(2.0 * deflection, h.steps.torques[-1], atol=1e-9)


def test_fixed_geometry_is_one_solve_where_nothing_slips_and_all_comes_together():
    g = cube()
    h, one = g.follow(order="together", geometry="fixed", steps=3), g.solve("cone")
    np.testing.assert_allclose(h.steps.forces[-1], one.forces, atol=1e-9)
    np.testing.assert_allclose(h.displacement, one.object_displacement, atol=1e-12)


@pytest.mark.parametrize("pads", [0.0, 1e-6])
def test_stiff_directions_lose_no_object_whatever_the_steps(pads):
    """Two fingers beside each other slide outward alike; between them nothing but the pads gives way."""
    for steps in (8, 40):
        h = gripper(pads).follow(steps=steps)
        assert h.reached, (steps, h.why)
        assert abs(h.displacement[[1, 3, 5]]).max() < 1e-5, "the middle stays the middle"


def test_fingertips_without_pads_are_named_where_that_may_be_why_it_is_lost():
    """The load is far beyond what friction holds."""
    for pads, named in ((0.0, 1), (1e-4, 0)):
        verdict = gripper(pads).replace(wrench=(0, 0, -30.0, 0, 0, 0)).check()
        assert verdict.word == "NOT HELD"
        assert len(verdict.about("rigid_tips")) == named
