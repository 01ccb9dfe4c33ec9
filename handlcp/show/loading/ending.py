"""The hand where a loading ends: its posture, the object where it is then, and the forces of the last step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handlcp.grasp import Grasp, Verdict
from handlcp.grasp.path.follow import Loading
from handlcp.show.file import Figure, checked, new_figure, write
from handlcp.show.loading.end import grasp_at_end, moved, solution_at_end
from handlcp.show.loading.head import headline
from handlcp.show.picture.content import Content
from handlcp.show.picture.figure import DPI, HEIGHT, WIDTH, compose
from handlcp.show.picture.panel import headline as verdict_head

GAP = 0.1  # inches between the sentences and the picture


def save_picture(loading: Loading, path: Any, title: str = "", obj: Any = None) -> Path:
    """Draw and write a file; see `picture`. Raises InputError for an unknown format or a folder that does not exist."""
    file = checked(path)
    return write(picture(loading, title, obj), file, DPI)


def verdict_picture(loading: Loading, verdict: Verdict, title: str = "", obj: Any = None) -> Figure:
    """The same under the verdict that is about it, as `handlcp.show.picture.draw` has it under that of one solve."""
    drawn = new_figure(figsize=(WIDTH, HEIGHT))
    grasp, end = grasp_at_end(loading), solution_at_end(loading)
    shown = Content(grasp, end, loading.object or obj, Grasp(loading.steps.grasp.spec), verdict)
    told = "Drawn: the grasp squeezed and loaded, followed in steps; slips are of the whole way."
    compose(drawn, shown, verdict_head(drawn, verdict, title, told))
    return drawn


def picture(loading: Loading, title: str = "", obj: Any = None) -> Figure:
    """The grasp at the last step: the hand in its posture there, the object where it is, forces, torques.

    Slips are those of the whole way. obj : the object of a grasp that does not know it, where it stands at the start;
    None: the hull of the contacts. With `geometry="fixed"` hand and contacts stay as they were.
    Raises Unsupported when matplotlib is not installed.
    """
    drawn = new_figure(figsize=(WIDTH, HEIGHT))
    what = "the end" if loading.reached else "the last step"
    stays = "" if loading.state is not None else ", which is not drawn: the contacts stay where they were"
    top = headline(drawn, loading, title, f"Drawn is {what}. The object has {moved(loading)}{stays}.")
    shown = Content(
        grasp_at_end(loading), solution_at_end(loading), loading.object or obj, around=Grasp(loading.steps.grasp.spec)
    )
    compose(drawn, shown, 1.0 - (top + GAP) / HEIGHT)
    return drawn
