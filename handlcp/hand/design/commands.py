"""How hard must the hand close? The least grip or squeeze, common to all fingers, with which a grasp holds."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.grasp.analysis.required import Required, tolerance_of
from handlcp.grasp.design.least import Changed, least_value
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.command import commanded
from handlcp.hand.design.brief import Case
from handlcp.hand.design.changed import gripped, hand_of
from handlcp.hand.design.required_torque import starts

_TIMES = 256.0  # the grip with which nothing slips: the most that is tried
_DEEPEST, _START = 0.05, 1e-3  # [m] of a squeeze


def required_grip(spec: GraspSpec, section: Section, tolerance: Any) -> Required:
    """See `HandGrasp.required_grip`."""
    k = spec.of_fingers
    start = float(starts((Case("", spec),), section, np.ones(len(hand_of(spec).names)))[-1].mean())
    changed = Changed(lambda force: gripped(spec, np.full(k, force)), section)
    return least_value(changed, start, _TIMES * start, tolerance_of(tolerance), "N")


def required_squeeze(spec: GraspSpec, section: Section, tolerance: Any) -> Required:
    """See `HandGrasp.required_squeeze`."""
    changed = Changed(lambda depth: commanded(spec, depth, None, None), section)
    return least_value(changed, _START, _DEEPEST, tolerance_of(tolerance), "m")
