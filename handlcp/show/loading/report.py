"""A loading for the terminal, and the picture of the hand where it ends."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.table import Table

from handlcp import words
from handlcp.grasp import Grasp, GraspSolution, Verdict
from handlcp.grasp.path.follow import Loading
from handlcp.show import tables
from handlcp.show.file import Figure, new_figure
from handlcp.show.loading.series import grasp_at_end, solution_at_end
from handlcp.show.picture.content import Content
from handlcp.show.picture.figure import HEIGHT, WIDTH, compose
from handlcp.show.picture.panel import VERDICT, headline as verdict_head
from handlcp.show.style import BAD, further, heading, moved, opening
from handlcp.tolerances import CERTIFY

# ---------------------------------------------------------------- Title and outcome at the top of a figure.


def headline(figure: Any, loading: Loading, title: str, below: str = "") -> float:
    """Title, the loading's word, and why; returns where that ends, in inches below the top. below : a further line."""
    colour = VERDICT.get(loading.word, BAD)
    return further(figure, opening(figure, heading(figure, title), loading.word, colour, f"{loading.sentence}."), below)


# ----------------------------------------------------------------
# The hand where a loading ends: its posture, the object where it is then, and the forces of the last step.

GAP = 0.1  # inches between the sentences and the picture


def verdict_picture(loading: Loading, verdict: Verdict, title: str = "", obj: Any = None) -> Figure:
    """Draw the hand where a loading ends, under the verdict that is about the loading.

    verdict : of `check`. obj : the object of a grasp that does not know it; None: the hull of the contacts.
    """
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
    top = headline(drawn, loading, title, f"Drawn is {what}. The object has {moved(loading.displacement)}{stays}.")
    shown = Content(
        grasp_at_end(loading), solution_at_end(loading), loading.object or obj, around=Grasp(loading.steps.grasp.spec)
    )
    compose(drawn, shown, 1.0 - (top + GAP) / HEIGHT)
    return drawn


# ----------------------------------------------------------------

_AXES = "xyz"


def event_table(loading: Loading) -> Table | None:
    """What happens on the way, what several fingers do at one place in one line; None where nothing does."""
    if not loading.summary:
        return None
    rows = [(s.stage, s.at, s.sentence) for s in loading.summary]
    return tables.table("On the way", ("stage", "at", "what happens"), "<><", rows)


def end_tables(loading: Loading) -> list[Table]:
    """Contacts, joints and actuators at the last step; none where it has no certified answer."""
    solution = solution_at_end(loading)
    if not solution.held:
        return []
    when = "at the end" if loading.reached else "at the last step"
    return solution_tables(solution, f" {when}", True)


def solution_tables(solution: GraspSolution, when: str = "", whole: bool = False) -> list[Table]:
    """Contacts, joints and actuators; none where there is no answer. when : follows the titles. whole : whether slips
    are of the whole way.
    """
    if not solution.held:
        return []
    slips = float(np.hypot(*solution.slip.T).max(initial=0.0)) > CERTIFY * solution.residuals.motion_scale
    note = "slip: on the whole way" if whole and slips else ""
    found = [tables.contact_table(solution, f"Contacts{when}", note)]
    for part, table in (("torque_check", tables.torque_table), ("effort", tables.effort_table)):
        if (what := getattr(solution, part, None)) is not None:
            found.append(table(what))
            found[-1].title = f"{found[-1].title}{when}"
    return found


def motion(loading: Loading) -> str:
    """Of the object since the start, in words."""
    u = loading.displacement[:3]
    unit = words.length_unit([float(np.linalg.norm(u))])  # that of the whole way
    along = ", ".join(f"{axis} {unit(x)}" for axis, x in zip(_AXES, u.tolist(), strict=True))
    return f"the object has {moved(loading.displacement)} since the start ({along} {unit.name})"
