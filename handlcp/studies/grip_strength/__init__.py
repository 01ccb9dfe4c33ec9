"""Grip strength as a cylinder of two halves measures it: the force across the split when the hand closes fully."""

from handlcp.studies.grip_strength.measure import split_cylinder
from handlcp.studies.grip_strength.result import ContactsAroundAxis, Grip, SplitCylinder

__all__ = ["ContactsAroundAxis", "Grip", "SplitCylinder", "split_cylinder"]
