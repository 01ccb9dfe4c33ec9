"""How much a grasp holds in each direction, what gives out first, and what passive compliance gives away."""

from handlcp.study.envelope.causes import Compliance, Sector
from handlcp.study.envelope.measure import envelope
from handlcp.study.envelope.result import Envelope, Extreme

__all__ = ["Compliance", "Envelope", "Extreme", "Sector", "envelope"]
