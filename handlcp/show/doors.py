"""What grasps and answers offer of studies, pictures and data: they find these functions by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from handlcp.errors import InputError, shown
from handlcp.geometry import Object
from handlcp.grasp import Grasp, GraspSolution, Loading, Verdict
from handlcp.hand.hand_grasp import make_grasp
from handlcp.keywords import helped
from handlcp.show.file import drawn
from handlcp.show.html import html, table_html, text_html
from handlcp.show.record import record
from handlcp.show.tables import torque_table

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


@helped()
def plot(
    solution: GraspSolution,
    path: Any = None,
    obj: Object | None = None,
    title: str = "",
    verdict: Verdict | None = None,
) -> Any:
    """Draw a solution, or the loading of its verdict where that is held to its end: see `GraspSolution.plot`."""
    from handlcp.show.loading.report import verdict_picture  # saves data and tables 0.2 s
    from handlcp.show.picture.figure import draw

    followed = None if verdict is None else verdict.loading
    if verdict is not None and followed is not None and followed.reached and followed.solution.held:
        return drawn(path, verdict_picture, followed, verdict, title, obj)
    return drawn(path, draw, _asked(solution), solution, obj, title, verdict)


@helped("obj")  # anything with a surface of triangles is drawn
def page(
    solution: GraspSolution,
    path: Any,
    obj: Object | None = None,
    title: str = "",
    verdict: Verdict | None = None,
    loading: Loading | None = None,
) -> Path:
    """Write the page of a solution: see `GraspSolution.page`."""
    from handlcp.show.page.document import save  # saves data and tables 0.2 s

    if obj is not None and not hasattr(obj, "triangles"):
        raise InputError("obj", "an object, such as hl.Sphere(0.03)", shown(obj))
    return save(_asked(solution), solution, path, obj, title, verdict, loading)


def _at(module: str, name: str, room: str = "show") -> Callable[..., Any]:
    """A function of a module of a room, which is imported when the function is called."""

    def door(*given: Any) -> Any:
        return getattr(import_module(f"handlcp.{room}.{module}"), name)(*given)

    return door


def _plotted(module: str, name: str = "figure") -> Callable[..., Any]:
    """The method `plot` of an answer: the figure that this function of a module makes, or the file it is written to."""
    return lambda answer, path, title: drawn(path, _at(module, name), answer, title)


loading_plot, limit_plot, reliability_plot = map(_plotted, ("loading.draw", "limit", "reliability"))
path_cost_plot = _plotted("accuracy.on_paths")
payload = _at("payload", "payload", "study")
payload_plot, split_plot = map(_plotted, ("payload", "split_cylinder"))
envelope_plot, envelope_polar = _plotted("envelope.draw"), _plotted("envelope.polar", "polar_figure")
loading_page, envelope_page = _at("page.document", "save_loading"), _at("envelope.page", "save")
study_page = _at("study.page", "save")


def study_plot(study: Any, path: Any, title: str, by: Sequence[str]) -> Any:
    """Draw the designs of a sweep: see `Study.plot`."""
    return drawn(path, _at("study.draw", "figure"), study, title, by)


def to_dict(solution: GraspSolution) -> dict[str, Any]:
    """Everything about a solution as plain data: see `GraspSolution.to_dict`."""
    grasp = _asked(solution)
    return record(grasp, solution, grasp.explain())


def _asked(solution: GraspSolution) -> Grasp:
    """The grasp that a solution answers. Raises InputError for one that does not know what was solved."""
    spec = solution.spec
    if spec is None:
        raise InputError("solution", "one made by grasp.solve()", "one that does not know its grasp")
    return make_grasp(spec)
