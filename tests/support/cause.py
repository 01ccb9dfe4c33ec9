"""Doors into the judge of states and its words."""

from __future__ import annotations

from handlcp.grasp.failure.failure_mode import (
    EQUILIBRIUM,
    MOTION,
    OBJECT,
    OPENS,
    RANGE,
    SLIDES,
    SLIPS,
    TORQUE,
    UNDECIDED,
    FailureMode,
    StateLimits,
    find_binding,
    find_exceeded,
    find_slide_through,
    find_slipping,
    is_exceeded,
    limit_shares,
    state_limits,
)
from handlcp.grasp.failure.failure_text import (
    describe_event,
    describe_failures,
    describe_load,
    describe_load_share,
    describe_names,
    explain_limit,
    explain_loss,
)
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

__all__ = [
    "EQUILIBRIUM", "MOTION", "OBJECT", "OPENS", "OVER_LIMIT_TOLERANCE", "RANGE", "SLIDES", "SLIPS", "TORQUE",
    "UNDECIDED", "FailureMode", "StateLimits", "describe_event", "describe_failures", "describe_load",
    "describe_load_share", "describe_names", "explain_limit", "explain_loss", "find_binding", "find_exceeded",
    "find_slide_through", "find_slipping", "is_exceeded", "limit_shares", "state_limits",
]  # fmt: skip
