"""The figure of a loading: forces, friction, motion and joint torques over its stages, and what happens where."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from handlcp.grasp.path.follow import Loading
from handlcp.show.file import Figure, new_figure
from handlcp.show.loading.curves import Axis, StageAxis, draw_panel
from handlcp.show.loading.report import headline
from handlcp.show.loading.series import Panel, panels
from handlcp.show.style import BLUE, GREY, INK, PURPLE, RED, SMALL, TEXT, spread, width

# ----------------------------------------------------------------
# Where something happens: numbered lines through the panels, the list of what it is, and where the object is lost.

LOST, SHADE = "#B03A00", "#FBEFE9"
COLOURS = {"slips": RED, "sticks": BLUE, "opens": GREY, "touches": GREY, "snaps": INK}  # joints are purple
ROW, HEAD = 0.2, 0.3  # inches of the list
MOST = 16  # events in the list
LETTERS = 105  # of a line of the list
APART = 0.17  # inches from a number to the next
LIFT = 0.16  # inches from the panel to the numbers
TITLE: dict[str, Any] = {"fontsize": TEXT + 0.5, "color": INK, "weight": "bold"}


class Mark(NamedTuple):
    """An event of a loading, as a numbered line marks it.

    at : place along the axis.
    where : the same in words, such as "load, 46 %".
    sentence : what happens.
    kind : as in `Loading.events`.
    """

    at: float
    where: str
    sentence: str
    kind: str


class Marks:
    """The events of one figure: numbered lines through the panels, and the list of what they mean.

    told : the events that have a number, in their order.
    more : how many have none.
    rows : lines of the list.
    height : inches that the list takes.
    head : inches that the numbers take above the first panel, below its title.
    """

    def __init__(self, axis: Axis, told: Sequence[Mark]) -> None:
        self.axis, self.told, self.more = axis, told[:MOST], max(len(told) - MOST, 0)
        self.places = [s.at for s in self.told]
        self.sentences = [textwrap.wrap(s.sentence, LETTERS) for s in self.told]
        self.rows = sum(map(len, self.sentences)) + (self.more > 0)
        self.head = LIFT + 0.5 * APART if self.rows or axis.lost is not None else 0.0
        self.height = HEAD + ROW * self.rows if self.rows else 0.05

    def draw_lines(self, ax: Any, first: bool) -> None:
        """Lines through a panel; above the first one, their numbers."""
        if self.axis.lost is not None:
            ax.axvspan(self.axis.lost, self.axis.end, color=SHADE, linewidth=0, zorder=0.2)
            ax.axvline(self.axis.lost, color=LOST, linewidth=1.8, zorder=4)
        for x, s in zip(self.places, self.told, strict=True):
            ax.axvline(x, color=_colour(s), linewidth=0.9, linestyle=(0, (3, 2)), zorder=1.8)
        if first and self.head:
            ax.set_title(ax.get_title("left"), loc="left", pad=72 * self.head + 3, **TITLE)
            self._numbers(ax)

    def _numbers(self, ax: Any) -> None:
        """Discs side by side where lines are too near to each other, joined to their lines; and where it is lost."""
        box = ax.get_window_extent()
        inches = box.width / ax.figure.dpi
        high = 1.0 + LIFT * ax.figure.dpi / box.height
        wanted = [
            (float(x), str(k), _colour(s)) for k, (x, s) in enumerate(zip(self.places, self.told, strict=True), 1)
        ]
        if self.axis.lost is not None:
            wanted.append((self.axis.lost, self.axis.called, LOST))
        room = [(0.42 if name == self.axis.called else APART) * self.axis.end / inches for _, name, _ in wanted]
        begin = [x - size / 2 for (x, _, _), size in zip(wanted, room, strict=True)]
        places = spread(begin, room, -0.1 * self.axis.end / inches, self.axis.end * (1.0 + 0.2 / inches))
        across = ax.get_xaxis_transform()
        for (x, name, colour), low, size in zip(wanted, places, room, strict=True):
            at = low + size / 2
            ax.plot([x, at], [1.0, high], transform=across, color=colour, linewidth=0.9, clip_on=False, zorder=5)
            ax.text(at, high, name, transform=across, clip_on=False, zorder=6, **_disc(name, colour))

    def write(self, figure: Any, top: float) -> None:
        """The list, `top` inches below the figure's upper edge."""
        if not self.rows:
            return
        tall = float(figure.get_size_inches()[1])
        column = 0.05 + max(width(figure, s.where, fontsize=SMALL) for s in self.told) / figure.bbox.width
        y = top + 0.5 * ROW
        for k, s in enumerate(self.told, 1):
            style: dict[str, Any] = {"fontsize": SMALL, "va": "center", "color": INK}
            figure.text(0.029, 1.0 - y / tall, str(k), **_disc(str(k), _colour(s)))
            figure.text(0.046, 1.0 - y / tall, s.where, **style)
            for line in self.sentences[k - 1]:
                figure.text(0.012 + column, 1.0 - y / tall, line, **style)
                y += ROW
        if self.more:
            figure.text(0.046, 1.0 - y / tall, f"… and {self.more} more", fontsize=SMALL, va="center", color=GREY)


