"""`simulate`: a grasp in MuJoCo, quasi-statically: squeeze, then weight and load; and compared with ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, check_number, read_only
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.grasp.model.request import check_load
from handlcp.grasp.path.follow import Loading
from handlcp.grasp.solution.verdict import HELD, NOT_HELD
from handlcp.record import Record as Told
from handlcp.simulator.settings import SimulatorSettings, require_hand_grasp
from handlcp.simulator.simulation_run import PUSH_STAGE, SimulationRecord, SimulationRun
from handlcp.words import wrap_text


@dataclass(frozen=True, eq=False, kw_only=True)
class Simulation(Told):
    """The end of a simulated loading. n contacts, the fingers' first; nv independent joints. World axes.

    held : whether the object is still in the hand, at rest, under all of the load.
    lost_stage, lost_at : where it was lost: the stage's name, and the share of that stage; None where it is held.
    forces_world (n, 3) [N] on the object. torques (nv,) [N·m] of the joints' springs.
    displacement (6,) [m, rad] of the object since the start: translation of the reference point, rotation vector.
    q (nv,) [rad, m] where the joints are. slip (n, 3) [m] of the object along each contact, summed over time.
    names : of the contacts. record : the same over time. simulated : [s]. seconds : [s] of MuJoCo's steps,
    without reading them.
    """

    entries = (
        "held",
        "lost_stage",
        "lost_at",
        "forces_N (n, 3) = forces_world",
        "torques_Nm (nv,)",
        "object_motion (6,) = displacement",
        "seconds",
        "simulated_s",
    )

    held: bool
    lost_stage: str | None
    lost_at: float | None
    forces_world: Array
    torques: Array
    displacement: Array
    q: Array
    slip: Array
    names: tuple[str, ...]
    record: SimulationRecord
    simulated: float
    seconds: float

    @property
    def word(self) -> str:
        """Either "HELD" or "NOT HELD": MuJoCo judges no torque limits."""
        return HELD if self.held else NOT_HELD

    @property
    def sentence(self) -> str:
        """What stands behind the word."""
        if self.held:
            return f"at rest after {self.simulated:.3g} s"
        return f"lost in stage {self.lost_stage!r} at {words.format_percent(self.lost_at or 0.0)}"

    def __repr__(self) -> str:
        where = "held" if self.held else f"lost at {self.lost_at:.1%} of {self.lost_stage}"
        return f"Simulation({where})"


def simulate(
    grasp: Grasp,
    load: Any = None,
    order: Sequence[str] | str = ("squeeze", "load"),
    *,
    seconds: float = 2.0,
    settle: float = 0.5,
    settings: SimulatorSettings | None = None,
) -> Simulation:
    """Load a grasp in MuJoCo, slowly enough to be static.

    load : (6,) force [N] and torque [N·m] on the object besides its weight at the end, of a planar grasp also (3,), as
        in `Grasp`; None: the grasp's own. The force acts at the point of the object that the reference is at the start;
        the torque keeps its axes in the world.
    order : ("squeeze", "load"): commands first, then the weight, then the load, as `Grasp.follow` has it; "together":
        all in proportion.
    seconds : of each stage, smooth at both ends; a stage waits while the object moves fast. settle : [s] to come to
        rest after each. settings : as in `to_mujoco`.

    Raises what `to_mujoco` raises; Unsupported where MuJoCo is not installed.
    """
    stages = ("together",) if order == "together" else () if isinstance(order, str) else tuple(order)
    if stages not in {("together",), ("squeeze", "load"), ("squeeze",)}:
        raise InputError("order", '("squeeze", "load"), ("squeeze",) or "together"', repr(order))
    seconds, settle = check_number("seconds", seconds, above=0.0), check_number("settle", settle, minimum=0.0)
    own = require_hand_grasp(grasp)
    run = SimulationRun(own, None if load is None else check_load(own.spec, load, "load"), settings)
    if stages[-1] == "load" and run.has_weight and run.wrench.any():  # the weight in a stage of its own
        stages = (*stages[:-1], "weight", PUSH_STAGE)
    held = all(run.run_stage(name, seconds, settle) for name in run.with_own_stages(stages))
    record = run.track.to_record()
    q, torques = run.probe.read_joints()
    stage, share = (None, None) if held else run.calm
    stage = "load" if stage == PUSH_STAGE else stage
    forces, motion = read_only(record.forces[-1]), read_only(record.motion[-1])
    return Simulation(
        held=held,
        lost_stage=stage,
        lost_at=share,
        forces_world=forces,
        torques=read_only(torques),
        displacement=motion,
        q=read_only(q),
        slip=read_only(run.slip),
        names=run.probe.names,
        record=record,
        simulated=float(run.data.time),
        seconds=run.seconds,
    )


# ----------------------------------------------------------------
# One grasp followed by handlcp and simulated by MuJoCo, side by side.


class AgreementTolerance(NamedTuple):
    """How far two ends may be apart that agree, each as `Comparison` has the error of that name. force : of the largest
    force. torque : of the largest torque. motion : of the object's motion. least : [m] that the object's place differs
    by whatever it moves: MuJoCo's contacts give way by so much.
    """

    force: float
    torque: float
    motion: float
    least: float

    def __str__(self) -> str:
        shares = f"forces {self.force:.0%}, torques {self.torque:.0%}, motion {self.motion:.0%}".replace("%", " %")
        return f"{shares} or {words.format_length(self.least)}"


AGREEMENT_TOLERANCE = AgreementTolerance(0.05, 0.05, 0.1, 2e-5)


@dataclass(frozen=True, eq=False)
class Comparison(Told):
    """A loading followed in steps, and the same in MuJoCo.

    loading, simulation : what each says. seconds : that `loading` took, the faster of two times.
    """

    entries = (
        "both_hold",
        "agree",
        "force_error",
        "torque_error",
        "motion_error",
        "tolerance.force = tolerance.force",
        "tolerance.torque = tolerance.torque",
        "tolerance.motion = tolerance.motion",
        "tolerance.least_m = tolerance.least",
        "contacts = simulation.names",
        "handlcp.held = loading.in_place",
        "handlcp.lost_stage = loading.lost_stage",
        "handlcp.lost_at = loading.lost_at",
        "handlcp.why = loading.why",
        "handlcp.forces_N (n, 3) = loading.solution.forces_world",
        "handlcp.torques_Nm (nv,) = loading.solution.torques",
        "handlcp.object_motion (6,) = loading.displacement",
        "handlcp.seconds = seconds",
        "mujoco = simulation",
    )

    loading: Loading
    simulation: Simulation
    seconds: float

    @property
    def agree(self) -> bool:
        """Whether both hold the object and end no farther apart than `tolerance`, or neither holds it."""
        if not self.both_hold:
            return self.loading.in_place == self.simulation.held
        most, motion = self.tolerance, self.loading.displacement[:3] - self.simulation.displacement[:3]
        near = bool(np.linalg.norm(motion) <= most.least) or self.motion_error <= most.motion
        return near and self.force_error <= most.force and self.torque_error <= most.torque

    @property
    def both_hold(self) -> bool:
        """Whether there are two ends to compare."""
        return self.loading.in_place and self.simulation.held

    @property
    def tolerance(self) -> AgreementTolerance:
        """How far two ends may be apart that agree."""
        return AGREEMENT_TOLERANCE

    @property
    def force_error(self) -> float:
        """Largest component of the difference of forces, as a share of the largest force; NaN unless both hold."""
        return self._error_share(self.loading.solution.forces_world, self.simulation.forces_world)

    @property
    def torque_error(self) -> float:
        """The same of the torques that the joints are driven with, what dry friction takes of them included."""
        return self._error_share(self.loading.steps.pulled[-1], self.simulation.torques)

    @property
    def motion_error(self) -> float:
        """Length of the difference of the object's translations, as a share of MuJoCo's; NaN unless both hold."""
        ours, theirs = self.loading.displacement[:3], self.simulation.displacement[:3]
        size = float(np.linalg.norm(theirs))
        return float(np.linalg.norm(ours - theirs)) / size if self.both_hold and size > 0.0 else np.nan

    def _error_share(self, ours: Array, theirs: Array) -> float:
        if not self.both_hold:
            return np.nan
        largest = float(np.linalg.norm(theirs, axis=-1).max() if theirs.ndim == 2 else abs(theirs).max())
        apart = float(abs(ours - theirs).max())
        return apart / largest if largest > 0.0 else np.inf if apart > 0.0 else 0.0

    def __repr__(self) -> str:
        return f"Comparison({str(self).partition(chr(10))[0]})"

    def __str__(self) -> str:
        """Whether both agree, within which tolerance; what each says, and how far they are apart."""
        found = [f"{'agree' if self.agree else 'DIFFER'} (tolerance: {self.tolerance})"]
        if self.both_hold:
            found.append(self.difference)
        ours, theirs = self.loading, self.simulation
        found += [f"handlcp: {ours.word}: {ours.sentence}", f"MuJoCo: {theirs.word}: {theirs.sentence}"]
        return "\n".join(wrap_text(line, "  ") for line in found)

    @property
    def difference(self) -> str:
        """How far both ends are apart, in words; "" unless both hold."""
        if not self.both_hold:
            return ""
        forces, torques, motion = (f"{100 * e:.2g} %" for e in (self.force_error, self.torque_error, self.motion_error))
        return f"forces {forces} of the largest force, torques {torques} of the largest torque, motion {motion}"


def compare(
    grasp: Grasp,
    load: Any = None,
    order: Any = ("squeeze", "load"),
    *,
    steps: int = 40,
    seconds: float = 2.0,
    settings: SimulatorSettings | None = None,
) -> Comparison:
    """Follow a grasp's loading, exact cone and moving geometry, and simulate the same in MuJoCo.

    load, order : as in `Grasp.follow`; order is ("squeeze", "load") or "together". steps : of each stage, of `follow`.
    seconds, settings : of each stage, and of the simulation, as in `simulate`.

    Raises what `Grasp.follow` and `simulate` raise.
    """
    simulation = simulate(require_hand_grasp(grasp), load, order, seconds=seconds, settings=settings)
    took = []
    for _ in range(2):  # the first time may compile kernels
        began = perf_counter()
        loading = grasp.follow(load, order, steps=steps, max_slip=np.inf)  # creeping, it comes to rest in both
        took.append(perf_counter() - began)
    return Comparison(loading, simulation, min(took))
