"""A solved grasp for machines: everything that `handlcp solve` prints, as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.grasp import Explanation, Grasp, GraspSolution, Loading, Suggestions, Verdict
from handlcp.record import columns, pick, plain, rows, versions
from handlcp.show.loading.series import grasp_at_end, solution_at_end


def record(
    grasp: Grasp,
    solution: GraspSolution,
    explanation: Explanation,
    left_out: Suggestions | None = None,
    verdict: Verdict | None = None,
) -> dict[str, Any]:
    """Everything `handlcp solve` prints, and the residuals behind it. verdict : of `check`; None: the solution's.

    "contacts", "torques" and "object_displacement" are the solution's; those at the end of the loading that `check`
    followed stand under "loading".
    """
    s, scene = solution, grasp.scene
    verdict = s.verdict if verdict is None else verdict
    torque = scene.moment - np.cross(grasp.reference, scene.force)
    line = "title", "on", "why", "equation", "unknowns = cost", "share_of_solve = share", "answers"
    found = {
        **pick(s, "status", "diagnosis"),
        "verdict": verdict,
        "load": {"force_N": scene.force, "torque_Nm": torque, "reference_m": grasp.reference},
        "effects": [pick(e, *line) for e in explanation.effects],
        "problem": pick(explanation, "unknowns", "eliminated", "rcond", "solved = size", "solve_s = seconds"),
        "contacts": _contacts(grasp, s),
        **pick(s, "object_displacement (twist)"),
        "torques": _torques(s),
        "actuators": getattr(s, "effort", None),
        "residuals": plain(s.residuals) | {"worst": s.residuals.worst},
        **pick(s, "uniqueness", "certificate (twist)"),
        "cause": None if s.held else s.cause or s.diagnosis,
        **pick(s, "yielding", "required_preload_m"),
        "proven_within": None if s.bounds is None else {"force_N": s.bounds[0], "motion_m": s.bounds[1]},
        **pick(s, "extra", "accuracy"),
        "loading": None if verdict.loading is None else _followed(verdict.loading),
        "left_out": left_out,
        **pick(s, "iterations", "trace"),
        "versions": versions("numpy", "scipy", "numba", "pin"),
    }
    return dict(plain(found))


def _followed(loading: Loading) -> dict[str, Any]:
    """How a followed loading ends; the contacts and torques at its last step, where that is an answer."""
    end = solution_at_end(loading)
    told = pick(
        loading, "word", "held", "reached", "lost_at", "lost_stage", "why", "object_displacement (twist) = displacement"
    )
    if not end.held:
        return told | {"contacts": None, "torques": None}
    return told | {"contacts": _contacts(grasp_at_end(loading), end), "torques": _torques(end)}


def _contacts(grasp: Grasp, s: GraspSolution) -> list[dict[str, Any]]:
    """Forces, friction, slip and gap of each contact, as plain data."""
    scene = grasp.scene
    every: dict[str, Any] = {
        "name": s.names,
        "environment": np.arange(scene.n) >= scene.n - scene.environment,
        "position_m": scene.positions,
        "axes": np.swapaxes(grasp.frames, 1, 2),
        "friction": [c.mu for c in grasp.contacts],
        "state": s.contact_state,
        "force_N": s.forces,
        "force_world_N": s.forces_world,
        "friction_used": s.friction_used,
        "friction_margin_N": s.friction_margin,
        "slip_m": s.slip if scene.plane is None else s.slip[:, :1],
        "gap_m": s.gap,
    }
    if s.torsion is not None:
        every |= columns(s, "torsion_Nm", "spin_rad")
    return rows(every)


def _torques(solution: GraspSolution) -> list[dict[str, Any]] | None:
    """Torque, limit and share of it of each joint, as plain data; None without a hand."""
    check, yielded = (getattr(solution, name, None) for name in ("torque_check", "joint_yield"))
    if check is None or yielded is None:
        return None
    lines = "joint = joints", "torque_Nm", "limit_Nm", "limit_known = known", "utilisation", "margin_Nm"
    binding = [name == check.binding for name in check.joints]
    every = columns(check, *lines) | {"binding": binding, "yield_rad": yielded}
    return rows(every | {"utilisation": np.where(check.known, check.utilisation, np.nan)})
