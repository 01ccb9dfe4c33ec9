"""Grip strength as a cylinder of two halves measures it: the force across the split when the hand closes fully."""

from handlcp.studies.grip_strength.measure import split_cylinder
from handlcp.studies.grip_strength.result import Grip, SplitCylinder
from handlcp.studies.grip_strength.split_force import ContactsAroundAxis

__all__ = ["ContactsAroundAxis", "Grip", "SplitCylinder", "split_cylinder"]
