"""`draw_payload`: the figure of a payload: a bar for each direction of gravity, coloured by what gives out first."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.studies.envelope.direction import group_causes
from handlcp.studies.envelope.result import describe_geometry, format_direction
from handlcp.studies.grip_strength import Grip, SplitCylinder
from handlcp.studies.payload import Payload
from handlcp.viz.envelope.surface import assign_colours
from handlcp.viz.output_file import Figure
from handlcp.viz.style import (
    BAD_COLOUR,
    BLUE,
    GOOD_COLOUR,
    GREY,
    INK,
    LEFT_MARGIN,
    LINE_HEIGHT,
    RED,
    SMALL_SIZE,
    TEXT_SIZE,
    capitalise,
    draw_sentences,
    draw_title,
    draw_word_and_sentence,
    figure_below,
    shorten_names,
    spread_labels,
    style_panel,
    text_width,
)

# Inches: of the figure, of a bar with what is around it, below the bars, between heading and bars
PAYLOAD_WIDTH, BAR_ROW_HEIGHT, BAR_AXIS_HEIGHT, BARS_GAP = 10.0, 0.42, 0.72, 0.12
PANEL_RIGHT = 0.975  # of the panel, as a share of the width
_NAME_WIDTHS = (0.06, 0.0085)  # of the width, left of the panel: always, and for each letter of a direction
_AXIS_LENGTH_FACTOR = 1.25  # of the largest mass: where the axis ends
_MAX_MASS_RATIO = 3.0  # times the second largest: a mass beyond would leave the others no room
_MAX_BAR_LETTERS, _MAX_CAUSE_LETTERS = 105, 60  # of what a bar says, and of the cause in it
_BAR_TEXT_GAP = 0.012  # of the axis, between a bar and its text


def draw_payload(found: Payload, title: str = "") -> Figure:
    """What `grasp.payload` returns: a bar for each direction, with its mass and what gives out. The dashed line is the
    object's own mass. Raises Unsupported without matplotlib.
    """
    rows, colour = found.by_orientation, GOOD_COLOUR if found.mass > 0.0 else BAD_COLOUR
    asked = f"{capitalise(found.asked)} {capitalise(describe_geometry(found))}"

    def draw_heading(drawn: Figure) -> float:
        y = draw_word_and_sentence(drawn, draw_title(drawn, title), "PAYLOAD", colour, f"{found.headline}.")
        return draw_sentences(drawn, y, asked, GREY)

    rooms = BARS_GAP, BAR_ROW_HEIGHT * len(rows), BAR_AXIS_HEIGHT
    made, _, tall = figure_below(PAYLOAD_WIDTH, draw_heading, *rooms)
    left = _NAME_WIDTHS[0] + _NAME_WIDTHS[1] * max(len(format_direction(row.direction)) for row in rows)
    ax = made.add_axes((left, BAR_AXIS_HEIGHT / tall, PANEL_RIGHT - left, BAR_ROW_HEIGHT * len(rows) / tall))
    _draw_bars(ax, found)
    return made


def _draw_bars(ax: Any, found: Payload) -> None:
    """The first direction on top."""
    rows = found.by_orientation
    masses = np.array([row.mass for row in rows])
    end = _choose_axis_end(masses, found.object_mass)
    shares, binds = np.full(len(rows), 1.0 / len(rows)), [row.binds for row in rows]
    sectors, number = group_causes(binds, masses, shares, found.load.grasp.spec)
    keys, key = assign_colours(sectors)
    style_panel(ax, "", "mass that is held [kg]", "gravity along")
    y = np.arange(len(rows))[::-1]
    shown = np.where(np.isnan(masses), 0.0, np.minimum(masses, end))
    colours = [keys[k].colour for k in key[number].tolist()]
    ax.barh(y, shown, 0.66, color=colours, edgecolor="#55555566", linewidth=0.5)
    ax.set_xlim(0.0, end)
    across = (ax.figure.bbox.width * ax.get_position().width) / end  # pixels for 1 kg
    for at, row, size in zip(y.tolist(), rows, shown.tolist(), strict=True):
        hand = found.moving(row).replace(" and the hand", ", hand")
        text = f"{row.most} kg{hand}: {found.cause(row, _MAX_CAUSE_LETTERS)}"
        text = textwrap.shorten(text, _MAX_BAR_LETTERS, placeholder=" …")
        long = text_width(ax.figure, text, fontsize=SMALL_SIZE) / across + 2.0 * _BAR_TEXT_GAP * end
        fits, ends = size + long < end, size if long < size else end
        box = {"boxstyle": "round,pad=0.18", "facecolor": "white", "edgecolor": "none", "alpha": 0.0 if fits else 0.85}
        x, ha = (size + _BAR_TEXT_GAP * end, "left") if fits else (ends - _BAR_TEXT_GAP * end, "right")
        ax.text(x, at, text, ha=ha, va="center", fontsize=SMALL_SIZE, color=INK, bbox=box)
    for at in y[masses > end].tolist():  # goes on beyond the axis: two slanted gaps
        for share in (0.965, 0.98):
            x = np.array([share - 0.004, share + 0.004]) * end
            ax.plot(x, (at - 0.36, at + 0.36), color="white", linewidth=2.4, solid_capstyle="butt", zorder=2)
    if 0.0 < found.object_mass < end:
        ax.axvline(found.object_mass, color=INK, linewidth=1.0, linestyle=(0, (4, 2.5)), zorder=3)
        side = "left" if found.object_mass < 0.7 * end else "right"
        label = {"fontsize": SMALL_SIZE, "color": INK, "ha": side, "va": "bottom"}
        ax.text(found.object_mass, len(rows) - 0.58, " the object’s mass ", **label)
    ax.set_yticks(y, [format_direction(row.direction) for row in rows])
    ax.tick_params(axis="y", labelsize=TEXT_SIZE, length=0)
    ax.grid(visible=False, axis="y")
    ax.set_ylim(-0.5, len(rows) - 0.3)


def _choose_axis_end(masses: Any, own: float) -> float:
    """The mass at which the axis ends: beyond the largest one, unless that is far beyond all others."""
    known = np.sort(masses[np.isfinite(masses)])
    most = float(known[-1]) if len(known) else 0.0
    if len(known) > 1 and known[-1] > _MAX_MASS_RATIO * known[-2] > 0.0:
        most = _MAX_MASS_RATIO * float(known[-2])
    return max(_AXIS_LENGTH_FACTOR * most, 1.1 * own) or 1.0


# ----------------------------------------------------------------
# The figure of a split cylinder: its cross-section with contacts, forces and split, and the force over the angle.


SPLIT_WIDTH, PANEL_HEIGHT, PANEL_GAP = 10.0, 3.1, 0.55  # inches: of the figure, of a grasp's panels, below them
_SECTION_WIDTH, _CURVE_LEFT = 0.44, 0.53  # shares of the width: of the cross-section, where the curve begins
_SECTION_HALF_HEIGHT, _MAX_ARROW_LENGTH = 1.75, 0.6  # in radii: half of the panel's height; the longest arrow
_LABEL_DISTANCE, _LABEL_HEIGHT = 1.72, 0.44  # in radii: where labels stand, and their height
_MAX_NAME_LETTERS = 15
_MIN_DRAWN_SHARE = 1e-3  # of the largest force: a contact with less is not drawn
_CURVE_POINTS = 721  # of the split
_HALF_COLOURS = ("#F1F3F5", "#DFE4E8")


def draw_split_cylinder(found: SplitCylinder, title: str = "") -> Figure:
    """A row for each grasp. Left, the cylinder along its axis, the contacts' forces on it and the split that is
    measured across. Right, the force across the split as it is turned from there, which jumps where the split passes a
    contact. Raises Unsupported without matplotlib.
    """

    def draw_heading(drawn: Figure) -> float:
        y = draw_sentences(drawn, draw_title(drawn, title), capitalise(found.headline))
        for kind, why in found.missing.items():
            y = draw_sentences(drawn, y, f"No {kind} grasp: {why}.", GREY)
        return y + 0.5 * LINE_HEIGHT

    row = LINE_HEIGHT + PANEL_HEIGHT + PANEL_GAP
    made, above, tall = figure_below(SPLIT_WIDTH, draw_heading, row * len(found.grips))
    for k, grip in enumerate(found.grips):
        top = above + k * row
        made.text(LEFT_MARGIN, 1.0 - top / tall, f"{grip}.", fontsize=TEXT_SIZE, color=INK, va="top", wrap=True)
        bottom = 1.0 - (top + LINE_HEIGHT + PANEL_HEIGHT) / tall
        _draw_cross_section(made.add_axes((LEFT_MARGIN, bottom, _SECTION_WIDTH, PANEL_HEIGHT / tall)), found, grip)
        place = (_CURVE_LEFT, bottom + 0.1 / tall, PANEL_RIGHT - _CURVE_LEFT, (PANEL_HEIGHT - 0.45) / tall)
        _draw_force_curve(made.add_axes(place), grip)
    return made


def _draw_cross_section(ax: Any, found: SplitCylinder, grip: Grip) -> None:
    """Seen along the axis, the normal of the split to the right."""
    from matplotlib.patches import Wedge

    r, around = 0.5 * found.diameter, grip.around
    across = _normal_across_axis(around, grip.normal)
    axes = np.stack([across, np.cross(around.axis, across)])
    for begin, colour in zip((-90.0, 90.0), _HALF_COLOURS, strict=True):
        ax.add_patch(Wedge((0.0, 0.0), r, begin, begin + 180.0, facecolor=colour, edgecolor=GREY, linewidth=1.0))
    ax.plot((0.0, 0.0), (-1.25 * r, 1.25 * r), color=RED, linewidth=1.6, linestyle=(0, (5, 2.5)), zorder=3)
    ax.text(0.0, 1.3 * r, "split", color=RED, fontsize=SMALL_SIZE, ha="center", va="bottom")
    sizes = np.linalg.norm(around.forces, axis=1)
    press = sizes > _MIN_DRAWN_SHARE * sizes.max(initial=0.0)  # others would only crowd out the labels of these
    places, forces = around.positions[press] @ axes.T, around.forces[press] @ axes.T
    long = float(np.linalg.norm(forces, axis=1).max(initial=0.0)) or 1.0
    style = {"arrowstyle": "-|>", "color": BLUE, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 13}
    tails = places - _MAX_ARROW_LENGTH * r * forces / long
    for p, tail in zip(places, tails, strict=True):
        ax.annotate("", xy=tuple(p), xytext=tuple(tail), arrowprops=style, zorder=4)
    names = shorten_names([grip.solution.names[i] for i in np.flatnonzero(press)], _MAX_NAME_LETTERS)
    texts = [f"{name}\n{words.format_force(float(np.linalg.norm(f)))}" for name, f in zip(names, forces, strict=True)]
    for side in (-1.0, 1.0):
        _draw_force_labels(ax, tails / r, texts, side, r)
    ax.axis("off")
    ax.set_aspect("equal")
    wide = _SECTION_HALF_HEIGHT * r * SPLIT_WIDTH * _SECTION_WIDTH / PANEL_HEIGHT
    ax.set_xlim(-wide, wide)
    ax.set_ylim(-_SECTION_HALF_HEIGHT * r, _SECTION_HALF_HEIGHT * r)


def _draw_force_labels(ax: Any, tails: Array, texts: list[str], side: float, r: float) -> None:
    """A column of what the arrows on one side (-1 left, 1 right) are, beside their tails (n, 2), in radii."""
    own = [k for k in np.argsort(tails[:, 1], kind="stable").tolist() if (tails[k, 0] > 0.0) == (side > 0.0)]
    wanted = [float(tails[k, 1]) - 0.5 * _LABEL_HEIGHT for k in own]
    lows = spread_labels(wanted, [_LABEL_HEIGHT] * len(own), -_SECTION_HALF_HEIGHT, _SECTION_HALF_HEIGHT)
    for k, low in zip(own, lows, strict=True):
        x, y = side * _LABEL_DISTANCE * r, (low + 0.5 * _LABEL_HEIGHT) * r
        ax.plot((tails[k, 0] * r, x), (tails[k, 1] * r, y), color=GREY, linewidth=0.6, zorder=2)
        align = {"ha": "left" if side > 0.0 else "right", "va": "center"}
        ax.text(x + 0.05 * side * r, y, texts[k], fontsize=SMALL_SIZE - 1.0, color=INK, linespacing=1.05, **align)


def _normal_across_axis(around: Any, normal: Array) -> Array:
    """The normal across the axis, of length 1."""
    n: Array = around.remove_axial_part(np.asarray(normal))
    return n / np.linalg.norm(n)


def _draw_force_curve(ax: Any, grip: Grip) -> None:
    """The force over the angle of the split from the one that is measured; vertical where it passes a contact."""
    style_panel(ax, "", "split turned by [°]", "force across the split [N]")
    angles = np.linspace(-90.0, 90.0, _CURVE_POINTS)
    x = _normal_across_axis(grip.around, grip.normal)
    y = np.cross(grip.around.axis, x)
    turned = np.radians(angles)
    forces = [grip.around.split_force(np.cos(a) * x + np.sin(a) * y) for a in turned.tolist()]
    ax.plot(angles, forces, color=INK, linewidth=1.6)
    ax.plot([0.0], [grip.force], "o", color=RED, markersize=7, zorder=4)
    ax.axvline(0.0, color=RED, linewidth=1.2, linestyle=(0, (5, 2.5)), zorder=1.5)
    style: dict[str, Any] = {"color": RED, "fontsize": SMALL_SIZE, "ha": "left", "va": "bottom"}
    says = f"{words.format_force(grip.force)} measured"
    ax.annotate(says, xy=(0.0, grip.force), xytext=(7, 6), textcoords="offset points", **style)
    low, high = min(0.0, grip.least), grip.largest
    ax.set_ylim(1.1 * low, 1.18 * high or 1.0)
    ax.set_xlim(-90.0, 90.0)
    ax.set_xticks(np.arange(-90, 91, 30))
