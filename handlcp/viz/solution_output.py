"""`solution_record`: a solved grasp for machines: everything that `handlcp solve` prints, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from handlcp.errors import InputError
from handlcp.grasp import Explanation, Grasp, GraspSolution, Suggestions, Verdict
from handlcp.grasp.solution.solution import contact_text_table
from handlcp.hand.hand_grasp import make_grasp
from handlcp.record import columns_from_arrays, package_versions, pick_entries, rows_from_columns, to_plain
from handlcp.viz.loading.curves import grasp_at_end, solution_at_end
from handlcp.viz.style import BAD_COLOUR, WORD_COLOURS
from handlcp.words import TextTable


def solution_to_dict(solution: GraspSolution) -> dict[str, Any]:
    """Everything about a solution as plain data: see `GraspSolution.to_dict`."""
    grasp = grasp_of_solution(solution)
    return solution_record(grasp, solution, grasp.explain())


def grasp_of_solution(solution: GraspSolution) -> Grasp:
    """The grasp that a solution answers. Raises InputError for one that does not know what was solved."""
    spec = solution.spec
    if spec is None:
        raise InputError("solution", "one made by grasp.solve()", "one that does not know its grasp")
    return make_grasp(spec)


def solution_record(
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
    at_end, loading = None, verdict.loading
    if loading is not None:  # how it ends; contacts and torques at its last step, where that is an answer
        end, twist = solution_at_end(loading), "object_displacement (twist) = displacement"
        at_end = pick_entries(loading, "word", "held", "reached", "lost_at", "lost_stage", "why", twist)
        at_end["contacts"] = _contact_records(grasp_at_end(loading), end) if end.held else None
        at_end["torques"] = _torque_records(end) if end.held else None
    line = "title", "on", "why", "equation", "unknowns = cost", "share_of_solve = share", "answers"
    found = {
        **pick_entries(s, "status", "diagnosis"),
        "verdict": verdict,
        "load": {"force_N": scene.force, "torque_Nm": torque, "reference_m": grasp.reference},
        "effects": [pick_entries(e, *line) for e in explanation.effects],
        "problem": pick_entries(explanation, "unknowns", "eliminated", "rcond", "solved = size", "solve_s = seconds"),
        "contacts": _contact_records(grasp, s),
        **pick_entries(s, "object_displacement (twist)"),
        "torques": _torque_records(s),
        "actuators": getattr(s, "effort", None),
        "residuals": to_plain(s.residuals) | {"worst": s.residuals.worst},
        **pick_entries(s, "uniqueness", "certificate (twist)"),
        "cause": None if s.held else s.cause or s.diagnosis,
        **pick_entries(s, "yielding", "required_preload_m"),
        "proven_within": None if s.bounds is None else {"force_N": s.bounds[0], "motion_m": s.bounds[1]},
        **pick_entries(s, "extra", "accuracy"),
        "loading": at_end,
        "left_out": left_out,
        **pick_entries(s, "iterations", "trace"),
        "versions": package_versions("numpy", "scipy", "numba", "pin"),
    }
    return dict(to_plain(found))


def _contact_records(grasp: Grasp, s: GraspSolution) -> list[dict[str, Any]]:
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
        every |= columns_from_arrays(s, "torsion_Nm", "spin_rad")
    return rows_from_columns(every)


def _torque_records(solution: GraspSolution) -> list[dict[str, Any]] | None:
    """Torque, limit and share of it of each joint, as plain data; None without a hand."""
    check, yielded = (getattr(solution, name, None) for name in ("torque_check", "joint_yield"))
    if check is None or yielded is None:
        return None
    lines = "joint = joints", "torque_Nm", "limit_Nm", "limit_known = known", "utilisation", "margin_Nm"
    binding = [name == check.binding for name in check.joints]
    every = columns_from_arrays(check, *lines) | {"binding": binding, "yield_rad": yielded}
    return rows_from_columns(every | {"utilisation": np.where(check.known, check.utilisation, np.nan)})


# ----------------------------------------------------------------
# A solution for notebooks: the verdict, the contacts and the joints as one piece of HTML with its style in it.


_CELL_STYLE = "padding:2px 10px 2px 0;border:none;background:none;white-space:nowrap"
_HEAD_RULE_STYLE = "border-bottom:1px solid #8886"


def solution_html(solution: GraspSolution) -> str:
    """A solution as one piece of HTML: verdict, contacts and joint torques, as a notebook shows it.

    Colours are readable on white and on black.
    """
    (word, text), *rest = solution.verdict.paragraphs
    colour = WORD_COLOURS.get(word, BAD_COLOUR).lower()
    parts = [f'<p style="margin:0 0 6px"><b style="color:{colour}">{escape(word)}</b>: {escape(text)}.</p>']
    parts += [f'<p style="margin:0 0 6px"><b>{escape(head)}</b>: {escape(said)}.</p>' for head, said in rest]
    if solution.held:
        parts.append(table_html(contact_text_table(solution)))
        if (check := getattr(solution, "torque_check", None)) is not None:
            parts.append(table_html(check.table, [_torque_bar(r) for r in check]))
    return f'<div style="max-width:46em">{"".join(parts)}</div>'


def table_html(table: TextTable, bars: Sequence[str] = ()) -> str:
    """A text table as a table in HTML, for notebooks; bars : what stands behind each row, none for none."""
    ways = ["right" if way == ">" else "left" for way in table.align]
    heads = "".join(
        f'<th style="{_CELL_STYLE};{_HEAD_RULE_STYLE};text-align:{way};font-weight:600;vertical-align:bottom">'
        f"{escape(head).replace(chr(10), '<br>')}</th>"
        for head, way in zip(table.heads, ways, strict=True)
    )
    lines = []
    for row, bar in zip(table.rows, bars or [""] * len(table.rows), strict=True):
        cells = [
            f'<td style="{_CELL_STYLE};text-align:{way};font-variant-numeric:tabular-nums">{escape(cell)}</td>'
            for cell, way in zip(row, ways, strict=True)
        ]
        last = cells[-1].replace('">', f'">{bar}', 1) if bar else cells[-1]  # the bar before its words
        lines.append(f"<tr>{''.join(cells[:-1])}{last}</tr>")
    body = "".join(lines)
    return (
        '<table style="border-collapse:collapse;border:none;margin:0 0 8px;font-size:90%">'
        f"<thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"
    )


def _torque_bar(row: Any) -> str:
    """How much of its limit a joint uses; nothing where none is known."""
    if not (row.known and np.isfinite(row.limit)):
        return ""
    share = min(row.utilisation, 1.0)
    colour = BAD_COLOUR.lower() if row.over else "#2a78b8"
    return (
        '<span style="display:inline-block;width:60px;height:8px;background:#8883;margin-right:8px">'
        f'<span style="display:block;width:{60 * share:.0f}px;height:8px;background:{colour}"></span></span>'
    )
