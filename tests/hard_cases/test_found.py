"""What these suites found, each as small as it gets."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

import handlcp as hl
from handlcp.lcp import proposals
from tests.support.grasp import arrays, contact_problem, judged
from tests.support.kernels import compiled
from tests.support.search import searched

LINE = [((-0.01, 0, 0), (1, 0, 0)), ((0.01, 0, 0), (-1, 0, 0))]


def pinch(load, mu=0.25):
    contacts = [hl.Contact(p, z, hl.Coulomb(mu), tangent=(0, 0, 1)) for p, z in LINE]
    return hl.Grasp(contacts, (0, 0, -load, 0, 0, 0), flexibility=1e-4, preload=1e-3)


@pytest.mark.parametrize("slide", [1e-3, 1.0, 1e3, 1e6, 1e9])
def test_no_slide_is_long_enough_to_excuse_an_overlap(slide):
    """A load 1 % beyond what the squeeze can hold: forces 1 % larger than the springs give are no answer, however far
    the object slides meanwhile.
    """
    load = 5.0 * 1.01  # 2 fingers · 10 N · 0.25
    f = np.array([[load / 2, 0, 10.1], [load / 2, 0, 10.1]])
    assert not judged(pinch(load), hl.Pyramid(4, inscribed=False), f, (0, 0, -slide, 0, 0, 0)).passes


@pytest.mark.parametrize("seed", range(12))
def test_contacts_at_one_point_have_no_size_made_of_rounding(seed):
    """Their mean may differ from that point by the last bit, which is no length to measure moments with."""
    at = np.random.default_rng(seed).uniform(-0.1, 0.1, 3)
    z = [(0, 0, 1), (0, 0.6, 0.8), (0.6, 0, 0.8)]
    f = np.array([0.1, 0.2, -1.3])
    g = hl.Grasp([hl.Contact(at, a) for a in z], np.r_[f, np.cross(at, f)], flexibility=1e-4)
    assert g.solve(throw=False).held
    assert arrays(g).units.length > 1e-3


def test_an_escape_without_friction_is_proven_when_generators_depend_on_each_other():
    """Four normals in a plane that meet in a point, a load out of that plane: the escape is that load's own part."""
    rng = np.random.default_rng([105, 13])
    n = int(rng.integers(2, 8))
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    Q *= np.sign(np.linalg.det(Q))
    t = 2 * np.pi * np.arange(n) / n
    out = np.column_stack([np.cos(t), np.sin(t), 0 * t]) @ Q.T
    w = np.r_[rng.uniform(0.1, 1) * Q[:, 2] + 0.1 * Q[:, 0], np.zeros(3)]
    s = hl.Grasp([hl.Contact(0.03 * a, -a, hl.Frictionless()) for a in out], w, flexibility=1e-4).solve(throw=False)
    assert s.status is hl.Status.NOT_HOLDABLE


@pytest.mark.parametrize("tol", [1, np.float32(1e-3), np.int8(1)])
def test_a_setting_of_another_number_type_compiles_nothing_anew(tol):
    p = hl.LCP(np.eye(2), [-1.0, 1.0])
    hl.solve_lcp(p, hl.NSNGRK(tol=1e-3), throw=False)
    before = compiled()
    hl.solve_lcp(p, hl.NSNGRK(tol=tol), throw=False)
    assert compiled() == before > 0


def test_stalled_kaczmarz_steps_end_within_their_budget():
    """Steps that make no progress must not be asked for in batches that double until an integer overflows."""
    from tests.hard_cases.test_flexibility import apart

    case = list(apart(4, 30))[29]
    for name, proposal in proposals(contact_problem(case.grasp(), 4)):
        assert proposal.iterations < 10**7, name


@pytest.mark.parametrize("faces", [16, "cone"])
def test_the_search_finds_an_equilibrium_that_the_stages_miss(faces):
    """16 faces have 45 million choices of modes."""
    from tests.hard_cases.test_no_pads import FAMILIES

    case = list(FAMILIES["no pads: a mixture"](faces, 34))[33]
    assert searched(case.grasp(), faces).outcome == "solution"


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


def test_units_in_which_a_problem_overflows_are_refused():
    units = hl.lcp.Units(np.full(1, 1e150), np.full(1, 1e-150))
    with pytest.raises(hl.InputError, match="units"):
        hl.LCP([[1e150]], [1.0], units=units)


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
