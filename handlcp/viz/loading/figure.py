"""`compose_panels`: a loading for the terminal, and the picture of the hand where it ends."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from rich.table import Table

from handlcp import words
from handlcp.check import check_call
from handlcp.geometry.object import Object
from handlcp.grasp import Grasp, GraspSolution, Verdict
from handlcp.grasp.path.follow import Loading
from handlcp.tolerances import CERTIFY_TOLERANCE
from handlcp.viz import terminal_table as tables
from handlcp.viz.loading.curves import (
    Panel,
    PanelAxis,
    draw_panel,
    grasp_at_end,
    make_panels,
    solution_at_end,
    stage_axis,
)
from handlcp.viz.output_file import Figure, draw_or_save, new_figure
from handlcp.viz.picture.content import PictureContent
from handlcp.viz.picture.figure import PICTURE_HEIGHT, PICTURE_WIDTH, compose_picture, draw_solution
from handlcp.viz.picture.panel import draw_verdict_headline as verdict_head
from handlcp.viz.solution_output import grasp_of_solution
from handlcp.viz.style import (
    BAD_COLOUR,
    BLUE,
    GREY,
    INK,
    PURPLE,
    RED,
    SMALL_SIZE,
    TEXT_SIZE,
    WORD_COLOURS,
    describe_motion,
    draw_sentences,
    draw_title,
    draw_word_and_sentence,
    figure_below,
    spread_labels,
    text_width,
)

# ---------------------------------------------------------------- Title and outcome at the top of a figure.


def draw_loading_headline(figure: Any, loading: Loading, title: str, below: str = "") -> float:
    """Title, the loading's word, and why; returns where that ends, in inches below the top. below : a further line."""
    colour = WORD_COLOURS.get(loading.word, BAD_COLOUR)
    y = draw_word_and_sentence(figure, draw_title(figure, title), loading.word, colour, f"{loading.sentence}.")
    return draw_sentences(figure, y, below)


# ----------------------------------------------------------------
# The hand where a loading ends: its posture, the object where it is then, and the forces of the last step.

HEADLINE_GAP = 0.1  # inches between the sentences and the picture


@check_call()
def plot_solution(
    solution: GraspSolution,
    path: Any = None,
    obj: Object | None = None,
    title: str = "",
    verdict: Verdict | None = None,
) -> Any:
    """Draw a solution, or the loading of its verdict where that is held to its end: see `GraspSolution.plot`."""
    followed = None if verdict is None else verdict.loading
    if verdict is not None and followed is not None and followed.reached and followed.solution.held:
        return draw_or_save(path, draw_verdict_picture, followed, verdict, title, obj)
    return draw_or_save(path, draw_solution, grasp_of_solution(solution), solution, obj, title, verdict)


def draw_verdict_picture(loading: Loading, verdict: Verdict, title: str = "", obj: Any = None) -> Figure:
    """Draw the hand where a loading ends, under the verdict that is about the loading.

    verdict : of `check`. obj : the object of a grasp that does not know it; None: the hull of the contacts.
    """
    drawn = new_figure(figsize=(PICTURE_WIDTH, PICTURE_HEIGHT))
    grasp, end = grasp_at_end(loading), solution_at_end(loading)
    shown = PictureContent(grasp, end, loading.object or obj, Grasp(loading.steps.grasp.spec), verdict)
    told = "Drawn: the grasp squeezed and loaded, followed in steps; slips are of the whole way."
    compose_picture(drawn, shown, verdict_head(drawn, verdict, title, told))
    return drawn


def draw_end_picture(loading: Loading, title: str = "", obj: Any = None) -> Figure:
    """The grasp at the last step: the hand in its posture there, the object where it is, forces, torques.

    Slips are those of the whole way. obj : the object of a grasp that does not know it, where it stands at the start;
    None: the hull of the contacts. With `geometry="fixed"` hand and contacts stay as they were.
    Raises Unsupported when matplotlib is not installed.
    """
    drawn = new_figure(figsize=(PICTURE_WIDTH, PICTURE_HEIGHT))
    what = "the end" if loading.reached else "the last step"
    stays = "" if loading.state is not None else ", which is not drawn: the contacts stay where they were"
    below = f"Drawn is {what}. The object has {describe_motion(loading.displacement)}{stays}."
    top = draw_loading_headline(drawn, loading, title, below)
    around = Grasp(loading.steps.grasp.spec)
    shown = PictureContent(grasp_at_end(loading), solution_at_end(loading), loading.object or obj, around)
    compose_picture(drawn, shown, 1.0 - (top + HEADLINE_GAP) / PICTURE_HEIGHT)
    return drawn


# ----------------------------------------------------------------

_AXIS_NAMES = "xyz"


def event_table(loading: Loading) -> Table | None:
    """What happens on the way, what several fingers do at one place in one line; None where nothing does."""
    if not loading.summary:
        return None
    rows = [(s.stage, s.at, s.sentence) for s in loading.summary]
    return tables.make_table("On the way", ("stage", "at", "what happens"), "<><", rows)


