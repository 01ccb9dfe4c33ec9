"""One grasp followed by handlcp and simulated by MuJoCo, side by side."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp import Grasp
from handlcp.grasp.path.follow import Loading
from handlcp.record import Record
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.refusals import of_a_hand
from handlcp.simulator.run import Simulation, simulate


@dataclass(frozen=True, eq=False)
class Comparison(Record):
    """A loading followed in steps, and the same in MuJoCo.

    loading, simulation : what each says. seconds : that `loading` took, the faster of two times.
    """

    entries = (
        "both_hold", "agree", "force_error", "torque_error", "motion_error", "contacts = simulation.names",
        "handlcp.held = loading.reached", "handlcp.lost_stage = loading.lost_stage",
        "handlcp.lost_at = loading.lost_at", "handlcp.why = loading.why",
        "handlcp.forces_N (n, 3) = loading.solution.forces_world",
        "handlcp.torques_Nm (nv,) = loading.solution.torques", "handlcp.object_motion (6,) = loading.displacement",
        "handlcp.seconds = seconds", "mujoco = simulation",
    )  # fmt: skip

    loading: Loading
    simulation: Simulation
    seconds: float

    @property
    def agree(self) -> bool:
        """Whether both hold the object, or both lose it."""
        return self.loading.reached == self.simulation.held

    @property
    def both_hold(self) -> bool:
        """Whether there are two ends to compare."""
        return self.loading.reached and self.simulation.held

    @property
    def force_error(self) -> float:
        """Largest component of the difference of forces, as a share of the largest force; NaN unless both hold."""
        return self._share(self.loading.solution.forces_world, self.simulation.forces_world)

    @property
    def torque_error(self) -> float:
        """The same of the joints' torques."""
        solution: Any = self.loading.solution
        return self._share(solution.torques, self.simulation.torques)

    @property
    def motion_error(self) -> float:
        """Length of the difference of the object's translations, as a share of MuJoCo's; NaN unless both hold."""
        ours, theirs = self.loading.displacement[:3], self.simulation.displacement[:3]
        size = float(np.linalg.norm(theirs))
        return float(np.linalg.norm(ours - theirs)) / size if self.both_hold and size > 0.0 else np.nan

    def _share(self, ours: Array, theirs: Array) -> float:
        if not self.both_hold:
            return np.nan
        largest = float(np.linalg.norm(theirs, axis=-1).max() if theirs.ndim == 2 else abs(theirs).max())
        return float(abs(ours - theirs).max()) / largest if largest > 0.0 else 0.0


def compare(
    grasp: Grasp, load: Any = None, order: Any = ("squeeze", "load"), *, steps: int = 40, seconds: float = 2.0,
    settings: SimulatorSettings | None = None,
) -> Comparison:  # fmt: skip
    """Follow a grasp's loading, exact cone and moving geometry, and simulate the same in MuJoCo.

    load, order : as in `Grasp.follow`; order is ("squeeze", "load") or "together". steps : of each stage, of `follow`.
    seconds, settings : of each stage, and of the simulation, as in `simulate`.

    Raises what `Grasp.follow` and `simulate` raise.
    """
    simulation = simulate(of_a_hand(grasp), load, order, seconds=seconds, settings=settings)
    took = []
    for _ in range(2):  # the first time may compile kernels
        began = perf_counter()
        loading = grasp.follow(load, order, steps=steps)
        took.append(perf_counter() - began)
    return Comparison(loading, simulation, min(took))
