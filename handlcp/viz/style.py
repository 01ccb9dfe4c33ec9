"""`style_panel`: colours of pictures, words that they share, and room for their text."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.viz.output_file import Figure, new_figure

# ----------------------------------------------------------------
# What the panels of a study have in common: frames, grids, ticks with units.

SMALL_SIZE, TEXT_SIZE = 9.5, 10.0  # points


def style_panel(ax: Any, title: str, x: str, y: str) -> None:
    """Title, labels, a light grid and frame."""
    ax.set_title(title, fontsize=TEXT_SIZE + 0.5, color=INK, loc="left", weight="bold")
    ax.set_xlabel(x, fontsize=TEXT_SIZE, color=INK, labelpad=2)
    ax.set_ylabel(y, fontsize=TEXT_SIZE, color=INK, labelpad=2)
    ax.tick_params(labelsize=SMALL_SIZE, colors=INK, length=3, pad=2)
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color("#9A9A9A")
    ax.grid(True, which="major", color="#E6E6E6", linewidth=0.7)
    ax.set_axisbelow(True)


def write_in_middle(ax: Any, text: str) -> None:
    """A sentence in the middle of a panel."""
    ax.text(0.5, 0.5, text, transform=ax.transAxes, fontsize=TEXT_SIZE, color=INK, ha="center", va="center")


def set_time_ticks(ax: Any) -> None:
    """Along x, seconds as µs, ms and s: decades, and 2 and 5 times them where few are in sight."""
    from matplotlib.ticker import EngFormatter

    first, last = ax.get_xlim()
    low, high = np.log10((first, last))
    within = (1.0,) if high - low > 2.0 else (1.0, 2.0, 5.0)
    every = (k * 10.0**e for e in range(int(np.floor(low)), int(np.floor(high)) + 1) for k in within)
    _set_ticks(ax.xaxis, (x for x in every if first <= x <= last), EngFormatter("s"))


def set_error_ticks(ax: Any) -> None:
    """Along y, shares as percents down to 0.01 %, as powers of ten below."""
    low, high = np.log10(ax.get_ylim())
    step = 1 if high - low < 8 else 2

    def name(e: float) -> str:
        power = round(np.log10(e))
        return f"{100 * e:.10g} %" if power >= -4 else f"$10^{{{power}}}$"

    _set_ticks(ax.yaxis, (10.0**e for e in range(-16, 5) if low <= e <= high and e % step == 0), name)


def set_number_ticks(axis: Any, wanted: Iterable[float]) -> None:
    """Plain numbers at these places."""
    _set_ticks(axis, wanted, lambda x: f"{x:g}")


def _set_ticks(axis: Any, places: Iterable[float], name: Callable[[float], str]) -> None:
    """Ticks at these places and no others."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    axis.set_major_locator(FixedLocator(list(places)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda x, _: name(x)))


# ----------------------------------------------------------------

# Okabe and Ito's palette, which colour-blind readers can tell apart
BLUE, RED, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#A0307A"
# Titles; a dollar in one is a dollar
TITLE_STYLE: dict[str, Any] = {"fontsize": 14.0, "weight": "bold", "va": "top", "parse_math": False}
_MAX_TITLE_LINES = 2  # lines of a title
_WORD_PATTERN = re.compile(r"[^_\s./-]+[_\s./-]*|[_\s./-]+")  # of a name, with what parts it from the next
INK, GREY = "#222222", "#5F5F5F"  # of text, and of text that matters less
GOOD_COLOUR, DOUBT_COLOUR, BAD_COLOUR = "#00734D", "#8A6100", "#B03A00"  # of the word that says how it ends
SENTENCE_STYLE: dict[str, Any] = {"fontsize": 10.5, "va": "top"}  # below a title
WORD_COLOURS = {"HELD": GOOD_COLOUR, "UNDECIDED": DOUBT_COLOUR}  # of a verdict; the rest is red
# Of a figure's width; inches from line to line; of a line at most
LEFT_MARGIN, LINE_HEIGHT, MAX_LINE_LETTERS = 0.018, 0.215, 150
_MIN_VISIBLE_TURN = 1e-4  # [rad] an object that turns less is not said to turn


def hex_to_rgb(colour: str) -> tuple[float, float, float]:
    """Of "#rrggbb", red, green and blue from 0 to 1."""
    r, g, b = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return (r, g, b)


def describe_motion(u: Array) -> str:
    """Of a motion (6,), such as "moved 2.9 mm and turned 0.49°"; no turn that nobody sees."""
    far, turned = words.format_length(float(np.linalg.norm(u[:3]))), float(np.linalg.norm(u[3:]))
    return f"moved {far} and turned {words.format_angle(turned)}" if turned > _MIN_VISIBLE_TURN else f"moved {far}"


def has_visible_turn(u: Array) -> bool:
    """Whether motions (…, 3) by rotation vectors are seen."""
    return bool(abs(u).max(initial=0.0) > _MIN_VISIBLE_TURN)


def capitalise(text: str) -> str:
    """The text as a sentence, with a capital and a full stop."""
    return f"{text[:1].upper()}{text[1:]}."