def end_tables(loading: Loading) -> list[Table]:
    """Contacts, joints and actuators at the last step; none where it has no certified answer."""
    return solution_tables(solution_at_end(loading), " at the end" if loading.reached else " at the last step", True)


def solution_tables(solution: GraspSolution, when: str = "", whole: bool = False) -> list[Table]:
    """Contacts, joints and actuators; none where there is no answer. when : follows the titles. whole : whether slips
    are of the whole way.
    """
    if not solution.held:
        return []
    slips = float(np.hypot(*solution.slip.T).max(initial=0.0)) > CERTIFY_TOLERANCE * solution.residuals.motion_scale
    note = "slip: on the whole way" if whole and slips else ""
    found = [tables.contact_table(solution, f"Contacts{when}", note)]
    for part, table in (("torque_check", tables.torque_table), ("effort", tables.effort_table)):
        if (what := getattr(solution, part, None)) is not None:
            found.append(table(what))
            found[-1].title = f"{found[-1].title}{when}"
    return found


def describe_object_motion(loading: Loading) -> str:
    """Of the object since the start, in words."""
    u = loading.displacement[:3]
    unit = words.choose_length_unit([float(np.linalg.norm(u))])  # that of the whole way
    along = ", ".join(f"{axis} {unit(x)}" for axis, x in zip(_AXIS_NAMES, u.tolist(), strict=True))
    return f"the object has {describe_motion(loading.displacement)} since the start ({along} {unit.name})"


# ----------------------------------------------------------------
# Where something happens: numbered lines through the panels, the list of what it is, and where the object is lost.

LOST_COLOUR, LOST_SHADE = "#B03A00", "#FBEFE9"
EVENT_COLOURS = {"slips": RED, "sticks": BLUE, "opens": GREY, "touches": GREY, "snaps": INK}  # joints are purple
LIST_ROW, LIST_HEAD = 0.2, 0.3  # inches of the list
MAX_LISTED_EVENTS = 16  # events in the list
MAX_EVENT_LETTERS = 105  # of a line of the list
NUMBER_SPACING = 0.17  # inches from a number to the next
NUMBER_LIFT = 0.16  # inches from the panel to the numbers
PANEL_TITLE_STYLE: dict[str, Any] = {"fontsize": TEXT_SIZE + 0.5, "color": INK, "weight": "bold"}


class EventMark(NamedTuple):
    """An event of a loading, as a numbered line marks it.

    place : along the axis.
    place_text : the same in words, such as "load, 46 %".
    sentence : what happens.
    kind : as in `Loading.events`.
    """

    place: float
    place_text: str
    sentence: str
    kind: str


class EventMarks:
    """The events of one figure: numbered lines through the panels, and the list of what they mean.

    events : those that have a number, in their order.
    unlisted_count : how many have none.
    rows : lines of the list.
    height : inches that the list takes.
    head : inches that the numbers take above the first panel, below its title.
    """

    def __init__(self, axis: PanelAxis, told: Sequence[EventMark]) -> None:
        self.axis, self.events = axis, told[:MAX_LISTED_EVENTS]
        self.unlisted_count = len(told) - len(self.events)
        self.sentences = [textwrap.wrap(s.sentence, MAX_EVENT_LETTERS) for s in self.events]
        self.rows = sum(map(len, self.sentences)) + (self.unlisted_count > 0)
        self.head = NUMBER_LIFT + 0.5 * NUMBER_SPACING if self.rows or axis.lost_at is not None else 0.0
        self.height = LIST_HEAD + LIST_ROW * self.rows if self.rows else 0.05

    def draw_lines(self, ax: Any, first: bool) -> None:
        """Lines through a panel; above the first one, their numbers."""
        if self.axis.lost_at is not None:
            ax.axvspan(self.axis.lost_at, self.axis.end, color=LOST_SHADE, linewidth=0, zorder=0.2)
            ax.axvline(self.axis.lost_at, color=LOST_COLOUR, linewidth=1.8, zorder=4)
        for s in self.events:
            ax.axvline(s.place, color=_event_colour(s), linewidth=0.9, linestyle=(0, (3, 2)), zorder=1.8)
        if first and self.head:
            ax.set_title(ax.get_title("left"), loc="left", pad=72 * self.head + 3, **PANEL_TITLE_STYLE)
            self._draw_numbers(ax)

    def _draw_numbers(self, ax: Any) -> None:
        """Discs side by side where lines are too near to each other, joined to their lines; and where it is lost."""
        box = ax.get_window_extent()
        inches = box.width / ax.figure.dpi
        high = 1.0 + NUMBER_LIFT * ax.figure.dpi / box.height
        wanted = [(float(s.place), str(k), _event_colour(s)) for k, s in enumerate(self.events, 1)]
        if self.axis.lost_at is not None:
            wanted.append((self.axis.lost_at, self.axis.lost_label, LOST_COLOUR))
        end, lost = self.axis.end, self.axis.lost_label
        room = [(0.42 if name == lost else NUMBER_SPACING) * end / inches for _, name, _ in wanted]
        begin = [x - size / 2 for (x, _, _), size in zip(wanted, room, strict=True)]
        places = spread_labels(begin, room, -0.1 * end / inches, end * (1.0 + 0.2 / inches))
        across = ax.get_xaxis_transform()
        for (x, name, colour), low, size in zip(wanted, places, room, strict=True):
            at = low + size / 2
            ax.plot([x, at], [1.0, high], transform=across, color=colour, linewidth=0.9, clip_on=False, zorder=5)
            ax.text(at, high, name, transform=across, clip_on=False, zorder=6, **_disc_style(name, colour))

    def draw_list(self, figure: Any, top: float) -> None:
        """The list, `top` inches below the figure's upper edge."""
        if not self.rows:
            return
        tall = float(figure.get_size_inches()[1])
        widest = max(text_width(figure, s.place_text, fontsize=SMALL_SIZE) for s in self.events)
        column = 0.05 + widest / figure.bbox.width
        y = top + 0.5 * LIST_ROW
        style: dict[str, Any] = {"fontsize": SMALL_SIZE, "va": "center", "color": INK}
        for k, s in enumerate(self.events, 1):
            figure.text(0.029, 1.0 - y / tall, str(k), **_disc_style(str(k), _event_colour(s)))
            figure.text(0.046, 1.0 - y / tall, s.place_text, **style)
            for line in self.sentences[k - 1]:
                figure.text(0.012 + column, 1.0 - y / tall, line, **style)
                y += LIST_ROW
        if self.unlisted_count:
            figure.text(0.046, 1.0 - y / tall, f"… and {self.unlisted_count} more", **style | {"color": GREY})


