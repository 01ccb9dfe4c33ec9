"""The same grasp in MuJoCo, a simulator that is not ours: written as MJCF, and run slowly enough to be static."""

from handlcp.simulator.run import Simulation, simulate
from handlcp.simulator.settings import SimulatorSettings
from handlcp.simulator.state import SimulatorState
from handlcp.simulator.write import to_mujoco

__all__ = ["Simulation", "SimulatorSettings", "SimulatorState", "simulate", "to_mujoco"]
