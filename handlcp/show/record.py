"""Answers as plain data: dictionaries, JSON, data frames."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError, Unsupported
from handlcp.grasp import Explanation, Grasp, GraspSolution, Loading, Suggestions, Verdict
from handlcp.show.loading.series import grasp_at_end, solution_at_end
from handlcp.study.plain import pick, plain
from handlcp.version import VERSION
from handlcp.words import distinct

# ----------------------------------------------------------------
# Tables for pandas, which is imported when one is asked for.

Frame = Any  # pandas'


def data_frame(columns: Mapping[str, Any], index: Any = None) -> Frame:
    """A `pandas.DataFrame`. Raises Unsupported when pandas is not installed."""
    try:
        from pandas import DataFrame
    except ImportError:
        raise Unsupported("tables need pandas: pip install 'handlcp[table]'") from None
    return DataFrame(dict(columns), index=index)


def solution_frame(solution: GraspSolution, of: str) -> Frame:
    """See `GraspSolution.to_frame`."""
    if of == "contacts":
        return data_frame(_contacts(solution), distinct(solution.names))
    check, yielded = (getattr(solution, name, None) for name in ("torque_check", "joint_yield"))
    if of != "joints" or check is None:
        expected = '"contacts"' if check is None else '"contacts" or "joints"'
        raise InputError("of", f"{expected}{' for a grasp without a hand' if check is None else ''}", repr(of))
    columns = {
        "torque_Nm": check.torque, "limit_Nm": check.limit, "utilisation": check.utilisation,
        "margin_Nm": check.margin, "yield_rad": yielded,
    }  # fmt: skip
    return data_frame(columns, list(check.joints))


def _contacts(s: GraspSolution) -> dict[str, Any]:
    found: dict[str, Any] = {
        "state": list(s.contact_state), "normal_N": s.normal_force, "friction_N": np.hypot(*s.tangential_force.T),
        "friction_used": s.friction_used, "friction_margin_N": s.friction_margin, "slip_m": np.hypot(*s.slip.T),
        "gap_m": s.gap,
    }  # fmt: skip
    found |= _along(s.forces, "") | _along(s.forces_world, "world_")
    if s.torsion is not None:
        found |= {"moment_Nm": s.torsion, "spin_rad": s.spin}
    return found


def _along(forces: Array, prefix: str) -> dict[str, Array]:
    return {f"{prefix}{axis}_N": forces[:, k] for k, axis in enumerate("xyz")}


# ----------------------------------------------------------------
# A solved grasp for machines: one JSON object, SI units in the key names, null for what is not a finite number.


def record(
    grasp: Grasp,
    solution: GraspSolution,
    explanation: Explanation,
    title: str = "",
    left_out: Suggestions | None = None,
    verdict: Verdict | None = None,
) -> dict[str, Any]:
    """Everything `handlcp solve` prints, and the residuals behind it. verdict : of `check`; None: the solution's.

    "contacts", "torques" and "object_displacement" are the solution's; those at the end of the loading that `check`
    followed stand under "loading".
    """
    s, scene, reached = solution, grasp.scene, solution.accuracy
    verdict = s.verdict if verdict is None else verdict
    torque = scene.moment - np.cross(grasp.reference, scene.force)
    line = {"unknowns": "cost", "share_of_solve": "share"}
    packages = {name: _version(name) for name in ("numpy", "scipy", "numba", "pin")}
    found = {
        "title": title,
        "status": s.status.name,
        "diagnosis": s.diagnosis,
        "verdict": verdict.to_dict(),
        "load": {"force_N": scene.force, "torque_Nm": torque, "reference_m": grasp.reference},
        "effects": [pick(e, "title", "on", "why", "equation", **line) for e in explanation.effects],
        "problem": pick(explanation, "unknowns", "eliminated", "rcond", solved="size", solve_s="seconds"),
        "contacts": [_contact(grasp, s, i) for i in range(scene.n)],
        "object_displacement": _twist(s.object_displacement),
        "torques": _torques(s),
        "actuators": _actuators(s),
        "residuals": asdict(s.residuals) | {"worst": s.residuals.worst},
        "uniqueness": None if s.uniqueness is None else asdict(s.uniqueness),
        "certificate": None if s.certificate is None else _twist(s.certificate),
        "cause": None if s.held else s.cause or s.diagnosis,
        "yielding": s.yielding,
        "required_preload_m": s.required_preload,
        "proven_within": None if s.bounds is None else {"force_N": s.bounds[0], "motion_m": s.bounds[1]},
        "extra": s.extra,
        "accuracy": None if reached is None else pick(reached, "asked", "error", "met", "setting", "solves", "seconds"),
        "loading": None if verdict.loading is None else _followed(verdict.loading),
        "left_out": None if left_out is None else left_out.to_dict(),
        "iterations": s.iterations,
        "trace": s.trace,
        "versions": {"handlcp": VERSION, "python": platform.python_version()} | packages,
    }
    return dict(plain(found))


def _followed(loading: Loading) -> dict[str, Any]:
    """How a followed loading ends; the contacts and torques at its last step, where that is an answer."""
    end = solution_at_end(loading)
    told = pick(loading, "reached", "lost_at", "lost_stage", "why") | {
        "object_displacement": _twist(loading.displacement), "contacts": None, "torques": None,
    }  # fmt: skip
    if not end.held:
        return told
    there = grasp_at_end(loading)
    return told | {"contacts": [_contact(there, end, i) for i in range(there.scene.n)], "torques": _torques(end)}


def _twist(twist: Any) -> dict[str, Any]:
    """A motion (6,)."""
    return {"linear_m": twist[:3], "angular_rad": twist[3:]}


def _contact(grasp: Grasp, s: GraspSolution, i: int) -> dict[str, Any]:
    planar = grasp.scene.plane is not None
    found = {
        "name": s.names[i],
        "environment": i >= grasp.scene.n - grasp.scene.environment,
        "position_m": grasp.scene.positions[i],
        "axes": grasp.frames[i].T,
        "friction": grasp.contacts[i].mu,
        "state": s.contact_state[i],
        "force_N": s.forces[i],
        "force_world_N": s.forces_world[i],
        "friction_used": s.friction_used[i],
        "friction_margin_N": s.friction_margin[i],
        "slip_m": s.slip[i][:1] if planar else s.slip[i],
        "gap_m": s.gap[i],
    }
    if s.torsion is not None and s.spin is not None:
        found |= {"torsion_Nm": s.torsion[i], "spin_rad": s.spin[i]}
    return found


def _torques(solution: GraspSolution) -> list[dict[str, Any]] | None:
    """Joint by joint; None without a hand."""
    check, yielded = (getattr(solution, name, None) for name in ("torque_check", "joint_yield"))
    if check is None or yielded is None:
        return None
    return [
        pick(row, "joint", torque_Nm="torque", limit_Nm="limit", limit_known="known")
        | {"utilisation": row.utilisation if row.known else None, "margin_Nm": margin}
        | {"binding": row.joint == check.binding, "yield_rad": y}
        for row, margin, y in zip(check, check.margin, yielded, strict=True)
    ]


def _actuators(solution: GraspSolution) -> dict[str, Any] | None:
    """Forces or displacements of tendons or synergies; None where each joint has its own motor."""
    effort: Any = getattr(solution, "effort", None)
    if effort is None:
        return None
    return pick(effort, "kind", "unit") | {"each": dict(zip(effort.names, effort.values, strict=True))}


def _version(name: str) -> str | None:
    from importlib.metadata import PackageNotFoundError, version  # for JSON alone

    try:
        return version(name)
    except PackageNotFoundError:
        return None
