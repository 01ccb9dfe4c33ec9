"""Doors into the judge of states and its words."""

from __future__ import annotations

from handlcp.grasp.cause.judge import (
    EQUILIBRIUM,
    MOTION,
    OBJECT,
    OPENS,
    RANGE,
    SLIDES,
    SLIPS,
    TORQUE,
    UNDECIDED,
    Cause,
    Limits,
    binding,
    exceeded,
    limits_of,
    over,
    slides_through,
    slipping,
    used,
)
from handlcp.grasp.cause.wording import amount, called, happens, said, under_load, why, why_lost
from handlcp.tolerances import OVER

__all__ = [
    "EQUILIBRIUM", "MOTION", "OBJECT", "OPENS", "OVER", "RANGE", "SLIDES", "SLIPS", "TORQUE", "UNDECIDED", "Cause",
    "Limits", "amount", "binding", "called", "exceeded", "happens", "limits_of", "over", "said", "slides_through",
    "slipping", "under_load", "used", "why", "why_lost",
]  # fmt: skip
