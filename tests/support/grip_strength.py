"""Doors into a split cylinder: the contacts around an axis, and a grip that is closed with full torque."""

from __future__ import annotations

from handlcp.study.grip_strength.across import Around
from handlcp.study.grip_strength.full_torque import closed

__all__ = ["Around", "closed"]
