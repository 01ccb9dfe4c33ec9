"""Doors into what people look at: tables, units, records, pictures and their geometry, figures of studies."""

from handlcp.grasp.path.events import summary
from handlcp.viz.envelope.surface import (
    CAUSE_SHADES,
    NO_CAUSE_COLOUR,
    OTHER_CAUSES_COLOUR,
)
from handlcp.viz.output_file import draw_or_save
from handlcp.viz.picture.figure import draw_solution

ENVELOPE_COLOURS, ENVELOPE_GREYS = CAUSE_SHADES, (NO_CAUSE_COLOUR, OTHER_CAUSES_COLOUR)


def events_in_short(events, grasp):
    """What happens, in the order and words of `Loading`: events of several fingers at one place in one line."""
    return [str(s) for s in summary(events, grasp.spec)]


def html(solution):
    """What a notebook shows of it."""
    return solution._repr_html_()


def save(grasp, solution, path, title=""):
    """The picture of a grasp as a file, which also an answer of unknown origin may have."""
    return draw_or_save(path, draw_solution, grasp, solution, None, title)
