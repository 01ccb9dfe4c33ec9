"""What the tests need of the simulator's inner rooms."""

from handlcp.simulator.limit import Tracking, moved
from handlcp.simulator.tips import pad_of
from handlcp.simulator.under_way import Run

__all__ = ["Run", "Tracking", "moved", "pad_of"]