def _colour(s: Mark) -> str:
    return COLOURS.get(s.kind.removesuffix(" by turns"), PURPLE)


def _disc(name: str, colour: str) -> dict[str, Any]:
    """Style of a number in a disc, of the same size for one digit and for two; of "lost" in a box."""
    size, shape = {1: (8.0, "circle,pad=0.22"), 2: (6.8, "circle,pad=0.2")}.get(len(name), (8.0, "round,pad=0.3"))
    face = {"boxstyle": shape, "facecolor": colour, "edgecolor": "white", "linewidth": 0.6}
    style = {"ha": "center", "va": "center", "color": "white", "weight": "bold"}
    return {"fontsize": size, "bbox": face} | style


# ----------------------------------------------------------------

WIDTH = 10.0  # inches
LEFT, ACROSS = 0.068, 0.70  # of the width: where panels begin, and how wide they are
TALL, BETWEEN = 1.22, 0.40  # inches: height of a panel, and room for the title of the next
ABOVE, BELOW = 0.36, 0.55  # inches between the sentence and the first panel, below the last


def figure(loading: Loading, title: str = "") -> Figure:
    """The figure of what `grasp.follow` returns. Raises Unsupported when matplotlib is not installed.

    Along x, the stages side by side, each from 0 to 100 %. One below the other: normal forces; friction as a share of
    its limit, 100 % where a finger slides; motion of the object since the start, world axes; joint torques as a share
    of their limits. Lines with a number are events, listed at the bottom. What lies behind the load that loses the
    object is shaded.
    """
    axis, steps = StageAxis(loading), loading.steps
    shown = panels(steps.grasp.spec, steps.forces, steps.friction_used, steps.displacement, steps.torques)
    marks = Marks(axis, [Mark(s.number + s.share, s.where, s.sentence, s.kind) for s in loading.summary])
    return compose(axis, shown, marks, lambda drawn: headline(drawn, loading, title))


def compose(axis: Axis, shown: Sequence[Panel], marks: Marks, head: Callable[[Figure], float]) -> Figure:
    """Panels one below the other under a head, which says where it ends, in inches; and the list of the marks."""
    # The height follows from the words, whose size is known once they are written
    draft = new_figure(figsize=(WIDTH, 8.0), dpi=100)
    above = head(draft) + ABOVE + marks.head
    inches = above + len(shown) * (TALL + BETWEEN) - BETWEEN + BELOW + marks.height
    drawn = new_figure(figsize=(WIDTH, inches), dpi=100)
    head(drawn)
    for k, panel in enumerate(shown):
        bottom = 1.0 - (above + TALL) / inches
        ax = drawn.add_axes((LEFT, bottom, ACROSS, TALL / inches))
        draw_panel(ax, axis, panel, k == len(shown) - 1)
        marks.draw_lines(ax, k == 0)
        above += TALL + BETWEEN
    marks.write(drawn, above - BETWEEN + BELOW)
    return drawn
