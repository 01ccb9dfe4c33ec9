"""What these suites found, each as small as it gets."""

import contextlib

import numpy as np
import pytest

import handlcp as hl
from tests.hard_cases.scenes import turn


def test_an_escape_without_friction_is_proven_when_generators_depend_on_each_other():
    """Four normals in a plane that meet in a point, a load out of that plane: the escape is that load's own part."""
    rng = np.random.default_rng([105, 13])
    n = int(rng.integers(2, 8))
    Q = turn(rng)
    t = 2 * np.pi * np.arange(n) / n
    out = np.column_stack([np.cos(t), np.sin(t), 0 * t]) @ Q.T
    w = np.r_[rng.uniform(0.1, 1) * Q[:, 2] + 0.1 * Q[:, 0], np.zeros(3)]
    s = hl.Grasp([hl.Contact(0.03 * a, -a, hl.Frictionless()) for a in out], w, flexibility=1e-4).solve(throw=False)
    assert s.status is hl.Status.NOT_HOLDABLE


EXTREMES = [([[1e-300]], [1e150]), ([[1e-300, 0], [1, 1]], [0, 1e-300]), ([[0, 1e-300], [-1, 1e150]], [1, 1e150])]


@pytest.mark.parametrize(("M", "q"), EXTREMES)
def test_numbers_three_hundred_decades_apart_give_no_warning(M, q):
    with contextlib.suppress(hl.InputError):  # a refusal is fine, too
        s = hl.solve_lcp(hl.LCP(M, q), throw=False)
        assert s.status is not hl.Status.SOLVED or np.isfinite(np.r_[s.z, s.w]).all()


def test_a_free_unknown_beyond_a_float64_gives_no_warning():
    p = hl.LCP([[1e-300, 1e-75], [1e-300, 1e75]], [1e9, 1e9], [True, False])
    assert hl.solve_lcp(p, throw=False).status is not hl.Status.SOLVED  # z = (-1e309, 0)


@pytest.mark.parametrize(("M", "q", "z"), [([[1e-200]], [-1], [1e200]), ([[1e-300, 0], [1, 1]], [-1e-300, -9], [1, 8])])
def test_numbers_far_apart_are_no_excuse_for_a_wrong_answer(M, q, z):
    np.testing.assert_allclose(hl.solve_lcp(hl.LCP(M, q)).z, z)


def test_friction_beyond_measure_leaves_what_is_loose_to_be_named():
    """Four contacts at rest; constraints 1e50 long next to ones of length one are no linear program for HiGHS."""
    places = [(-0.01, 0.01, -0.01), (0, 0.01, 0.01), (0.02, 0.01, 0), (-0.01, 0.01, 0.01)]
    normals = np.array([(1, 1, -1), (0, 1, 1), (1, 1, 0), (0, -1, 0)]) / np.sqrt([[3], [2], [2], [1]])
    contacts = [
        hl.Contact(p, z, hl.Coulomb(mu)) for p, z, mu in zip(places, normals, [1e50, 1e50, 1e9, 1e15], strict=True)
    ]
    s = hl.Grasp(contacts, flexibility=1e-4).solve(throw=False)
    assert s.held
    assert s.uniqueness.loose_motions == 6


def test_friction_too_small_for_a_float64_acts_like_none():
    """The exact cone's friction force squared is 0, which names no direction that the contact slides in."""
    places = [(-0.01, 0, 0.02), (0.01, 0.01, 0.01), (0.02, 0.02, 0.01)]
    normals = np.array([(0, -1, -1), (1, 1, -1), (0, -1, 0)]) / np.sqrt([[2], [3], [1]])
    contacts = [hl.Contact(p, z, hl.Coulomb(mu)) for p, z, mu in zip(places, normals, [1e9, 1e30, 1e-30], strict=True)]
    offset = [(0, 0, -1e-3), (0, 0, 0), (0, 0, 0)]
    s = hl.Grasp(contacts, (1e-3, -1, 1, 1e-3, 0, 0), flexibility=1e-4, offset=offset).solve("cone", throw=False)
    assert s.held
    assert abs(s.forces[2, :2]).max() < 1e-12
