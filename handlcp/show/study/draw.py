"""The figure of a sweep: its front, its designs as lines across all parameters, and the main effects of these."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints, several
from handlcp.design.main_effects import MainEffect, main_effect
from handlcp.design.space import Choices
from handlcp.design.study import Study
from handlcp.errors import InputError
from handlcp.show.file import Figure, new_figure
from handlcp.show.study.axes import label, parameter, places, ticks
from handlcp.show.style import BLUE, GREY, INK, RED, SMALL, TEXT, further, heading, panel, say, shortened

WIDTH, TOP, EFFECT = 12.0, 3.9, 2.1  # inches: of the figure, height of the first row of panels, of each further one
ACROSS = 4  # main effects in a row
_LINES = 1500  # designs that are drawn as lines, the front always
_NUMBERED = 12  # designs on the front that have their numbers beside them
_ROUGH = 64  # shares of the variance from fewer designs are rough
_FAINT = "#B9BEC4"  # of designs that are not on the front


def figure(study: Study, title: str, by: Sequence[str]) -> Figure:
    """Draw the front of two columns of a sweep, its designs as lines, and the main effect of each parameter.

    by : the two columns, with a minus where less is better.

    Raises InputError, UnknownName; Unsupported without matplotlib.
    """
    by = several("by", by, "two columns")
    if len(by) != 2:
        raise InputError("by", "two columns", f"{len(by)}")
    new_figure()
    wanted, front = study.wanted(*by), study.pareto(*by)
    known = np.isfinite(wanted).all(axis=1)
    if not known.any():
        raise InputError("study", f"designs of which {' and '.join(by)} are known", repr(study))
    on = np.isin(study.columns["design"], front.columns["design"]) & known
    cube, free = places(study), study.space.free
    rows = -(-len(free) // ACROSS)
    tall = 1.1 + TOP + rows * EFFECT
    made = new_figure(figsize=(WIDTH, tall), dpi=100)
    y = further(made, heading(made, title or "Designs"), _said(study, front, by), GREY)
    bottom = (tall - y - 0.45 - (TOP - 1.2)) / tall
    high = (TOP - 1.2) / tall
    _front(made.add_axes((0.065, bottom, 0.37, high)), study, wanted, on, by)
    _lines(made.add_axes((0.515, bottom, 0.45, high)), study, cube, wanted, on, by)
    effects = {name: main_effect(cube[known, k], _plain(wanted, by)[known, 0]) for k, name in enumerate(free)}
    below = y + TOP + 0.25
    said = f"{label(by[0])} along each parameter: "
    said += "mean ± standard error, and the share of its variance that it explains"
    said += "" if known.sum() >= _ROUGH else f" (rough: from {known.sum()} designs)"
    made.text(0.018, 1 - below / tall, said, fontsize=TEXT + 0.5, weight="bold", color=INK, va="center")
    _effects(made, study, effects, below + 0.45, tall)
    return made


def _said(study: Study, front: Study, by: Sequence[str]) -> str:
    head = study.counts
    if not len(front):
        return f"{head}. There is no front: no design holds all that the brief asks."
    better = " and ".join(f"{'less' if one.startswith('-') else 'more'} {label(one).partition(' [')[0]}" for one in by)
    return f"{head}. No design has both {better} than any of the {len(front)} on the front."


def _plain(wanted: Array, by: Sequence[str]) -> Array:
    """The columns themselves, of which those with a minus were turned round."""
    return wanted * [-1.0 if name.startswith("-") else 1.0 for name in by]


def _front(ax: Any, study: Study, wanted: Array, on: Bools, by: Sequence[str]) -> None:
    """All designs, and the front as a line of steps: what is behind it is beaten."""
    x, y = _plain(wanted, by).T
    panel(ax, "Designs, and the front" if on.any() else "Designs", label(by[0]), label(by[1]))
    held = np.array([value is True for value in study.columns["holds"]])
    hollow: dict[str, Any] = {"facecolors": "none"}
    for some, colour, size in ((~on, _FAINT, 14), (on, BLUE, 30)):
        ax.scatter(x[some & held], y[some & held], s=size, color=colour, linewidths=0.9, zorder=3)
        ax.scatter(x[some & ~held], y[some & ~held], s=size, edgecolors=colour, linewidths=0.9, zorder=3, **hollow)
    order = np.flatnonzero(on)[np.argsort(x[on])]
    ax.step(x[order], y[order], where="post" if by[0].startswith("-") else "pre", color=BLUE, linewidth=1.2)
    if on.sum() <= _NUMBERED:
        for k in np.flatnonzero(on):
            number = str(study.columns["design"][k])
            ax.annotate(number, (x[k], y[k]), (4, 4), textcoords="offset points", fontsize=SMALL, color=INK)
    if not held[np.isfinite(wanted).all(axis=1)].all():
        ax.set_title("hollow: does not hold all that is asked", fontsize=SMALL, color=GREY, loc="right")


def _lines(ax: Any, study: Study, cube: Array, wanted: Array, on: Bools, by: Sequence[str]) -> None:
    """A line for each design, through its parameters and outcomes; those of the front coloured by the first outcome."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap

    known = np.isfinite(wanted).all(axis=1)
    plain = _plain(wanted, by)
    low, high = plain[known].min(axis=0), plain[known].max(axis=0)
    shares = (plain - low) / np.where(high > low, high - low, 1.0)
    values = np.column_stack([cube, shares])
    others = np.flatnonzero(known & ~on)
    others = others[np.linspace(0, len(others) - 1, min(len(others), _LINES)).astype(int)] if len(others) else others
    at, across = np.arange(values.shape[1]), shares[:, 0]
    colours = LinearSegmentedColormap.from_list("front", ["#E69F00", RED, "#A0307A", BLUE])

    def lines(rows: Ints, **style: Any) -> None:
        ax.add_collection(LineCollection([np.column_stack([at, values[k]]) for k in rows], **style))

    lines(others, colors=_FAINT, linewidths=0.6, alpha=max(0.15, min(0.8, 60 / max(len(others), 1))))
    front = np.flatnonzero(on)
    lines(front, colors=colours(across[front]), linewidths=1.5, zorder=3)
    panel(ax, "Designs as lines, the front coloured" if on.any() else "Designs as lines", "", "")
    ax.set(xlim=(-0.1, at[-1] + 0.1), ylim=(-0.04, 1.04), yticks=[])
    ax.spines["left"].set_visible(False)
    ax.grid(visible=False)
    told = [*[parameter(name) for name in study.space.free], *[(label(name), "") for name in by]]
    short = shortened([name for name, _ in told], 16)
    names = [f"{name}\n[{unit}]" if unit else name for name, (_, unit) in zip(short, told, strict=True)]
    ax.set_xticks(at, names, rotation=0 if len(at) <= 6 else 30, ha="center" if len(at) <= 6 else "right")
    ends = [ticks(entry) for entry in study.space.free.values()]
    ends += [([0.0, 1.0], [f"{a:.3g}", f"{b:.3g}"]) for a, b in zip(low, high, strict=True)]
    for k, (where, texts) in enumerate(ends):
        ax.axvline(k, color="#9A9A9A", linewidth=0.9, zorder=2)
        for u, text in zip(where, texts, strict=True):
            box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}
            ax.text(k + 0.02, u, text, fontsize=8.5, color=INK, va="center", bbox=box, zorder=5)