def figure_below(width: float, heading: Callable[[Figure], float], *rooms: float) -> tuple[Figure, float, float]:
    """A figure with a heading and room below it: the figure, where the heading ends, and how tall it is [inches].

    heading : draws it and returns where it ends. The height follows from its words, whose size is known once they are
    written: so it is drawn on a draft first. width, rooms : [inches], one below the other.
    """
    above = heading(new_figure(figsize=(width, 8.0), dpi=100))
    tall = sum(rooms, above)
    made = new_figure(figsize=(width, tall), dpi=100)
    heading(made)
    return made, above, tall


def draw_title(figure: Any, title: str) -> float:
    """The title at the top of a figure, in at most two lines; returns where it ends, in inches below the top."""
    inches, y = float(figure.get_size_inches()[1]), 0.17
    lines = wrap_to_width(figure, title, 110, 0.96, **TITLE_STYLE) if title else []
    for line in _cut_lines(lines, _MAX_TITLE_LINES):
        figure.text(LEFT_MARGIN, 1.0 - y / inches, line, color=INK, **TITLE_STYLE)
        y += 0.30
    return y + 0.06 if title else y


def draw_word_and_sentence(
    figure: Any, y: float, word: str, colour: str, sentence: str, most: int | None = None
) -> float:
    """A bold word and the sentence that it begins, y inches below the top, on so many lines; returns where they end."""
    inches, head = float(figure.get_size_inches()[1]), f"{word}:"
    lines = wrap_to_width(figure, f"{head} {sentence}", MAX_LINE_LETTERS, 0.944, **SENTENCE_STYLE)
    lines = lines if most is None else _cut_lines(lines, most)
    figure.text(LEFT_MARGIN, 1.0 - y / inches, head, weight="bold", color=colour, **SENTENCE_STYLE)
    indent = text_width(figure, f"{head} ", weight="bold", **SENTENCE_STYLE) / figure.bbox.width + 0.002
    lines[0] = lines[0].removeprefix(head).lstrip()
    for k, line in enumerate(lines):
        figure.text(LEFT_MARGIN + (0.0 if k else indent), 1.0 - y / inches, line, color=INK, **SENTENCE_STYLE)
        y += LINE_HEIGHT
    return y


def draw_sentences(figure: Any, y: float, text: str, colour: str = INK, across: float = 0.944) -> float:
    """More sentences, y inches below the top; returns where they end."""
    inches = float(figure.get_size_inches()[1])
    for line in wrap_to_width(figure, text, MAX_LINE_LETTERS, across, **SENTENCE_STYLE) if text else []:
        figure.text(LEFT_MARGIN, 1.0 - y / inches, line, color=colour, **SENTENCE_STYLE)
        y += LINE_HEIGHT
    return y


def text_width(figure: Any, line: str, **style: Any) -> float:
    """Width of a line of text in the figure, in pixels."""
    drawn = figure.text(0, 0, line, **style)
    extent = drawn.get_window_extent()
    drawn.remove()
    return float(extent.width)


def wrap_to_width(figure: Any, text: str, letters: int, across: float, **style: Any) -> list[str]:
    """Lines of at most so many letters, none wider than this share of the figure; no single word on the last one."""
    lines = textwrap.wrap(text, letters)
    while any(text_width(figure, line, **style) > across * figure.bbox.width for line in lines):
        letters -= 3
        lines = textwrap.wrap(text, letters)
    while len(lines) > 1 and len(lines[-1]) < 0.35 * letters:
        letters -= 2
        lines = textwrap.wrap(text, letters)
    return lines


def _cut_lines(lines: list[str], most: int) -> list[str]:
    """At most so many lines, the last of which then ends with "…"."""
    return lines if len(lines) <= most else [*lines[: most - 1], f"{lines[most - 1]} …"]


def shorten_names(names: Sequence[str], letters: int) -> list[str]:
    """The names, those of more letters with "…" for what is left out: the words that all names begin and end with, then
    letters in the middle. Names that differ stay different.
    """
    if max(map(len, names), default=0) <= letters:
        return list(names)
    words = [_WORD_PATTERN.findall(name) for name in names]
    begin = _count_common_words(words)
    end = _count_common_words([w[begin:][::-1] for w in words])
    kept = ["".join(w[begin : len(w) - end]).rstrip("_ ./-") for w in words]
    out = [
        name if len(name) <= letters else _cut_middle(f"{'…' * (begin > 0)}{own}{'…' * (end > 0)}", letters)
        for name, own in zip(names, kept, strict=True)
    ]
    if len(set(out)) == len(set(names)):
        return out
    return [_cut_middle(name, letters - 4) + f" ({k})" for k, name in enumerate(names, 1)]


def _count_common_words(words: Sequence[Sequence[str]]) -> int:
    """How many words all of these begin with, of several; one word of each is left."""
    most = min(map(len, words)) - 1 if len(words) > 1 else 0
    return next((k for k in range(most) if len({w[k] for w in words}) > 1), most)


def _cut_middle(text: str, letters: int) -> str:
    """Without letters in the middle, where there are too many."""
    tail = (letters - 1) * 2 // 5
    return text if len(text) <= letters else f"{text[: letters - 1 - tail]}…{text[-tail:]}"


def spread_labels(wanted: Sequence[float], sizes: Sequence[float], low: float, high: float) -> list[float]:
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
