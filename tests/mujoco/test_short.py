"""The short cases of the suite: a dozen grasps, loaded here and in MuJoCo, end with the same forces and torques."""

from __future__ import annotations

import pytest

pytest.importorskip("mujoco")

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
