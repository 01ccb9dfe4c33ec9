"""The figure of a loading: forces, friction, motion and joint torques over its stages, and what happens where."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from handlcp.grasp.path.follow import Loading
from handlcp.show.file import Figure, new_figure
from handlcp.show.loading.curves import Axis, StageAxis, draw_panel
from handlcp.show.loading.marks import Mark, Marks
from handlcp.show.loading.report import headline
from handlcp.show.loading.series import Panel, panels

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
    axis, shown = StageAxis(loading), panels(loading)
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
