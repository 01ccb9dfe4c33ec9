"""Doors into a split cylinder: the contacts around an axis, and a grip that is closed with full torque."""

from __future__ import annotations

from handlcp.studies.grip_strength.measure import close_with_full_torque
from handlcp.studies.grip_strength.split_force import ContactsAroundAxis

__all__ = ["ContactsAroundAxis", "close_with_full_torque"]
