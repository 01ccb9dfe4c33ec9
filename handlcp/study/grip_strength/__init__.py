"""Grip strength as a cylinder of two halves measures it: the force across the split when the hand closes fully."""

from handlcp.study.grip_strength.across import Around
from handlcp.study.grip_strength.measure import split_cylinder
from handlcp.study.grip_strength.result import Grip, SplitCylinder

__all__ = ["Around", "Grip", "SplitCylinder", "split_cylinder"]
