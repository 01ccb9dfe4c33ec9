"""Tests of hands that others publish, as calls: how hard a finger presses, when an object slips, lift and shake."""

from handlcp.studies.published.finger_strength import FingerForce, FingerStrength, finger_strength
from handlcp.studies.published.lift_and_shake import LiftAndShake, ShakenObject, lift_and_shake
from handlcp.studies.published.slip_resistance import SlipResistance, slip_resistance

__all__ = [
    "FingerForce",
    "FingerStrength",
    "LiftAndShake",
    "ShakenObject",
    "SlipResistance",
    "finger_strength",
    "lift_and_shake",
    "slip_resistance",
]
