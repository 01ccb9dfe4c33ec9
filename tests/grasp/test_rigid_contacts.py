"""Many rigid contacts: forces are open, the least of them are given, and what is open is asked for when it is read."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

import handlcp as hl

MU = 0.5


def legs(n: int, wrench=(0, 0, -10.0, 0, 0, 0), mu: float = MU) -> hl.Grasp:
    """A plate on n rigid legs in a circle of one metre."""
    angles = 2 * np.pi * np.arange(n) / n
    contacts = [hl.Contact((np.cos(a), np.sin(a), 0), (0, 0, 1), mu) for a in angles]
    return hl.Grasp(contacts, wrench=wrench, flexibility=0.0)


@pytest.fixture
def programs(monkeypatch):
    """The sizes of the linear programs that are solved."""
    sizes, solve = [], scipy.optimize.linprog

    def counted(c, *args, **more):
        sizes.append(len(c))
        return solve(c, *args, **more)

    monkeypatch.setattr(scipy.optimize, "linprog", counted)
    return sizes


@pytest.mark.parametrize("faces", ["cone", 8])
@pytest.mark.parametrize("n", [60, 200])
def test_legs_share_a_weight_evenly_and_no_program_is_solved_for_it(n, faces, programs):
    s = legs(n).solve(faces)
    np.testing.assert_allclose(s.forces, np.tile([0, 0, 10.0 / n], (n, 1)), atol=1e-12)  # least norm, by symmetry
    assert set(s.contact_state) == {"sticking"}
    assert not programs, "solved by linear algebra"
    assert not s.uniqueness.forces_determined
    assert s.uniqueness.loose_motions == 0
    assert s.uniqueness.proven
    assert str(s.verdict).startswith("HELD")
    assert max(programs, default=0) <= 2 * n + 12, "what legs that press may do needs none; the faces are in none"


def test_legs_under_a_moment_press_as_a_beam_does():
    # the least normal forces with sum F and moments M are linear over the circle: F / n + 2 M sin a / n
    n = 100
    a = 2 * np.pi * np.arange(n) / n
    s = legs(n, (0, 0, -10.0, 4.0, 0, 0)).solve()
    np.testing.assert_allclose(s.normal_force, (10.0 - 2 * 4.0 * np.sin(a)) / n, rtol=1e-9)
    np.testing.assert_allclose(s.tangential_force, 0.0, atol=1e-12)


def test_frictionless_legs_leave_the_plate_to_slide():
    s = legs(50, mu=0.0).solve()
    assert s.uniqueness.loose_motions == 3
    assert not s.uniqueness.forces_determined
    turning = np.array([0, 0, 0, 0, 0, 1.0])
    D = s.uniqueness.directions
    for motion in (*np.eye(6)[:2], turning):
        across = motion - D.T @ np.linalg.lstsq(D.T, motion, rcond=None)[0]
        np.testing.assert_allclose(across, 0.0, atol=1e-9)  # in the span of what is loose


@pytest.mark.parametrize("n", [8, 40])
def test_bounds_of_a_leg_are_those_of_statics(n, programs):
    # Without friction the leg in question and the opposite one can carry half of a central weight each, and no leg
    # more: others would have to balance its moment from the same side
    s = legs(n, mu=0.0).solve(8)
    before = len(programs)
    bounds = s.force_bounds()
    assert len(programs) > before
    np.testing.assert_allclose(bounds.normal, np.tile([0.0, 5.0], (n, 1)), atol=1e-7)


@pytest.mark.parametrize("n", [11, 60])
def test_a_load_between_what_newton_finds_and_what_nothing_holds_is_balanced(n):
    # pushed aside by 0.8 of its friction and off its middle: its legs twist against it. Nothing searches for that
    s = legs(n, (4.0, 0, -10.0, 5.0, 0, 0)).solve()
    pull = s.forces_world.sum(axis=0)
    np.testing.assert_allclose(pull, [-4.0, 0, 10.0], atol=1e-7)
    assert (np.hypot(*s.tangential_force.T) <= MU * s.normal_force + 1e-7).all()
    np.testing.assert_allclose(s.object_displacement, 0.0, atol=1e-12)
    assert not any("search" in line for line in s.trace)


def test_the_least_forces_on_the_cone_are_no_larger_than_those_of_pyramids_inside_it():
    # every force within the pyramid is within the cone, so that the cone's least member is at most the pyramid's, and
    # at least that of a pyramid around it
    rng = np.random.default_rng(0)
    places = rng.normal(size=(20, 3))
    places /= np.linalg.norm(places, axis=1)[:, None]
    contacts = [hl.Contact(0.05 * p, -p, MU) for p in places]
    grasp = hl.Grasp(contacts, wrench=(0, 0, -10.0, 0, 0, 0), flexibility=0.0)
    inside, cone, outside = (
        float(np.linalg.norm(grasp.solve(faces).forces)) for faces in (hl.Pyramid(64), "cone", hl.Pyramid(64, False))
    )
    assert outside * (1 - 1e-6) <= cone <= inside * (1 + 1e-6)
    assert inside < 1.01 * outside


def test_what_takes_too_long_to_decide_is_said_to_be_an_upper_bound(monkeypatch):
    known = legs(6).solve().uniqueness
    monkeypatch.setattr("handlcp.grasp.solution.uniqueness.MAX_PROGRAM_WORK", 0.0)
    stopped = legs(6).solve().uniqueness
    assert known.proven
    assert not stopped.proven
    assert stopped.loose_motions >= known.loose_motions == 0
    assert str(stopped).endswith("takes more than the work set aside for that")
