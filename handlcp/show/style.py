"""Colours of pictures, words that they share, and room for their text."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array

# ----------------------------------------------------------------
# What the panels of a study have in common: frames, grids, ticks with units.

SMALL, TEXT = 9.5, 10.0  # points


def panel(ax: Any, title: str, x: str, y: str) -> None:
    """Title, labels, a light grid and frame."""
    ax.set_title(title, fontsize=TEXT + 0.5, color=INK, loc="left", weight="bold")
    ax.set_xlabel(x, fontsize=TEXT, color=INK, labelpad=2)
    ax.set_ylabel(y, fontsize=TEXT, color=INK, labelpad=2)
    ax.tick_params(labelsize=SMALL, colors=INK, length=3, pad=2)
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color("#9A9A9A")
    ax.grid(True, which="major", color="#E6E6E6", linewidth=0.7)
    ax.set_axisbelow(True)


def say(ax: Any, text: str) -> None:
    """A sentence in the middle of a panel."""
    ax.text(0.5, 0.5, text, transform=ax.transAxes, fontsize=TEXT, color=INK, ha="center", va="center")


def time_ticks(ax: Any) -> None:
    """Along x, seconds as µs, ms and s: decades, and 2 and 5 times them where few are in sight."""
    from matplotlib.ticker import EngFormatter

    first, last = ax.get_xlim()
    low, high = np.log10((first, last))
    within = (1.0,) if high - low > 2.0 else (1.0, 2.0, 5.0)
    every = (k * 10.0**e for e in range(int(np.floor(low)), int(np.floor(high)) + 1) for k in within)
    _ticks(ax.xaxis, (x for x in every if first <= x <= last), EngFormatter("s"))


def error_ticks(ax: Any) -> None:
    """Along y, shares as percents down to 0.01 %, as powers of ten below."""
    low, high = np.log10(ax.get_ylim())
    step = 1 if high - low < 8 else 2

    def name(e: float) -> str:
        power = round(np.log10(e))
        return f"{100 * e:.10g} %" if power >= -4 else f"$10^{{{power}}}$"

    _ticks(ax.yaxis, (10.0**e for e in range(-16, 5) if low <= e <= high and e % step == 0), name)


def number_ticks(axis: Any, wanted: Iterable[float]) -> None:
    """Plain numbers at these places."""
    _ticks(axis, wanted, lambda x: f"{x:g}")


def _ticks(axis: Any, places: Iterable[float], name: Callable[[float], str]) -> None:
    """Ticks at these places and no others."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    axis.set_major_locator(FixedLocator(list(places)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda x, _: name(x)))


# ----------------------------------------------------------------

# Okabe and Ito's palette, which colour-blind readers can tell apart
BLUE, RED, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#A0307A"
# Titles; a dollar in one is a dollar
BOLD: dict[str, Any] = {"fontsize": 14.0, "weight": "bold", "va": "top", "parse_math": False}
_TALLEST = 2  # lines of a title
_WORD = re.compile(r"[^_\s./-]+[_\s./-]*|[_\s./-]+")  # of a name, with what parts it from the next
INK, GREY = "#222222", "#5F5F5F"  # of text, and of text that matters less
GOOD, DOUBT, BAD = "#00734D", "#8A6100", "#B03A00"  # of the word that says how it ends
SENTENCE: dict[str, Any] = {"fontsize": 10.5, "va": "top"}  # below a title
LEFT, LINE, LETTERS = 0.018, 0.215, 150  # of a figure's width; inches from line to line; of a line at most
_STILL = 1e-4  # [rad] an object that turns less is not said to turn


def rgb(colour: str) -> tuple[float, float, float]:
    """Of "#rrggbb", red, green and blue from 0 to 1."""
    r, g, b = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return (r, g, b)


def moved(u: Array) -> str:
    """Of a motion (6,), such as "moved 2.9 mm and turned 0.49°"; no turn that nobody sees."""
    far, turned = words.length(float(np.linalg.norm(u[:3]))), float(np.linalg.norm(u[3:]))
    return f"moved {far} and turned {words.angle(turned)}" if turned > _STILL else f"moved {far}"


def turns(u: Array) -> bool:
    """Whether motions (…, 3) by rotation vectors are seen."""
    return bool(abs(u).max(initial=0.0) > _STILL)


def heading(figure: Any, title: str) -> float:
    """The title at the top of a figure; returns where it ends, in inches below the top."""
    inches, y = float(figure.get_size_inches()[1]), 0.17
    for line in title_lines(figure, title):
        figure.text(LEFT, 1.0 - y / inches, line, color=INK, **BOLD)
        y += 0.30
    return y + 0.06 if title else y


def opening(figure: Any, y: float, word: str, colour: str, sentence: str, most: int | None = None) -> float:
    """A bold word and the sentence that it begins, y inches below the top, on so many lines; returns where they end."""
    inches, head = float(figure.get_size_inches()[1]), f"{word}:"
    lines = wrapped(figure, f"{head} {sentence}", LETTERS, 0.944, **SENTENCE)
    lines = lines if most is None or len(lines) <= most else [*lines[: most - 1], f"{lines[most - 1]} …"]
    figure.text(LEFT, 1.0 - y / inches, head, weight="bold", color=colour, **SENTENCE)
    indent = width(figure, f"{head} ", weight="bold", **SENTENCE) / figure.bbox.width + 0.002
    lines[0] = lines[0].removeprefix(head).lstrip()
    for k, line in enumerate(lines):
        figure.text(LEFT + (0.0 if k else indent), 1.0 - y / inches, line, color=INK, **SENTENCE)
        y += LINE
    return y


def further(figure: Any, y: float, text: str, colour: str = INK, across: float = 0.944) -> float:
    """More sentences, y inches below the top; returns where they end."""
    inches = float(figure.get_size_inches()[1])
    for line in wrapped(figure, text, LETTERS, across, **SENTENCE) if text else []:
        figure.text(LEFT, 1.0 - y / inches, line, color=colour, **SENTENCE)
        y += LINE
    return y


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
    out = [
        name if len(name) <= letters else _cut(f"{'…' * (begin > 0)}{own}{'…' * (end > 0)}", letters)
        for name, own in zip(names, kept, strict=True)
    ]
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
