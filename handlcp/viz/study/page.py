"""The page of a sweep: its designs as points; one on the front is clicked, and its hand turns beside its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.check import check_integer
from handlcp.design.evaluation import Evaluation
from handlcp.design.study import Study
from handlcp.errors import InputError
from handlcp.viz.output_file import check_page_path
from handlcp.viz.page.document import page_data, write_viewer_page
from handlcp.viz.page.frame import snapshot_of_solution
from handlcp.viz.page.mesh import MeshPack
from handlcp.viz.picture.content import PictureContent
from handlcp.viz.study.figure import check_two_columns, column_label, parameter_label

_MAX_POINTS = 4000  # designs that are points, besides the front
_SHOWN_NUMBERS = "payload_kg", "factor", "force_N", "torque_Nm", "torque_used", "motion_m", "gives_out", "worst_object"


def write_study_page(study: Study, path: Any, title: str, by: Sequence[str], most: int) -> Path:
    """Write the page of a sweep and return its file.

    by : the two columns whose front is shown, with a minus where less is better. most : designs on the front that can
    be clicked, at most.

    Raises InputError for a file that cannot be written, for other than two columns, for a study that does not know how
    its hands are made, or without a grasp on its front; UnknownName; Unsupported without trimesh.
    """
    target = check_page_path(path)
    by = check_two_columns(by)
    front = study.pareto(*by) if study.pareto(*by) else study.pareto(*by, held=False)
    shown, most = front, check_integer("most", most, 1)
    if len(front) > most:  # evenly along it, with its ends
        shown = front.some(np.unique(np.linspace(0, len(front) - 1, most).round().astype(int)).tolist())
    pairs = zip(shown, shown.evaluations(), strict=True)
    meshes = MeshPack()
    designs = [made for row, found in pairs if (made := _design_data(study, row, found, meshes)) is not None]
    if not designs:
        raise InputError("study", "a design on its front that holds an object", repr(study))
    notes = ["The hand grasps the object that is held worst; the numbers are of all objects."]
    if not any(front.columns["holds"]):
        notes.append("No design holds all that the brief asks: the front is that of designs that do not.")
    if len(shown) < len(front):
        notes.append(f"Of the {len(front)} designs on the front {len(shown)} can be clicked, evenly along it.")
    found = {
        "designs": designs,
        "packed": meshes.to_base64(),
        "points": _point_data(study, front, by),
        "axes": [column_label(one) for one in by],
        "notes": notes,
        "colours": {},
        "frames": [],
    }
    head = str(study).partition("\n\n")[0].replace("\n", " ")
    said, scripts = f"<p>{escape(head)}</p>", ("chart.js", "study.js")
    return write_viewer_page(target, title or "Designs", said, found, "study", scripts)


def _point_data(study: Study, front: Study, by: Sequence[str]) -> dict[str, Any]:
    """Design, x and y of each point; of the front all, of the others as many evenly as a page bears."""
    x, y = [study.columns[study.column_of(name)] for name in by]
    on = set(front.columns["design"])
    known = np.flatnonzero(np.isfinite(study.wanted(*by)).all(axis=1)).tolist()
    others = [k for k in known if study.columns["design"][k] not in on]
    step = max(1, -(-len(others) // _MAX_POINTS))
    first = [k for k in known if study.columns["design"][k] in on]
    rows = first + others[::step]
    return {
        "design": [study.columns["design"][k] for k in rows],
        "x": [x[k] for k in rows],
        "y": [y[k] for k in rows],
        "front": len(first),
    }


def _design_data(study: Study, row: dict[str, Any], found: Evaluation, meshes: MeshPack) -> dict[str, Any] | None:
    """What the page shows of one: the grasp of its worst object, or of another one that it holds; None without any."""
    cases = [found.cases[found.worst_object], *found.cases.values()]
    case = next((one for one in cases if one.candidate is not None), None)
    if case is None or case.candidate is None:
        return None
    grasp, solution = case.candidate.grasp, case.candidate.solution
    drawn = PictureContent(grasp, solution, None, verdict=case.candidate.verdict)
    name = next(name for name, one in found.cases.items() if one is case)
    labels = [(key, parameter_label(key)) for key in study.names]
    numbers = [[column_label(column), row[column]] for column in _SHOWN_NUMBERS if row.get(column) is not None]
    return page_data(drawn, [snapshot_of_solution(grasp, solution, drawn.acts_at)], None, None, meshes) | {
        "design": row["design"],
        "object": name,
        "word": case.word,
        "parameters": [[f"{called} [{unit}]" if unit else called, row[key]] for key, (called, unit) in labels],
        "numbers": numbers,
        "objects": [[key, one.word, one.payload, one.factor, one.at_least] for key, one in found.cases.items()],
    }
