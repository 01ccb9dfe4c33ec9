"""What the tests need of the inside of paths."""

from __future__ import annotations

import pytest

from handlcp.grasp.path import step
from handlcp.grasp.path.newton.iteration import one_iteration


def in_one_matrix(patch: pytest.MonkeyPatch) -> None:
    """Paths of many contacts are computed as those of few are: contacts are not eliminated one by one."""
    patch.setattr(step, "iteration_by_contact", one_iteration)
