"""Colours of pictures, and room for their text."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

__all__ = ["BLUE", "GREEN", "GREY", "INK", "PURPLE", "RED", "spread", "width", "wrapped"]

# Okabe and Ito's palette, which colour-blind readers can tell apart
BLUE, RED, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#A0307A"
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
