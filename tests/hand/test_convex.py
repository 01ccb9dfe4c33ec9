"""Convex parts of meshes that are not convex: of objects, and of links that are named."""

from __future__ import annotations

import coal
import numpy as np
import pytest

import handlcp as hl
from tests.support.hand import shape_near

trimesh = pytest.importorskip("trimesh")
pytest.importorskip("coacd")


@pytest.fixture(scope="module")
def ring():
    return hl.Mesh(trimesh.creation.annulus(0.02, 0.03, 0.04, sections=24), mass=0.1)


def test_the_parts_of_a_ring_fill_it_and_leave_its_middle_empty(ring):
    assert not ring.convex
    volume = sum(float(part.computeVolume()) for part in ring.parts)
    assert volume == pytest.approx(ring.volume, rel=0.15)
    assert len(ring.parts) > 3


def test_links_touch_a_ring_in_its_parts(ring):
    """A box flat on the ring's upper side: as far away as it was put."""
    near = shape_near(coal.Box(0.1, 0.1, 0.02), np.eye(3), np.array([0.0, 0.0, 0.02 + 0.01 + 0.003]), ring)
    assert near.gap == pytest.approx(0.003, abs=1e-4)


def test_a_link_that_is_not_there_has_no_parts():
    with pytest.raises(hl.UnknownName, match="palm"):
        hl.example_hand("two_finger").in_parts("thumb")
    parted = hl.example_hand("two_finger").in_parts("palm")
    assert parted.in_parts_of == {"palm"}