def _event_colour(s: EventMark) -> str:
    return EVENT_COLOURS.get(s.kind.removesuffix(" by turns"), PURPLE)


def _disc_style(name: str, colour: str) -> dict[str, Any]:
    """Style of a number in a disc, of the same size for one digit and for two; of "lost" in a box."""
    size, shape = {1: (8.0, "circle,pad=0.22"), 2: (6.8, "circle,pad=0.2")}.get(len(name), (8.0, "round,pad=0.3"))
    face = {"boxstyle": shape, "facecolor": colour, "edgecolor": "white", "linewidth": 0.6}
    style = {"ha": "center", "va": "center", "color": "white", "weight": "bold"}
    return {"fontsize": size, "bbox": face} | style


# ----------------------------------------------------------------
# The figure of a loading: forces, friction, motion and joint torques over its stages, and what happens where.

FIGURE_WIDTH = 10.0  # inches
PANELS_LEFT, PANELS_WIDTH = 0.068, 0.70  # of the width: where panels begin, and how wide they are
PANEL_HEIGHT, PANEL_GAP = 1.22, 0.40  # inches: height of a panel, and room for the title of the next
HEADING_GAP, TICKS_HEIGHT = 0.36, 0.55  # inches between the sentence and the first panel, below the last


def draw_loading(loading: Loading, title: str = "") -> Figure:
    """The figure of what `grasp.follow` returns. Raises Unsupported when matplotlib is not installed.

    Along x, the stages side by side, each from 0 to 100 %. One below the other: normal forces; friction as a share of
    its limit, 100 % where a finger slides; motion of the object since the start, world axes; joint torques as a share
    of their limits. Lines with a number are events, listed at the bottom. What lies behind the load that loses the
    object is shaded.
    """
    axis, steps = stage_axis(loading), loading.steps
    shown = make_panels(steps.grasp.spec, steps.forces, steps.friction_used, steps.displacement, steps.torques)
    marks = EventMarks(axis, [EventMark(s.number + s.share, s.where, s.sentence, s.kind) for s in loading.summary])
    return compose_panels(axis, shown, marks, lambda drawn: draw_loading_headline(drawn, loading, title))


def compose_panels(
    axis: PanelAxis, shown: Sequence[Panel], marks: EventMarks, head: Callable[[Figure], float]
) -> Figure:
    """Panels one below the other under a head, which says where it ends, in inches; and the list of the marks."""
    panels = len(shown) * (PANEL_HEIGHT + PANEL_GAP)
    rooms = HEADING_GAP, marks.head, panels, -PANEL_GAP, TICKS_HEIGHT, marks.height
    drawn, above, inches = figure_below(FIGURE_WIDTH, head, *rooms)
    above = above + HEADING_GAP + marks.head
    for k, panel in enumerate(shown):
        bottom = 1.0 - (above + PANEL_HEIGHT) / inches
        ax = drawn.add_axes((PANELS_LEFT, bottom, PANELS_WIDTH, PANEL_HEIGHT / inches))
        draw_panel(ax, axis, panel, k == len(shown) - 1)
        marks.draw_lines(ax, k == 0)
        above += PANEL_HEIGHT + PANEL_GAP
    marks.draw_list(drawn, above - PANEL_GAP + TICKS_HEIGHT)
    return drawn
