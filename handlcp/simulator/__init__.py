"""The same grasp in MuJoCo, a simulator that is not ours: written as MJCF, and run slowly enough to be static."""

from handlcp.simulator.compare import Comparison, compare
from handlcp.simulator.limit import SimulatedLimit, simulate_limit
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.run import Simulation, simulate
from handlcp.simulator.state import SimulatorState
from handlcp.simulator.write import to_mujoco

__all__ = [
    "Comparison", "SimulatedLimit", "Simulation", "SimulatorSettings", "SimulatorState", "compare", "simulate",
    "simulate_limit", "to_mujoco",
]  # fmt: skip
