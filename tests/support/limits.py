"""Doors into load limits: many directions at once, and the limit in steps."""

from __future__ import annotations

from typing import Any

import numpy as np

import handlcp as hl
from handlcp.grasp.limits.directions import Limits, limits_of
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.limits.stepped import stepped_limit
from tests.support.grasp import section_of

__all__ = ["limits_in_steps", "limits_of_grasp"]


def limits_of_grasp(grasp: hl.Grasp, wrenches: Any, faces: Any = "cone", geometry: str = "fixed") -> Limits:
    """Limits of loads (m, 6) in one call."""
    return limits_of(grasp.spec, section_of(grasp, faces), wrenches, geometry)


def limits_in_steps(grasp: hl.Grasp, wrench: Any, faces: Any = "cone") -> LoadLimit:
    """What `load_limit` with fixed geometry falls back to."""
    return stepped_limit(grasp.spec, section_of(grasp, faces), np.asarray(wrench), (np.inf, np.inf))
