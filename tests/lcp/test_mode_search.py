"""The search over contact modes: its patches enclose every slide, and it can be paused anywhere."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.lcp.modes.mode_search import ModeSearch
from tests.grasp.scenes import ring
from tests.support.grasp import contact_problem
from tests.support.lcp import misses_patch, nearest_point, patches
from tests.support.search import searched


@pytest.mark.parametrize(("tangents", "faces"), [(1, 2), (2, 3), (2, 4), (2, 5), (2, 8), (2, 16), (2, 0), (3, 0)])
@pytest.mark.parametrize("splits", [0, 1, 3])
def test_every_slide_lies_in_one_of_the_patches(tangents, faces, splits):
    """A force on the limit and the slip that it opposes, by projecting points from outside onto the set."""
    rng, every, outside = np.random.default_rng(0), patches(tangents, faces, splits), 0
    for _ in range(40):
        s = np.zeros(3)
        s[:tangents] = rng.standard_normal(tangents) * 3.0
        P = nearest_point(s, tangents, 0.7, faces)
        if np.linalg.norm(s - P) < 1e-9:
            continue
        outside += 1
        force, motion = np.append(1.0, P[:tangents]), np.append(0.0, (P - s)[:tangents])
        assert min(misses_patch(0.7, faces, corners, force, motion) for corners in every) < 1e-9
    assert outside >= 20


def test_patches_of_the_disc_and_the_ball_shrink_to_the_set():
    """A force a little outside lies in patches at first, and in none of the finer ones."""
    for tangents in (2, 3):
        rng = np.random.default_rng(tangents)
        e = rng.standard_normal(tangents)
        e /= np.linalg.norm(e)
        force, motion = np.append(1.0, 0.7 * 1.01 * e), np.append(0.0, -e)
        coarse, fine = (
            min(misses_patch(0.7, 0, corners, force, motion) for corners in patches(tangents, 0, k)) for k in (0, 4)
        )
        assert coarse < 1e-9 < 1e-5 < fine


def slipping_ring():
    """Three fingers that could hold it, but squeeze too little: no equilibrium."""
    contacts, data = ring(np.random.default_rng(1), n=3, mu=0.5, preload=1e-4)
    return hl.Grasp(contacts, **data)


@pytest.mark.parametrize("faces", [8, "cone"])
def test_a_search_in_small_pieces_ends_like_one_in_one_piece(faces):
    problem = contact_problem(slipping_ring(), faces)
    bounds = np.full((2, problem.n), 1e3)
    whole, pieces = ModeSearch(problem, *bounds), ModeSearch(problem, *bounds)
    list(whole.candidates(1e9))
    assert whole.is_none_proven
    assert whole.node_count > 10
    work = 0.0
    while not pieces.exhausted:
        work += 1e3
        list(pieces.candidates(work))
    assert (whole.exhausted, whole.is_none_proven, whole.node_count) == (
        pieces.exhausted,
        pieces.is_none_proven,
        pieces.node_count,
    )


@pytest.mark.parametrize("faces", [16, "cone"])
def test_the_search_finds_an_equilibrium_that_the_stages_miss(faces):
    """16 faces have 45 million choices of modes."""
    from tests.hard_cases.test_families import FAMILIES

    case = list(FAMILIES["no pads: a mixture"][1](faces, 34))[33]
    assert searched(case.grasp(), faces).outcome == "solution"
