"""A door into load limits: many directions at once."""

from __future__ import annotations

from typing import Any

import handlcp as hl
from handlcp.grasp.limits.directions import Limits, limits_of
from tests.support.grasp import section_of

__all__ = ["limits_of_grasp"]


def limits_of_grasp(grasp: hl.Grasp, wrenches: Any, faces: Any = "cone", geometry: str = "fixed") -> Limits:
    """Limits of loads (m, 6) in one call."""
    return limits_of(grasp.spec, section_of(grasp, faces), wrenches, geometry)
