"""The short cases of the suite: grasps, loaded here and in MuJoCo, end with the same forces and torques, and are lost
at the same load for the same cause.
"""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

from handlcp.simulator import simulate_limit
from tests.mujoco import limits
from tests.mujoco.case import misses
from tests.mujoco.cases import CASES
from tests.mujoco.limit_cases import CASES as CASES_OF_LIMITS
from tests.mujoco.limit_truth import stored

SHORT = [case for case in CASES if case.short]


@pytest.mark.parametrize("case", SHORT, ids=lambda case: case.name)
def test_both_end_with_the_same_forces_and_torques(case):
    found = case.run(seconds=1.0)
    assert not misses(case, found)
    if case.kind == "sticks":
        assert found.force_error < 3e-3
        assert found.torque_error < 3e-3


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(c, marks=pytest.mark.long) if c.title.startswith("allegro") else c
        for c in CASES_OF_LIMITS
        if c.short
    ],
    ids=lambda case: case.title,
)
def test_a_load_that_grows_is_lost_at_the_same_factor_as_the_stored_table_says(case):
    ours, expected = limits.ours(case), stored()[case.title]
    most = 1.2 * ours.end
    theirs = simulate_limit(case.make(), case.wrench, most, seconds=3.0)
    assert theirs.factor == pytest.approx(ours.end, rel=limits.NEAR)
    assert theirs.factor == pytest.approx(expected.factor, rel=0.02)
    assert theirs.jump == pytest.approx(expected.jump, rel=0.02)
    half = 0.5 * expected.factor
    near = abs(theirs.track.motion_at(half) - expected.at(half))
    assert near[:3].max() < 1e-5 + 0.03 * np.linalg.norm(expected.at(half)[:3])
