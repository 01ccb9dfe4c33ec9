"""Load limits in many directions, and what they cost: no public name asks for it yet."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.grasp.friction import as_section
from handlcp.grasp.limits.directions import Limits, limits_of
from handlcp.grasp.limits.followed import limit
from handlcp.grasp.loading.state import Failure
from handlcp.grasp.loading.step import Stepper

__all__ = ["Counted", "many_limits"]


def many_limits(grasp: Any, wrenches: Any, geometry: str = "followed") -> Limits:
    """Of loads (m, 6), on the exact cone."""
    return limits_of(grasp.spec, as_section("cone", planar=False), wrenches, geometry)


class Counted:
    """A grasp with squeeze and weight, and what each limit takes: steps, failed ones too, and looks of the others."""

    def __init__(self, grasp: Any) -> None:
        self.ready = limit.ready(grasp.spec, as_section("cone", planar=False))
        self.steps = self.looks = 0

    def limit(self, load: Any) -> limit.Ended:
        """With the geometry followed."""
        self.steps = self.looks = 0
        pushed = Stepper.pushed

        def counted(stepper: Stepper, *given: Any) -> Any:
            found = pushed(stepper, *given)
            self.steps += 1
            self.looks += 0 if isinstance(found, Failure) else found.looks
            return found

        Stepper.pushed = counted  # type: ignore[method-assign]
        try:
            return limit.ended(self.ready, np.asarray(load), (np.inf, np.inf))
        finally:
            Stepper.pushed = pushed  # type: ignore[method-assign]
