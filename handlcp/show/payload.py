"""The figure of a payload: a bar for each direction of gravity, coloured by what gives out first."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np

from handlcp.show.envelope.surface import keys_of
from handlcp.show.file import Figure, new_figure
from handlcp.show.style import BAD, GOOD, GREY, INK, SMALL, TEXT, further, heading, opening, panel, width
from handlcp.study.envelope.causes import causes_of
from handlcp.study.envelope.printed import direction, geometry
from handlcp.study.payload import Orientation, Payload

WIDTH, ROW, BELOW = 10.0, 0.42, 0.72  # inches: of the figure, of a bar with what is around it, below the bars
RIGHT = 0.975  # of the panel, as a share of the width
_NAMES = (0.06, 0.0085)  # of the width, left of the panel: always, and for each letter of a direction
_BEYOND = 1.25  # of the largest mass: where the axis ends
_FAR = 3.0  # times the second largest: a mass beyond would leave the others no room
_LETTERS, _CAUSE = 105, 60  # of what a bar says, and of the cause in it
_APART = 0.012  # of the axis, between a bar and its text


def figure(found: Payload, title: str = "") -> Figure:
    """What `grasp.payload` returns: a bar for each direction, with its mass and what gives out. The dashed line is the
    object's own mass. Raises Unsupported without matplotlib.
    """
    rows = found.by_orientation
    draft = new_figure(figsize=(WIDTH, 6.0), dpi=100)
    above = _head(draft, found, title) + 0.12
    tall = above + ROW * len(rows) + BELOW
    made = new_figure(figsize=(WIDTH, tall), dpi=100)
    _head(made, found, title)
    left = _NAMES[0] + _NAMES[1] * max(len(direction(row.direction)) for row in rows)
    ax = made.add_axes((left, BELOW / tall, RIGHT - left, ROW * len(rows) / tall))
    _bars(ax, found)
    return made


def _head(drawn: Figure, found: Payload, title: str) -> float:
    """Title, payload, what was asked; returns where that ends, in inches below the top."""
    colour = GOOD if found.mass > 0.0 else BAD
    y = opening(drawn, heading(drawn, title), "PAYLOAD", colour, f"{found.headline}.")
    return further(
        drawn, y, " ".join([f"{text[:1].upper()}{text[1:]}." for text in (found.asked, geometry(found))]), GREY
    )


def _bars(ax: Any, found: Payload) -> None:
    """The first direction on top."""
    rows = found.by_orientation
    masses = np.array([row.mass for row in rows])
    end = _end(masses, found.object_mass)
    sectors, number = causes_of(
        [row.binds for row in rows], masses, np.full(len(rows), 1.0 / len(rows)), found.load.grasp.spec
    )
    keys, key = keys_of(sectors)
    panel(ax, "", "mass that is held [kg]", "gravity along")
    y = np.arange(len(rows))[::-1]
    shown = np.where(np.isnan(masses), 0.0, np.minimum(masses, end))
    colours = [keys[k].colour for k in key[number].tolist()]
    ax.barh(y, shown, 0.66, color=colours, edgecolor="#55555566", linewidth=0.5)
    ax.set_xlim(0.0, end)
    across = (ax.figure.bbox.width * ax.get_position().width) / end  # pixels for 1 kg
    for at, row, size in zip(y.tolist(), rows, shown.tolist(), strict=True):
        text = textwrap.shorten(_text(found, row), _LETTERS, placeholder=" …")
        long = width(ax.figure, text, fontsize=SMALL) / across + 2.0 * _APART * end
        fits, ends = size + long < end, size if long < size else end
        box = {"boxstyle": "round,pad=0.18", "facecolor": "white", "edgecolor": "none", "alpha": 0.0 if fits else 0.85}
        x, ha = (size + _APART * end, "left") if fits else (ends - _APART * end, "right")
        ax.text(x, at, text, ha=ha, va="center", fontsize=SMALL, color=INK, bbox=box)
    for at in y[masses > end].tolist():  # goes on beyond the axis
        _cut(ax, end, at)
    if 0.0 < found.object_mass < end:
        ax.axvline(found.object_mass, color=INK, linewidth=1.0, linestyle=(0, (4, 2.5)), zorder=3)
        side = "left" if found.object_mass < 0.7 * end else "right"
        label = {"fontsize": SMALL, "color": INK, "ha": side, "va": "bottom"}
        ax.text(found.object_mass, len(rows) - 0.58, " the object’s mass ", **label)
    ax.set_yticks(y, [direction(row.direction) for row in rows])
    ax.tick_params(axis="y", labelsize=TEXT, length=0)
    ax.grid(visible=False, axis="y")
    ax.set_ylim(-0.5, len(rows) - 0.3)


def _cut(ax: Any, end: float, at: float) -> None:
    """Two slanted gaps in a bar that ends farther than the axis."""
    for share in (0.965, 0.98):
        x = np.array([share - 0.004, share + 0.004]) * end
        ax.plot(x, (at - 0.36, at + 0.36), color="white", linewidth=2.4, solid_capstyle="butt", zorder=2)


def _end(masses: Any, own: float) -> float:
    """The mass at which the axis ends: beyond the largest one, unless that is far beyond all others."""
    known = np.sort(masses[np.isfinite(masses)])
    most = float(known[-1]) if len(known) else 0.0
    if len(known) > 1 and known[-1] > _FAR * known[-2] > 0.0:
        most = _FAR * float(known[-2])
    return max(_BEYOND * most, 1.1 * own) or 1.0


def _text(found: Payload, row: Orientation) -> str:
    """Mass, how the hand moves, what gives out."""
    says = found.cause(row, _CAUSE)
    return f"{row.most} kg{found.moving(row).replace(' and the hand', ', hand')}: {says}"
