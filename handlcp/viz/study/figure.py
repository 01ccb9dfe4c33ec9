"""`draw_study`: pictures of a study, with parameters at their unit coordinates and outcomes with their units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints, check_sequence
from handlcp.design.space import Choices
from handlcp.design.study import MainEffect, Study, main_effect
from handlcp.errors import InputError
from handlcp.hand.vary.vary import ARGUMENT_NUMBERS, NUMBER_UNITS as OF_HANDS
from handlcp.record import UNIT_SUFFIXES
from handlcp.viz.output_file import Figure, new_figure
from handlcp.viz.style import (
    BLUE,
    GREY,
    INK,
    RED,
    SMALL_SIZE,
    TEXT_SIZE,
    draw_sentences,
    draw_title,
    shorten_names,
    style_panel,
    write_in_middle,
)

_HAND_NUMBER_UNITS = {"palm_radius": "m", "link_radius": "m", "tilt": "rad"}  # of `finger_hand`
_BRIEF_UNITS = {
    "acceleration": "m/s²",
    "motion": "m",
    "most_force": "N",
    "squeeze": "m",
    "grip_force": "N",
    "closing_torque": "N·m",
}
_MAX_CHOICE_TICKS = 6  # choices of which each has its own tick


def column_label(column: str) -> str:
    """Of a column, such as "payload [kg]" for "payload_kg"; a minus, which says that less is better, is left out."""
    name, _, end = column.removeprefix("-").rpartition("_")
    unit = UNIT_SUFFIXES.get(end, "") if name else ""
    return f"{name.replace('_', ' ')} [{unit}]" if unit else column.removeprefix("-").replace("_", " ")


def parameter_label(name: str) -> tuple[str, str]:
    """What a parameter is called, and its unit: of one that is called as in `Hand.vary`, in `finger_hand` or
    "brief.motion", or by a name that ends in its unit, such as "length_m"; "" of others.
    """
    if name.startswith("brief."):
        return name, _BRIEF_UNITS.get(name.removeprefix("brief."), "")
    what = name.rpartition(".")[2] if "." in name else ARGUMENT_NUMBERS.get(name, "")
    if unit := OF_HANDS.get(what, "") or _HAND_NUMBER_UNITS.get(name, ""):
        return name, unit
    unit = column_label(name).partition(" [")[2].rstrip("]")
    return (name.rpartition("_")[0], unit) if unit else (name, "")


def check_two_columns(by: Sequence[str]) -> Sequence[str]:
    """The two columns of a front. Raises InputError for other than two."""
    by = check_sequence("by", by, "two columns")
    if len(by) != 2:
        raise InputError("by", "two columns", f"{len(by)}")
    return by


def parameter_ticks(entry: Any) -> tuple[list[float], list[str]]:
    """Where along a free parameter's unit coordinate which value stands: ends and middle, or the choices."""
    if isinstance(entry, Choices):
        at = range(len(entry.values)) if len(entry.values) <= _MAX_CHOICE_TICKS else (0, len(entry.values) - 1)
        said = [f"{value:.3g}" if isinstance(value, float) else str(value) for value in entry.values]
        short = [text if len(text) <= 12 else f"{text[:11]}…" for text in said]
        return [entry.coordinate_of_choice(i) for i in at], [short[i] for i in at]
    where = [0.0, 0.5, 1.0]
    return where, [f"{entry.value_at(u):.3g}" for u in where]


# ----------------------------------------------------------------
# The figure of a sweep: its front, its designs as lines across all parameters, and the main effects of these.


# Inches: of the figure, height of the first row of panels, of each further one
FIGURE_WIDTH, FRONT_ROW_HEIGHT, EFFECT_ROW_HEIGHT = 12.0, 3.9, 2.1
EFFECTS_PER_ROW = 4  # main effects in a row
_MAX_DESIGN_LINES = 1500  # designs that are drawn as lines, the front always
_MAX_NUMBERED_DESIGNS = 12  # designs on the front that have their numbers beside them
_MIN_DESIGNS_FOR_SHARES = 64  # shares of the variance from fewer designs are rough
_OTHER_DESIGNS_COLOUR = "#B9BEC4"  # of designs that are not on the front


