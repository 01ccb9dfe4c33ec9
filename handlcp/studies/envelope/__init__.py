"""How much a grasp holds in each direction, what gives out first, and what passive compliance gives away."""

from handlcp.studies.envelope.direction import Compliance, Sector
from handlcp.studies.envelope.measure import envelope
from handlcp.studies.envelope.result import Envelope, Extreme

__all__ = ["Compliance", "Envelope", "Extreme", "Sector", "envelope"]
