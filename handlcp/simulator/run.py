"""A grasp in MuJoCo, quasi-statically: the hand squeezes, then weight and load come, all slowly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.record import Record as Told
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.under_way import PUSH, Record, Run


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
        "held", "lost_stage", "lost_at", "forces_N (n, 3) = forces_world", "torques_Nm (nv,)",
        "object_motion (6,) = displacement", "seconds", "simulated_s",
    )  # fmt: skip

    held: bool
    lost_stage: str | None
    lost_at: float | None
    forces_world: Array
    torques: Array
    displacement: Array
    q: Array
    slip: Array
    names: tuple[str, ...]
    record: Record
    simulated: float
    seconds: float

    def __repr__(self) -> str:
        where = "held" if self.held else f"lost at {self.lost_at:.1%} of {self.lost_stage}"
        return f"Simulation({where})"


def simulate(
    grasp: Grasp, load: Any = None, order: Sequence[str] | str = ("squeeze", "load"), *, seconds: float = 2.0,
    settle: float = 0.5, settings: SimulatorSettings | None = None,
) -> Simulation:  # fmt: skip
    """Load a grasp in MuJoCo, slowly enough to be static.

    load : (6,) force [N] and torque [N·m] on the object besides its weight at the end; None: the grasp's own. The force
        acts at the point of the object that the reference is at the start; the torque keeps its axes in the world.
    order : ("squeeze", "load"): commands first, then the weight, then the load, as `Grasp.follow` has it; "together":
        all in proportion.
    seconds : of each stage, smooth at both ends; a stage waits while the object moves fast. settle : [s] to come to
        rest after each. settings : as in `to_mujoco`.

    Raises what `to_mujoco` raises; Unsupported where MuJoCo is not installed.
    """
    stages = _stages(order)
    seconds, settle = number("seconds", seconds, above=0.0), number("settle", settle, minimum=0.0)
    run = Run(grasp, None if load is None else array("load", load, (6,)), settings)
    if stages[-1] == "load" and run.weighs and run.wrench.any():  # the weight in a stage of its own
        stages = (*stages[:-1], "weight", PUSH)
    held = all(run.stage(name, seconds, settle) for name in (*run.before, *stages))
    record = run.track.record()
    q, torques = run.probe.joints()
    stage, share = (None, None) if held else run.calm
    stage = "load" if stage == PUSH else stage
    forces, motion = read_only(record.forces[-1]), read_only(record.motion[-1])
    return Simulation(
        held=held, lost_stage=stage, lost_at=share, forces_world=forces, torques=read_only(torques),
        displacement=motion, q=read_only(q), slip=read_only(run.slip), names=run.probe.names, record=record,
        simulated=float(run.data.time), seconds=run.seconds,
    )  # fmt: skip


def _stages(order: Any) -> tuple[str, ...]:
    if order == "together":
        return ("together",)
    if not isinstance(order, str) and tuple(order) in {("squeeze", "load"), ("squeeze",)}:
        return tuple(order)
    raise InputError("order", '("squeeze", "load"), ("squeeze",) or "together"', repr(order))
