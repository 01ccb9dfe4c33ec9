"""A solved grasp for machines: one JSON object, SI units in the key names, null for what is not a finite number."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from handlcp.grasp import Explanation, Grasp, GraspSolution, Suggestions
from handlcp.show.tables import friction_used
from handlcp.show.verdict import verdict
from handlcp.version import VERSION

__all__ = ["clean", "record"]


def record(
    grasp: Grasp,
    solution: GraspSolution,
    explanation: Explanation,
    title: str = "",
    left_out: Suggestions | None = None,
) -> dict[str, Any]:
    """Everything `handlcp solve` prints, and the residuals behind it."""
    v, u, scene = verdict(grasp, solution), solution.object_displacement, grasp.scene
    certificate = None
    if solution.certificate is not None:
        certificate = {"linear_m": solution.certificate[:3], "angular_rad": solution.certificate[3:]}
    bounds = None if solution.bounds is None else dict(zip(("force_N", "motion_m"), solution.bounds, strict=True))
    return dict(
        clean(
            {
                "title": title,
                "status": solution.status.name,
                "verdict": {"word": v.word, "text": v.text, "notes": v.notes, "exit_code": v.exit_code},
                "load": {"force_N": scene.force, "torque_Nm": _torque(grasp), "reference_m": grasp.reference},
                "effects": [
                    {
                        "title": e.title,
                        "on": e.on,
                        "why": e.why,
                        "equation": e.equation,
                        "unknowns": e.cost,
                        "share_of_solve": e.share,
                    }
                    for e in explanation.effects
                ],
                "problem": {
                    "unknowns": explanation.unknowns,
                    "eliminated": explanation.eliminated,
                    "solved": explanation.size,
                    "rcond": explanation.rcond,
                    "solve_s": explanation.seconds,
                },
                "contacts": _contacts(grasp, solution),
                "object_displacement": {"linear_m": u[:3], "angular_rad": u[3:]},
                "torques": _torques(solution),
                "actuators": _actuators(solution),
                "residuals": asdict(solution.residuals) | {"worst": solution.residuals.worst},
                "uniqueness": None if solution.uniqueness is None else asdict(solution.uniqueness),
                "certificate": certificate,
                "required_preload_m": solution.required_preload,
                "proven_within": bounds,
                "extra": solution.extra,
                "accuracy": _accuracy(solution),
                "left_out": None if left_out is None else asdict(left_out),
                "iterations": solution.iterations,
                "trace": solution.trace,
                "versions": {
                    "handlcp": VERSION,
                    "python": platform.python_version(),
                    **{name: _version(name) for name in ("numpy", "scipy", "numba", "pin")},
                },
            }
        )
    )


def clean(value: Any) -> Any:
    """Plain JSON values: arrays become lists, numbers that are not finite become None."""
    if isinstance(value, Mapping):
        return {str(k): clean(v) for k, v in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [clean(v) for v in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return value if value is None or isinstance(value, str) else str(value)


def _contacts(grasp: Grasp, solution: GraspSolution) -> list[dict[str, Any]]:
    used, planar = friction_used(grasp, solution), grasp.scene.plane is not None
    return [
        {
            "name": name,
            "environment": i >= grasp.scene.n - grasp.scene.environment,
            "position_m": grasp.scene.positions[i],
            "axes": grasp.frames[i].T,
            "friction": grasp.contacts[i].mu,
            "state": solution.contact_state[i],
            "force_N": solution.forces[i],
            "force_world_N": solution.forces_world[i],
            "friction_used": used[i],
            "slip_m": solution.slip[i] if not planar else solution.slip[i][:1],
            "gap_m": solution.gap[i],
        }
        | _moments(solution, i)
        for i, name in enumerate(solution.names)
    ]


def _moments(solution: GraspSolution, i: int) -> dict[str, Any]:
    """Of soft fingers."""
    if solution.torsion is None or solution.spin is None:
        return {}
    return {"torsion_Nm": solution.torsion[i], "spin_rad": solution.spin[i]}


def _torques(solution: GraspSolution) -> list[dict[str, Any]] | None:
    check: Any = getattr(solution, "torque_check", None)
    if check is None:
        return None
    return [
        {
            "joint": r.joint,
            "torque_Nm": r.torque,
            "limit_Nm": r.limit,
            "utilisation": r.utilisation if r.known else None,
            "limit_known": r.known,
            "binding": r.joint == check.binding,
            "yield_rad": float(y),
        }
        for r, y in zip(check, vars(solution)["joint_yield"], strict=True)
    ]


def _actuators(solution: GraspSolution) -> dict[str, Any] | None:
    """What tendons or synergies do."""
    effort: Any = getattr(solution, "effort", None)
    if effort is None:
        return None
    return {"kind": effort.kind, "unit": effort.unit, "each": dict(zip(effort.names, effort.values, strict=True))}


def _accuracy(solution: GraspSolution) -> dict[str, Any] | None:
    """What was asked for and reached."""
    a = solution.accuracy
    if a is None:
        return None
    return {
        "asked": a.asked, "error": a.error, "met": a.met, "setting": a.setting, "solves": a.solves, "seconds": a.seconds
    }  # fmt: skip


def _torque(grasp: Grasp) -> Any:
    """(3,) the load's torque about the grasp's reference."""
    return grasp.scene.moment - np.cross(grasp.reference, grasp.scene.force)


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