def draw_study(study: Study, title: str, by: Sequence[str]) -> Figure:
    """Draw the front of two columns of a sweep, its designs as lines, and the main effect of each parameter.

    by : the two columns, with a minus where less is better.

    Raises InputError, UnknownName; Unsupported without matplotlib.
    """
    by = check_two_columns(by)
    new_figure()
    wanted, front = study.wanted(*by), study.pareto(*by)
    known = np.isfinite(wanted).all(axis=1)
    if not known.any():
        raise InputError("study", f"designs of which {' and '.join(by)} are known", repr(study))
    on = np.isin(study.columns["design"], front.columns["design"]) & known
    free, names = study.space.free, study.names
    points = (dict(zip(names, row, strict=True)) for row in zip(*[study.columns[name] for name in names], strict=True))
    cube = np.array([study.space.unit(point) for point in points]).reshape(len(study), len(study.space))
    rows = -(-len(free) // EFFECTS_PER_ROW)
    tall = 1.1 + FRONT_ROW_HEIGHT + rows * EFFECT_ROW_HEIGHT
    made = new_figure(figsize=(FIGURE_WIDTH, tall), dpi=100)
    better = [f"{'less' if one.startswith('-') else 'more'} {column_label(one).partition(' [')[0]}" for one in by]
    told = f"No design has both {' and '.join(better)} than any of the {len(front)} on the front."
    told = told if len(front) else "There is no front: no design holds all that the brief asks."
    y = draw_sentences(made, draw_title(made, title or "Designs"), f"{study.counts}. {told}", GREY)
    bottom = (tall - y - 0.45 - (FRONT_ROW_HEIGHT - 1.2)) / tall
    high = (FRONT_ROW_HEIGHT - 1.2) / tall
    _draw_front(made.add_axes((0.065, bottom, 0.37, high)), study, wanted, on, by)
    _draw_design_lines(made.add_axes((0.515, bottom, 0.45, high)), study, cube, wanted, on, by)
    effects = {name: main_effect(cube[known, k], _undo_minus(wanted, by)[known, 0]) for k, name in enumerate(free)}
    below = y + FRONT_ROW_HEIGHT + 0.25
    said = f"{column_label(by[0])} along each parameter: "
    said += "mean ± standard error, and the share of its variance that it explains"
    said += "" if known.sum() >= _MIN_DESIGNS_FOR_SHARES else f" (rough: from {known.sum()} designs)"
    made.text(0.018, 1 - below / tall, said, fontsize=TEXT_SIZE + 0.5, weight="bold", color=INK, va="center")
    _draw_main_effects(made, study, effects, below + 0.45, tall)
    return made


def _undo_minus(wanted: Array, by: Sequence[str]) -> Array:
    """The columns themselves, of which those with a minus were turned round."""
    return wanted * [-1.0 if name.startswith("-") else 1.0 for name in by]


def _draw_front(ax: Any, study: Study, wanted: Array, on: Bools, by: Sequence[str]) -> None:
    """All designs, and the front as a line of steps: what is behind it is beaten."""
    x, y = _undo_minus(wanted, by).T
    style_panel(ax, "Designs, and the front" if on.any() else "Designs", column_label(by[0]), column_label(by[1]))
    held = np.array([value is True for value in study.columns["holds"]])
    hollow: dict[str, Any] = {"facecolors": "none"}
    for some, colour, size in ((~on, _OTHER_DESIGNS_COLOUR, 14), (on, BLUE, 30)):
        ax.scatter(x[some & held], y[some & held], s=size, color=colour, linewidths=0.9, zorder=3)
        ax.scatter(x[some & ~held], y[some & ~held], s=size, edgecolors=colour, linewidths=0.9, zorder=3, **hollow)
    order = np.flatnonzero(on)[np.argsort(x[on])]
    ax.step(x[order], y[order], where="post" if by[0].startswith("-") else "pre", color=BLUE, linewidth=1.2)
    if on.sum() <= _MAX_NUMBERED_DESIGNS:
        for k in np.flatnonzero(on):
            number = str(study.columns["design"][k])
            ax.annotate(number, (x[k], y[k]), (4, 4), textcoords="offset points", fontsize=SMALL_SIZE, color=INK)
    if not held[np.isfinite(wanted).all(axis=1)].all():
        ax.set_title("hollow: does not hold all that is asked", fontsize=SMALL_SIZE, color=GREY, loc="right")


def _draw_design_lines(ax: Any, study: Study, cube: Array, wanted: Array, on: Bools, by: Sequence[str]) -> None:
    """A line for each design, through its parameters and outcomes; those of the front coloured by the first outcome."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap

    known = np.isfinite(wanted).all(axis=1)
    plain = _undo_minus(wanted, by)
    low, high = plain[known].min(axis=0), plain[known].max(axis=0)
    shares = (plain - low) / np.where(high > low, high - low, 1.0)
    values = np.column_stack([cube, shares])
    others = np.flatnonzero(known & ~on)
    others = others[np.linspace(0, len(others) - 1, min(len(others), _MAX_DESIGN_LINES)).astype(int)]
    at, across = np.arange(values.shape[1]), shares[:, 0]
    colours = LinearSegmentedColormap.from_list("front", ["#E69F00", RED, "#A0307A", BLUE])

    def lines(rows: Ints, **style: Any) -> None:
        ax.add_collection(LineCollection([np.column_stack([at, values[k]]) for k in rows], **style))

    lines(others, colors=_OTHER_DESIGNS_COLOUR, linewidths=0.6, alpha=max(0.15, min(0.8, 60 / max(len(others), 1))))
    front = np.flatnonzero(on)
    lines(front, colors=colours(across[front]), linewidths=1.5, zorder=3)
    style_panel(ax, "Designs as lines, the front coloured" if on.any() else "Designs as lines", "", "")
    ax.set(xlim=(-0.1, at[-1] + 0.1), ylim=(-0.04, 1.04), yticks=[])
    ax.spines["left"].set_visible(False)
    ax.grid(visible=False)
    told = [*[parameter_label(name) for name in study.space.free], *[(column_label(name), "") for name in by]]
    short = shorten_names([name for name, _ in told], 16)
    names = [f"{name}\n[{unit}]" if unit else name for name, (_, unit) in zip(short, told, strict=True)]
    ax.set_xticks(at, names, rotation=0 if len(at) <= 6 else 30, ha="center" if len(at) <= 6 else "right")
    ends = [parameter_ticks(entry) for entry in study.space.free.values()]
    ends += [([0.0, 1.0], [f"{a:.3g}", f"{b:.3g}"]) for a, b in zip(low, high, strict=True)]
    for k, (where, texts) in enumerate(ends):
        ax.axvline(k, color="#9A9A9A", linewidth=0.9, zorder=2)
        for u, text in zip(where, texts, strict=True):
            box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}
            ax.text(k + 0.02, u, text, fontsize=8.5, color=INK, va="center", bbox=box, zorder=5)


def _draw_main_effects(made: Figure, study: Study, effects: dict[str, MainEffect], top: float, tall: float) -> None:
    """A panel for each parameter, all with the same scale. top : inches below the figure's top."""
    every = [e for e in effects.values() if len(e.means)]
    low = min((float((e.means - e.errors).min()) for e in every), default=0.0)
    high = max((float((e.means + e.errors).max()) for e in every), default=1.0)
    room = 0.06 * (high - low) or 1.0
    wide = 0.955 / EFFECTS_PER_ROW
    for k, (name, entry) in enumerate(study.space.free.items()):
        row, column = divmod(k, EFFECTS_PER_ROW)
        place = (0.05 + column * wide, 1 - (top + row * EFFECT_ROW_HEIGHT + 1.25) / tall, 0.8 * wide, 1.25 / tall)
        ax, effect = made.add_axes(place), effects[name]
        share = "" if np.isnan(effect.index) else f": {100 * max(effect.index, 0.0):.0f} %"
        called, unit = parameter_label(name)
        style_panel(ax, shorten_names([called], 24)[0] + share, unit, "")
        if not len(effect.means):
            write_in_middle(ax, "nothing is known")
            continue
        if isinstance(entry, Choices):
            ax.errorbar(effect.places, effect.means, effect.errors, fmt="o", color=BLUE, markersize=5, linewidth=1.2)
        else:
            below, above = effect.means - effect.errors, effect.means + effect.errors
            ax.fill_between(effect.places, below, above, color=BLUE, alpha=0.2, linewidth=0)
            ax.plot(effect.places, effect.means, color=BLUE, linewidth=1.6)
        ax.set(xlim=(-0.02, 1.02), ylim=(low - room, high + room))
        ax.set_xticks(*parameter_ticks(entry))
        if column:
            ax.tick_params(labelleft=False)
