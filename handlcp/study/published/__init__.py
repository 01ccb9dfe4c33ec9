"""Tests of hands that others publish, as calls: how hard a finger presses, when an object slips, lift and shake."""

from handlcp.study.published.finger_result import FingerForce, FingerStrength
from handlcp.study.published.finger_strength import finger_strength
from handlcp.study.published.lift_and_shake import lift_and_shake
from handlcp.study.published.lift_result import LiftAndShake, Shaken
from handlcp.study.published.slip_resistance import SlipResistance, slip_resistance

__all__ = [
    "FingerForce",
    "FingerStrength",
    "LiftAndShake",
    "Shaken",
    "SlipResistance",
    "finger_strength",
    "lift_and_shake",
    "slip_resistance",
]
