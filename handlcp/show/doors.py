"""What answers offer of pictures and data, by name; `handlcp.views` finds these functions."""

from __future__ import annotations

import platform
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.errors import InputError, writing
from handlcp.grasp import Grasp, GraspSolution, Loading, Verdict
from handlcp.hand.hand_grasp import grasp_of
from handlcp.show.file import drawn
from handlcp.show.html import html, table_html, text_html
from handlcp.show.record import data_frame, record, solution_frame
from handlcp.study.plain import json_text, plain
from handlcp.version import VERSION

if TYPE_CHECKING:
    from handlcp.grasp.limits.result import LoadLimit
    from handlcp.study.envelope import Envelope
    from handlcp.study.reliability import Reliability

__all__ = [
    "data_frame", "envelope_dict", "envelope_frame", "envelope_page", "envelope_plot", "envelope_polar", "html",
    "limit_plot", "loading_dict", "loading_page", "loading_plot", "page", "plot", "reliability_plot",
    "solution_frame", "table_html", "text_html", "to_dict", "to_json",
]  # fmt: skip


def plot(
    solution: GraspSolution, path: Any = None, obj: Any = None, title: str = "", verdict: Verdict | None = None
) -> Any:
    """See `GraspSolution.plot`."""
    from handlcp.show.loading.report import verdict_picture
    from handlcp.show.picture import draw  # pictures alone need matplotlib

    followed = None if verdict is None else verdict.loading
    if verdict is not None and followed is not None and followed.reached and followed.solution.held:
        return drawn(path, verdict_picture, followed, verdict, title, obj)
    return drawn(path, draw, _asked(solution), solution, obj, title, verdict)


def page(
    solution: GraspSolution, path: Any, obj: Any = None, title: str = "", verdict: Verdict | None = None,
    loading: Loading | None = None,
) -> Path:  # fmt: skip
    """See `GraspSolution.page`."""
    from handlcp.show.page.document import save  # pages alone need the viewer

    return save(_asked(solution), solution, path, obj, title, verdict, loading)


def loading_plot(loading: Loading, path: Any = None, title: str = "") -> Any:
    """See `Loading.plot`."""
    from handlcp.show.loading import figure

    return drawn(path, figure, loading, title)


def limit_plot(limit: LoadLimit, path: Any = None, title: str = "") -> Any:
    """See `LoadLimit.plot`."""
    from handlcp.show.limit import figure

    return drawn(path, figure, limit, title)


def loading_page(loading: Loading, path: Any, obj: Any = None, title: str = "", verdict: Verdict | None = None) -> Path:
    """See `Loading.page`."""
    from handlcp.show.page.document import save_loading

    return save_loading(loading, path, title, obj, verdict)


def envelope_plot(env: Envelope, path: Any = None, title: str = "") -> Any:
    """See `Envelope.plot`."""
    from handlcp.show.envelope.draw import figure

    return drawn(path, figure, env, title)


def envelope_polar(env: Envelope, path: Any = None, title: str = "") -> Any:
    """See `Envelope.polar`."""
    from handlcp.show.envelope.polar import polar_figure

    return drawn(path, polar_figure, env, title)


def envelope_page(env: Envelope, path: Any, title: str = "") -> Path:
    """See `Envelope.page`."""
    from handlcp.show.envelope.page import save

    return save(env, path, title)


def reliability_plot(found: Reliability, path: Any = None, title: str = "") -> Any:
    """See `Reliability.plot`."""
    from handlcp.show.reliability import draw

    return drawn(path, draw, found, title)


def to_dict(solution: GraspSolution) -> dict[str, Any]:
    """See `GraspSolution.to_dict`."""
    grasp = _asked(solution)
    return record(grasp, solution, grasp.explain())


def loading_dict(loading: Loading) -> dict[str, Any]:
    """See `Loading.to_dict`."""
    from handlcp.show.loading.report import record as record_of_path

    return record_of_path(loading)


def to_json(value: dict[str, Any], path: Any = None) -> str | Path:
    """Plain data as JSON: the text, or the file. Raises InputError for a file that cannot be written."""
    text = json_text(value)
    if path is None:
        return text
    file = Path(path)
    with writing("path", file):
        file.write_text(text + "\n", encoding="utf-8")
    return file


def _asked(solution: GraspSolution) -> Grasp:
    """The grasp that a solution answers. Raises InputError for one that does not know what was solved."""
    spec = solution.spec
    if spec is None:
        raise InputError("solution", "one made by grasp.solve()", "one that does not know its grasp")
    return grasp_of(spec)


# ----------------------------------------------------------------
# An envelope as plain data, and as a table.

_NAMES = {"force": "force_N", "torque": "torque_Nm", "gravity": "mass_kg", "wrench": "factor"}


def envelope_dict(env: Envelope) -> dict[str, Any]:
    """See `Envelope.to_dict`."""
    question, c = env.question, env.compliance
    held = _NAMES[env.of]
    found = {
        "title": "", "of": env.of, "geometry": question.geometry,
        "at_m": question.load.at if env.of in ("force", "gravity") else None,
        "object_mass_kg": question.load.mass, "motion_m": question.motion, "turn_rad": question.turn,
        "accuracy_asked": question.accuracy, "accuracy": env.accuracy,
        "plane": env.plane, "weakest": _extreme(env, env.weakest), "strongest": _extreme(env, env.strongest),
        "causes": [
            {"binds": _binds(x.binds), "says": x.says, "share": x.share, f"least_{held}": x.least,
             f"median_{held}": x.median} for x in env.causes
        ],
        "share_of_bound": {"median": c.median, "least": c.least, "direction": env.directions[c.number]},
        "directions": env.directions, "wrenches_N_Nm": env.wrenches, held: env.factors, f"bound_{held}": env.bound,
        "cause": env.cause, "share": env.shares, "triangles": env.triangles,
        "versions": {"handlcp": VERSION, "python": platform.python_version(), "numpy": np.__version__},
    }  # fmt: skip
    return dict(plain(found))


def envelope_frame(env: Envelope) -> Any:
    """See `Envelope.to_frame`."""
    held, ways = _NAMES[env.of], env.directions
    if env.of == "wrench":
        names = ("Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm")
        first = dict(zip(names, env.wrenches.T, strict=True))
    else:
        first = dict(zip("xyz", ways.T, strict=True))
    return data_frame(first | {
        held: env.factors, f"bound_{held}": env.bound, "binds": [env.causes[k].says for k in env.cause],
        "share": env.shares,
    })  # fmt: skip


def _extreme(env: Envelope, e: Any) -> dict[str, Any]:
    """One direction."""
    return {
        "number": e.number, "direction": e.direction, _NAMES[env.of]: e.factor, "binds": _binds(e.binds),
        "says": env.causes[env.cause[e.number]].says,
    }  # fmt: skip


def _binds(binds: Any) -> list[dict[str, str]]:
    return [{"kind": b.kind, "who": b.who} for b in binds]
