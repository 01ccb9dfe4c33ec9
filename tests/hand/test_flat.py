"""Tiny facets: whether they touch at a point or between corners is one question, decided by one measure."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given, settings, strategies as st

from handlcp.geometry.contact_detection import choose_corners as flat_corners

# Of a facet that one measure called wide while no corner was so far from the first one chosen
FLAT = np.array([[9.77e-5, -8.5e-6], [-9.78e-5, -2.6e-6], [-7.12e-5, -6.85e-5], [7.11e-5, 6.15e-5]])  # m
APART = 1.93439e-4


def test_a_facet_that_is_wide_has_two_corners_also_where_they_are_nearer_than_that():
    assert np.ptp(FLAT[:, 0]) > APART
    assert len(flat_corners(FLAT, APART)) == 2


@given(seed=st.integers(0, 2**32 - 1), over=st.floats(0.0, 1.0), thin=st.floats(0.0, 1.0))
@example(seed=15, over=0.0, thin=0.5)
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
