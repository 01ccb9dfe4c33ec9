"""What the tests need of the simulator's inner rooms."""

from handlcp.simulator.limit import Tracking, moved

__all__ = ["Tracking", "moved"]
