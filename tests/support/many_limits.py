"""Load limits in many directions, and what they cost: no public name asks for it yet."""

import numpy as np

from handlcp.contact.friction import as_section
from handlcp.grasp.limits.directions import limits_of
from handlcp.grasp.limits.followed import anything_else, followed_limit
from handlcp.grasp.path.state import State
from handlcp.grasp.path.step import Stepper


def many_limits(grasp, wrenches, geometry="followed"):
    """Of loads (m, 6), on the exact cone."""
    return limits_of(grasp.spec, as_section("cone", planar=False), wrenches, geometry)


class Counted:
    """What limits of a grasp take, squeeze and weight included: steps, failed ones too, and looks of the others."""

    def __init__(self, grasp):
        self.spec, self.section = grasp.spec, as_section("cone", planar=False)
        self.steps = self.iterates = 0

    def limit(self, load):
        """With the geometry followed."""
        self.steps = self.iterates = 0
        step = Stepper.step

        def counted(stepper, *given, **more):
            found = step(stepper, *given, **more)
            self.steps += 1
            self.iterates += found.iterates if isinstance(found, State) else 0
            return found

        Stepper.step = counted
        try:
            return followed_limit(self.spec, self.section, np.asarray(load), anything_else(self.spec))
        finally:
            Stepper.step = step