def _effects(made: Figure, study: Study, effects: dict[str, MainEffect], top: float, tall: float) -> None:
    """A panel for each parameter, all with the same scale. top : inches below the figure's top."""
    every = [e for e in effects.values() if len(e.means)]
    low = min((float((e.means - e.errors).min()) for e in every), default=0.0)
    high = max((float((e.means + e.errors).max()) for e in every), default=1.0)
    room = 0.06 * (high - low) or 1.0
    wide = 0.955 / ACROSS
    for k, (name, entry) in enumerate(study.space.free.items()):
        row, column = divmod(k, ACROSS)
        place = (0.05 + column * wide, 1 - (top + row * EFFECT + 1.25) / tall, 0.8 * wide, 1.25 / tall)
        ax, effect = made.add_axes(place), effects[name]
        share = "" if np.isnan(effect.index) else f": {100 * max(effect.index, 0.0):.0f} %"
        called, unit = parameter(name)
        panel(ax, shortened([called], 24)[0] + share, unit, "")
        if not len(effect.means):
            say(ax, "nothing is known")
            continue
        if isinstance(entry, Choices):
            ax.errorbar(effect.places, effect.means, effect.errors, fmt="o", color=BLUE, markersize=5, linewidth=1.2)
        else:
            below, above = effect.means - effect.errors, effect.means + effect.errors
            ax.fill_between(effect.places, below, above, color=BLUE, alpha=0.2, linewidth=0)
            ax.plot(effect.places, effect.means, color=BLUE, linewidth=1.6)
        ax.set(xlim=(-0.02, 1.02), ylim=(low - room, high + room))
        ax.set_xticks(*ticks(entry))
        if column:
            ax.tick_params(labelleft=False)
