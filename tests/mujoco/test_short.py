"""The short cases of the suite: grasps, loaded here and in MuJoCo, end with the same forces and torques, and are lost
at the same load for the same cause.
"""

from __future__ import annotations

import pytest

pytest.importorskip("mujoco")

from tests.mujoco import limits
from tests.mujoco.case import misses
from tests.mujoco.cases import CASES

SHORT = [case for case in CASES if case.short]


@pytest.mark.parametrize("case", SHORT, ids=lambda case: case.name)
def test_both_end_with_the_same_forces_and_torques(case):
    found = case.run(seconds=1.0)
    assert not misses(case, found)
    if case.kind == "sticks":
        assert found.force_error < 3e-3
        assert found.torque_error < 3e-3


@pytest.mark.parametrize(
    "case", [case for case in limits.CASES if case.short], ids=lambda case: f"{case.hand} {case.name}"
)
def test_a_load_that_grows_is_lost_at_the_same_factor_for_the_same_cause(case):
    ours = case.ours()
    theirs = case.theirs(ours.factor, seconds=3.0)
    assert not limits.misses(ours, theirs)
