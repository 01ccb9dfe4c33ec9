"""The same grasp in MuJoCo, a simulator that is not ours: written as MJCF, and run slowly enough to be static."""

from handlcp.simulator.export import SimulatorState, to_mujoco
from handlcp.simulator.load_limit import SimulatedLimit, simulate_limit
from handlcp.simulator.run import Comparison, Simulation, compare, simulate
from handlcp.simulator.settings import SimulatorSettings

__all__ = [
    "Comparison",
    "SimulatedLimit",
    "Simulation",
    "SimulatorSettings",
    "SimulatorState",
    "compare",
    "simulate",
    "simulate_limit",
    "to_mujoco",
]
