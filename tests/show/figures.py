"""What is written in a figure and what is drawn, and whether every word can be read."""

from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text


def drawn(figure):
    """The renderer of a figure, which is drawn."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return canvas.get_renderer()


def extents(texts, renderer):
    """(words, box in pixels) of the texts that say something."""
    return [(t.get_text(), Text.get_window_extent(t, renderer)) for t in texts if t.get_text()]


def over(a, b):
    """How far two boxes overlap [pixels]."""
    return min(min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0))


def words_stay_on_the_page(written, page):
    """None of them begins or ends outside of it."""
    for words, box in written:
        inside = page.x0 - 1 <= box.x0 and box.x1 <= page.x1 + 1 and page.y0 - 1 <= box.y0 and box.y1 <= page.y1 + 1
        assert inside, f"{words!r} leaves the page"


def words_stand_alone(written, page, most=3.0):
    """On the page, and over no other by so many pixels."""
    words_stay_on_the_page(written, page)
    for (words, a), (others, b) in combinations(written, 2):
        assert over(a, b) < most, f"{words!r} over {others!r}"


def panel(figure, title):
    """The axes whose title begins so."""
    return next(ax for ax in figure.axes if ax.get_title("left").startswith(title))
