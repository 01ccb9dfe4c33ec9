"""Title and outcome at the top of a figure."""

from __future__ import annotations

from typing import Any

from handlcp.grasp.path.follow import Loading
from handlcp.show.style import BOLD, INK, title_lines, width, wrapped

LINE, TITLE = 0.215, 0.36  # inches from a line of the sentence to the next, and from the title to it
_SIZE = 10.5  # points
_GOOD, _BAD = "#00734D", "#B03A00"
_ACROSS, _LETTERS = 0.944, 150


def headline(figure: Any, loading: Loading, title: str, below: str = "") -> float:
    """Title, "REACHED" or "LOST", and why; returns where that ends, in inches below the top. below : a further line."""
    sentence = f"{loading.why.removeprefix('reached ').removeprefix('lost ')}."
    return outcome(figure, title, "REACHED" if loading.reached else "LOST", sentence, loading.reached, below)


def outcome(figure: Any, title: str, head: str, sentence: str, good: bool, below: str = "") -> float:
    """Title, a word and the sentence that it begins; returns where that ends, in inches below the top."""
    inches, left, y = float(figure.get_size_inches()[1]), 0.018, 0.17
    for line in title_lines(figure, title):
        figure.text(left, 1.0 - y / inches, line, color=INK, **BOLD)
        y += 0.30
    y += TITLE - 0.30 if title else 0.0
    word, colour = f"{head}:", _GOOD if good else _BAD
    style: dict[str, Any] = {"fontsize": _SIZE, "va": "top"}
    # The first line has a bold word, which is wider
    lines = wrapped(figure, f"{word} {sentence}", _LETTERS, _ACROSS, **style)
    figure.text(left, 1.0 - y / inches, word, weight="bold", color=colour, **style)
    indent = width(figure, f"{word} ", weight="bold", **style) / figure.bbox.width
    lines[0] = lines[0].removeprefix(f"{word} ")
    more = wrapped(figure, below, _LETTERS, _ACROSS - indent, **style) if below else []
    for k, line in enumerate([*lines, *more]):
        figure.text(left + (0 if k else indent + 0.002), 1.0 - y / inches, line, color=INK, **style)
        y += LINE
    return y
