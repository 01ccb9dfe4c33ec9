"""What the tests need of the simulator's inner rooms."""

from handlcp.simulator.load_limit import LimitTracker, relative_motion
from handlcp.simulator.object_body import pad_name
from handlcp.simulator.simulation_run import SimulationRun

__all__ = ["LimitTracker", "SimulationRun", "pad_name", "relative_motion"]
