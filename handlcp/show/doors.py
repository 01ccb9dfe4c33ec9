"""What answers offer of pictures and data, by name; `handlcp.views` finds these functions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from handlcp.errors import InputError
from handlcp.grasp import Grasp, GraspSolution, Loading, Verdict
from handlcp.hand.hand_grasp import grasp_of
from handlcp.show.file import DPI, checked, drawn, write
from handlcp.show.html import html, table_html, text_html
from handlcp.show.record import record

if TYPE_CHECKING:
    from handlcp.grasp.limits.result import LoadLimit
    from handlcp.study.envelope import Envelope
    from handlcp.study.reliability import Reliability

__all__ = [
    "envelope_page", "envelope_plot", "envelope_polar", "html", "limit_plot", "loading_page", "loading_plot", "page",
    "plot", "reliability_plot", "table_html", "text_html", "to_dict",
]  # fmt: skip


def plot(
    solution: GraspSolution, path: Any = None, obj: Any = None, title: str = "", verdict: Verdict | None = None
) -> Any:
    """See `GraspSolution.plot`."""
    from handlcp.show.loading.report import verdict_picture
    from handlcp.show.picture import draw  # pictures alone need matplotlib

    file = None if path is None else checked(path)
    followed = None if verdict is None else verdict.loading
    if verdict is not None and followed is not None and followed.reached and followed.solution.held:
        figure = verdict_picture(followed, verdict, title, obj)
    else:
        figure = draw(_asked(solution), solution, obj, title, verdict)
    return figure if file is None else write(figure, file, DPI)


def page(
    solution: GraspSolution, path: Any, obj: Any = None, title: str = "", verdict: Verdict | None = None,
    loading: Loading | None = None,
) -> Path:  # fmt: skip
    """See `GraspSolution.page`."""
    from handlcp.show.page.document import save  # pages alone need the viewer

    return save(_asked(solution), solution, path, obj, title, verdict, loading)


def loading_plot(loading: Loading, path: Any = None, title: str = "") -> Any:
    """See `Loading.plot`."""
    from handlcp.show.loading import figure, save

    return figure(loading, title) if path is None else save(loading, path, title)


def limit_plot(limit: LoadLimit, path: Any = None, title: str = "") -> Any:
    """See `LoadLimit.plot`."""
    from handlcp.show.limit import figure, save

    return figure(limit, title) if path is None else save(limit, path, title)


def loading_page(loading: Loading, path: Any, obj: Any = None, title: str = "", verdict: Verdict | None = None) -> Path:
    """See `Loading.page`."""
    from handlcp.show.page.document import save_loading

    return save_loading(loading, path, title, obj, verdict)


def envelope_plot(env: Envelope, path: Any = None, title: str = "") -> Any:
    """See `Envelope.plot`."""
    from handlcp.show.envelope.draw import figure

    return drawn(figure, env, path, title)


def envelope_polar(env: Envelope, path: Any = None, title: str = "") -> Any:
    """See `Envelope.polar`."""
    from handlcp.show.envelope.polar import polar_figure

    return drawn(polar_figure, env, path, title)


def envelope_page(env: Envelope, path: Any, title: str = "") -> Path:
    """See `Envelope.page`."""
    from handlcp.show.envelope.page import save

    return save(env, path, title)


def reliability_plot(found: Reliability, path: Any = None, title: str = "") -> Any:
    """See `Reliability.plot`."""
    from handlcp.show.reliability import draw, save

    return draw(found, title) if path is None else save(found, path, title)


def to_dict(solution: GraspSolution) -> dict[str, Any]:
    """See `GraspSolution.to_dict`."""
    grasp = _asked(solution)
    return record(grasp, solution, grasp.explain())


def _asked(solution: GraspSolution) -> Grasp:
    """The grasp that a solution answers. Raises InputError for one that does not know what was solved."""
    spec = solution.spec
    if spec is None:
        raise InputError("solution", "one made by grasp.solve()", "one that does not know its grasp")
    return grasp_of(spec)
