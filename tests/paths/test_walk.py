"""Load limits in one posture beside a walk from change to change that tries every choice of what slips."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from tests.limits.pinches import C, polygon
from tests.paths.corpus import case_of
from tests.paths.walk import PostureWalk, difference

# (number of seed 0, direction): ends that an earlier engine passed or did not reach, and others
ENDS = [
    (334, 10), (552, 0), (156, 0), (156, 8), (117, 9), (226, 10), (262, 10), (424, 4), (575, 11), (176, 0), (137, 9),
]  # fmt: skip


@pytest.mark.parametrize(("number", "direction"), ENDS)
def test_a_limit_in_one_posture_is_where_no_choice_of_slips_goes_on(number, direction):
    case = case_of(0, number)
    off, limit, end = difference(case, case.directions[direction])
    assert np.isfinite(end)
    assert abs(off) <= 2e-6, f"{limit} beside {end}"


def test_three_contacts_around_an_object_let_go_where_friction_is_used_up():
    """Pulled along their axis: 3 μ N, N = squeeze / C, less what a hexagon with a face that way lacks."""
    mu, squeeze = 0.4, 1e-3
    ways = [np.array([np.cos(a), np.sin(a), 0.0]) for a in 2.0 * np.pi / 3.0 * np.arange(3)]
    around = [hl.Contact(tuple(-0.03 * way), tuple(way), mu, (0, 0, 1)) for way in ways]
    grasp = hl.Grasp(around, flexibility=C, preload=squeeze)
    forces = np.tile([0.0, 0.0, squeeze / C], (3, 1))
    walk = PostureWalk(grasp, np.array([0, 0, 1.0, 0, 0, 0]), 6, forces, np.zeros(3), np.zeros(3))
    assert walk.end() == pytest.approx(3.0 * mu * squeeze / C * polygon(6, 0.0), rel=1e-9)
