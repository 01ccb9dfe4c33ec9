"""The same grasp in MuJoCo, a simulator that is not ours: written as MJCF, and run slowly enough to be static."""

from handlcp.simulator.compare import Comparison, compare
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.run import Simulation, simulate
from handlcp.simulator.state import SimulatorState
from handlcp.simulator.write import to_mujoco

__all__ = ["Comparison", "Simulation", "SimulatorSettings", "SimulatorState", "compare", "simulate", "to_mujoco"]
