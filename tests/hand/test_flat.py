"""Tiny facets: whether they touch at a point or between corners is one question, decided by one measure."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings, strategies as st

import handlcp as hl
from tests.support.hand import flat_corners, flush_corners

# Of a facet that one measure called wide while no corner was so far from the first one chosen
FLAT = np.array([[9.77e-5, -8.5e-6], [-9.78e-5, -2.6e-6], [-7.12e-5, -6.85e-5], [7.11e-5, 6.15e-5]])  # m
APART = 1.93439e-4


def test_a_facet_that_is_wide_has_two_corners_also_where_they_are_nearer_than_that():
    assert np.ptp(FLAT[:, 0]) > APART
    assert len(flat_corners(FLAT, APART)) == 2


@given(seed=st.integers(0, 2**32 - 1), over=st.floats(0.0, 1.0), thin=st.floats(0.0, 1.0))
@settings(max_examples=300, deadline=None)
def test_points_that_are_wide_span_at_least_two_corners(seed, over, thin):
    """However little wider than the threshold they are; no other two of the corners are nearer than that."""
    points = np.random.default_rng(seed).normal(size=(8, 2)) * (1.0, thin)
    points -= points.mean(axis=0)
    apart = float(np.ptp(points[:, 0])) / (1.0 + 1e-12 + over)
    chosen = flat_corners(points, apart)
    assert 2 <= len(chosen) == len(set(chosen)) <= 4
    between = np.linalg.norm(points[chosen, None] - points[chosen], axis=2)
    assert (between[np.triu_indices(len(chosen), 1)][1:] > apart).all()


@pytest.mark.parametrize("share", [0.5, 0.9, 0.999, 1.0, 1.001, 1.1, 2.0])
def test_a_tip_of_any_tiny_facet_presses_at_a_point_or_between_corners(share):
    rng, wall = np.random.default_rng(3), hl.Box(0.1)
    for _ in range(20):
        sides = share * APART * rng.uniform(0.3, 1.0, size=2)
        hull = coal.Box(*sides, 2e-3)
        turn = pin.exp3(np.array([*(1e-4 * rng.normal(size=2)), rng.uniform(0.0, 7.0)]))
        assert flush_corners(hull, turn, np.array([0.0, 0.0, 0.051]), wall, APART) in (1, 2, 3, 4)
