"""What grasps and answers offer of studies, pictures and data: they find these functions by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from handlcp.check import check_call
from handlcp.errors import InputError, shorten_repr
from handlcp.geometry import Object
from handlcp.grasp import Grasp, GraspSolution, Loading, Verdict
from handlcp.hand.hand_grasp import make_grasp
from handlcp.viz.output_file import draw_or_save
from handlcp.viz.solution_output import html, solution_record, table_html, text_html
from handlcp.viz.terminal_table import torque_table

__all__ = [
    "envelope_page",
    "envelope_plot",
    "envelope_polar",
    "html",
    "limit_plot",
    "loading_page",
    "loading_plot",
    "page",
    "path_cost_plot",
    "payload",
    "payload_plot",
    "plot",
    "reliability_plot",
    "split_plot",
    "study_page",
    "study_plot",
    "table_html",
    "text_html",
    "to_dict",
    "torque_table",
]


@check_call()
def plot(
    solution: GraspSolution,
    path: Any = None,
    obj: Object | None = None,
    title: str = "",
    verdict: Verdict | None = None,
) -> Any:
    """Draw a solution, or the loading of its verdict where that is held to its end: see `GraspSolution.plot`."""
    from handlcp.viz.loading.figure import draw_verdict_picture  # saves data and tables 0.2 s
    from handlcp.viz.picture.figure import draw_solution

    followed = None if verdict is None else verdict.loading
    if verdict is not None and followed is not None and followed.reached and followed.solution.held:
        return draw_or_save(path, draw_verdict_picture, followed, verdict, title, obj)
    return draw_or_save(path, draw_solution, _grasp_of_solution(solution), solution, obj, title, verdict)


@check_call("obj")  # anything with a surface of triangles is drawn
def page(
    solution: GraspSolution,
    path: Any,
    obj: Object | None = None,
    title: str = "",
    verdict: Verdict | None = None,
    loading: Loading | None = None,
) -> Path:
    """Write the page of a solution: see `GraspSolution.page`."""
    from handlcp.viz.page.document import write_grasp_page  # saves data and tables 0.2 s

    if obj is not None and not hasattr(obj, "triangles"):
        raise InputError("obj", "an object, such as hl.Sphere(0.03)", shorten_repr(obj))
    return write_grasp_page(_grasp_of_solution(solution), solution, path, obj, title, verdict, loading)


def _defer(module: str, name: str, room: str = "viz") -> Callable[..., Any]:
    """A function of a module of a room, which is imported when the function is called."""

    def door(*given: Any) -> Any:
        return getattr(import_module(f"handlcp.{room}.{module}"), name)(*given)

    return door


def _defer_plot(module: str, name: str) -> Callable[..., Any]:
    """The method `plot` of an answer: the figure that this function of a module makes, or the file it is written to."""
    return lambda answer, path, title: draw_or_save(path, _defer(module, name), answer, title)


loading_plot = _defer_plot("loading.figure", "draw_loading")
limit_plot = _defer_plot("load_limit_figure", "draw_limit")
reliability_plot = _defer_plot("reliability_figure", "draw_reliability")
path_cost_plot = _defer_plot("accuracy.on_paths", "figure")
payload = _defer("payload.largest_mass", "payload", "studies")
payload_plot = _defer_plot("strength_figure", "draw_payload")
split_plot = _defer_plot("strength_figure", "draw_split_cylinder")
envelope_plot = _defer_plot("envelope.figure", "draw_envelope")
envelope_polar = _defer_plot("envelope.figure", "draw_polar_envelope")
loading_page = _defer("page.document", "write_loading_page")
envelope_page = _defer("envelope.page", "write_envelope_page")
study_page = _defer("study.page", "write_study_page")


def study_plot(study: Any, path: Any, title: str, by: Sequence[str]) -> Any:
    """Draw the designs of a sweep: see `Study.plot`."""
    return draw_or_save(path, _defer("study.figure", "draw_study"), study, title, by)


def to_dict(solution: GraspSolution) -> dict[str, Any]:
    """Everything about a solution as plain data: see `GraspSolution.to_dict`."""
    grasp = _grasp_of_solution(solution)
    return solution_record(grasp, solution, grasp.explain())


def _grasp_of_solution(solution: GraspSolution) -> Grasp:
    """The grasp that a solution answers. Raises InputError for one that does not know what was solved."""
    spec = solution.spec
    if spec is None:
        raise InputError("solution", "one made by grasp.solve()", "one that does not know its grasp")
    return make_grasp(spec)
