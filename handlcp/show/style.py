"""Colours of pictures, and room for their text."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Any

# Okabe and Ito's palette, which colour-blind readers can tell apart
BLUE, RED, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#A0307A"
BOLD: dict[str, Any] = {"fontsize": 14.0, "weight": "bold", "va": "top"}  # titles
_TALLEST = 2  # lines of a title
_WORD = re.compile(r"[^_\s./-]+[_\s./-]*|[_\s./-]+")  # of a name, with what parts it from the next
INK, GREY = "#222222", "#5F5F5F"  # of text, and of text that matters less


def width(figure: Any, line: str, **style: Any) -> float:
    """Width of a line of text in the figure, in pixels."""
    drawn = figure.text(0, 0, line, **style)
    extent = drawn.get_window_extent()
    drawn.remove()
    return float(extent.width)


def wrapped(figure: Any, text: str, letters: int, across: float, **style: Any) -> list[str]:
    """Lines of at most so many letters, none wider than this share of the figure; no single word on the last one."""
    lines = textwrap.wrap(text, letters)
    while any(width(figure, line, **style) > across * figure.bbox.width for line in lines):
        letters -= 3
        lines = textwrap.wrap(text, letters)
    while len(lines) > 1 and len(lines[-1]) < 0.35 * letters:
        letters -= 2
        lines = textwrap.wrap(text, letters)
    return lines


def title_lines(figure: Any, title: str) -> list[str]:
    """The title in at most two lines as wide as the figure, written in `BOLD`; none for ""."""
    lines = wrapped(figure, title, 110, 0.96, **BOLD) if title else []
    return lines if len(lines) <= _TALLEST else [*lines[: _TALLEST - 1], f"{lines[_TALLEST - 1]} …"]


def shortened(names: Sequence[str], letters: int) -> list[str]:
    """The names, those of more letters with "…" for what is left out: the words that all names begin and end with, then
    letters in the middle. Names that differ stay different.
    """
    if max(map(len, names), default=0) <= letters:
        return list(names)
    words = [_WORD.findall(name) for name in names]
    begin = _alike(words)
    end = _alike([w[begin:][::-1] for w in words])
    kept = ["".join(w[begin : len(w) - end]).rstrip("_ ./-") for w in words]
    out = [name if len(name) <= letters else _cut(f"{'…' * (begin > 0)}{own}{'…' * (end > 0)}", letters)
           for name, own in zip(names, kept, strict=True)]  # fmt: skip
    if len(set(out)) == len(set(names)):
        return out
    return [_cut(name, letters - 4) + f" ({k})" for k, name in enumerate(names, 1)]


def _alike(words: Sequence[Sequence[str]]) -> int:
    """How many words all of these begin with, of several; one word of each is left."""
    most = min(map(len, words)) - 1 if len(words) > 1 else 0
    return next((k for k in range(most) if len({w[k] for w in words}) > 1), most)


def _cut(text: str, letters: int) -> str:
    """Without letters in the middle, where there are too many."""
    tail = (letters - 1) * 2 // 5
    return text if len(text) <= letters else f"{text[: letters - 1 - tail]}…{text[-tail:]}"


def spread(wanted: Sequence[float], sizes: Sequence[float], low: float, high: float) -> list[float]:
    """Where labels in a column begin, as near to the wanted places as the others and the column's ends permit.

    wanted : places in rising order. sizes : the room that each label takes, counted upwards from its place. Where the
    column from `low` to `high` is too short for all of them, they reach below `low`.
    """
    places, end = [], low
    for place, size in zip(wanted, sizes, strict=True):
        places.append(max(place, end))
        end = places[-1] + size
    end = high
    for k in reversed(range(len(places))):
        places[k] = min(places[k], end - sizes[k])
        end = places[k]
    return places
