"""A loading for the terminal, and for machines."""

from __future__ import annotations

import platform
from dataclasses import asdict
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from handlcp import words
from handlcp.grasp import GraspSolution
from handlcp.grasp.path.events import summary
from handlcp.grasp.path.follow import Loading
from handlcp.show import tables
from handlcp.show.loading.end import moved, slipped, solution_at_end
from handlcp.show.loading.series import friction_used
from handlcp.study.plain import plain
from handlcp.tolerances import CERTIFY
from handlcp.version import VERSION

_AXES = "xyz"


def event_table(loading: Loading) -> Table | None:
    """What happens on the way, what several fingers do at one place in one line; None where nothing does."""
    told = summary(loading.events, loading.steps.grasp.spec)
    if not told:
        return None
    table = tables.empty("On the way")
    table.add_column("stage", overflow="fold")
    tables.numbers(table, "at")
    table.add_column("what happens", overflow="fold")
    for s in told:
        table.add_row(Text(s.stage), s.at, Text(s.sentence))
    return table


def end_tables(loading: Loading) -> list[Table]:
    """Contacts, joints and actuators at the last step; none where it has no certified answer."""
    solution = solution_at_end(loading)
    if not solution.held:
        return []
    when = "at the end" if loading.reached else "at the last step"
    return solution_tables(solution, f" {when}", True)


def solution_tables(solution: GraspSolution, when: str = "", whole: bool = False) -> list[Table]:
    """Contacts, joints and actuators; none where there is no answer. when : follows the titles. whole : whether slips
    are of the whole way.
    """
    if not solution.held:
        return []
    slips = float(np.hypot(*solution.slip.T).max(initial=0.0)) > CERTIFY * solution.residuals.motion_scale
    note = "slip: on the whole way" if whole and slips else ""
    found = [tables.contact_table(solution, f"Contacts{when}", note)]
    for part, table in (("torque_check", tables.torque_table), ("effort", tables.effort_table)):
        if (what := getattr(solution, part, None)) is not None:
            found.append(table(what))
            found[-1].title = f"{found[-1].title}{when}"
    return found


def motion(loading: Loading) -> str:
    """Of the object since the start, in words."""
    u = loading.displacement[:3]
    unit = words.length_unit([float(np.linalg.norm(u))])  # that of the whole way
    along = ", ".join(f"{axis} {unit(x)}" for axis, x in zip(_AXES, u.tolist(), strict=True))
    return f"the object has {moved(loading)} since the start ({along} {unit.name})"


def record(loading: Loading, title: str = "") -> dict[str, Any]:
    """Everything as one JSON object: SI units in the key names, null for what is not a finite number."""
    h, steps, mechanism = loading, loading.steps, loading.steps.grasp.spec.mechanism
    told = [asdict(s) | {"text": str(s)} for s in summary(h.events, h.steps.grasp.spec)]
    joints = None
    if mechanism is not None:
        joints = {
            "names": mechanism.names, "torque_limits_Nm": mechanism.limits, "torques_Nm": steps.torques,
            "command_rad": steps.command, "q_rad": steps.q,
        }  # fmt: skip
    found = {
        "title": title, "reached": h.reached, "lost_at": h.lost_at, "lost_stage": h.lost_stage, "why": h.why,
        "stages": h.stages, "geometry": "followed" if steps.geometry.follows else "fixed",
        "events": [asdict(e) for e in h.events], "summary": told,
        "object_displacement": {"linear_m": h.displacement[:3], "angular_rad": h.displacement[3:]},
        "status_at_end": h.solution.status.name,
        "steps": {
            "stage": steps.stage, "share": steps.share, "load_N_Nm": steps.load, "weight": steps.weight,
            "displacement_m_rad": steps.displacement,
        },
        "contacts": {
            "names": steps.names, "forces_N": steps.forces, "forces_world_N": steps.forces_world,
            "torsion_Nm": steps.torsion if h.steps.grasp.soft.size else None, "friction_used": friction_used(h),
            "state": steps.contact_state, "gap_m": steps.gap, "slip_m": steps.slip, "position_m": steps.positions,
            "slip_on_the_way_m": slipped(h),
        },
        "joints": joints,
        "versions": {"handlcp": VERSION, "python": platform.python_version(), "numpy": np.__version__},
    }  # fmt: skip
    return dict(plain(found))
