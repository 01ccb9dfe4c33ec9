"""The figure of a split cylinder: its cross-section with contacts, forces and split, and the force over the angle."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.show.file import Figure, new_figure
from handlcp.show.style import BLUE, GREY, INK, LEFT, LINE, RED, SMALL, TEXT, further, heading, panel, shortened, spread
from handlcp.study.grip_strength import Grip, SplitCylinder

WIDTH, TALL, BELOW = 10.0, 3.1, 0.55  # inches: of the figure, of a grasp's panels, below them
_SIDE, _RIGHT = 0.44, 0.53  # shares of the width: of the cross-section, where the curve begins
_ROOM, _ARROW = 1.75, 0.6  # in radii: half of the panel's height; the longest arrow
_LABEL, _TALL, _NAME = 1.72, 0.44, 15  # in radii: where labels stand, and their height; letters of a name
_NOTHING = 1e-3  # of the largest force: a contact with less is not drawn
_ANGLES = 721  # of the split
_HALVES = ("#F1F3F5", "#DFE4E8")


def figure(found: SplitCylinder, title: str = "") -> Figure:
    """A row for each grasp. Left, the cylinder along its axis, the contacts' forces on it and the split that is
    measured across. Right, the force across the split as it is turned from there, which jumps where the split passes a
    contact. Raises Unsupported without matplotlib.
    """
    draft = new_figure(figsize=(WIDTH, 6.0), dpi=100)
    above = _head(draft, found, title)
    row = LINE + TALL + BELOW
    tall = above + row * len(found.grips)
    made = new_figure(figsize=(WIDTH, tall), dpi=100)
    _head(made, found, title)
    for k, grip in enumerate(found.grips):
        top = above + k * row
        made.text(LEFT, 1.0 - top / tall, f"{grip}.", fontsize=TEXT, color=INK, va="top", wrap=True)
        bottom = 1.0 - (top + LINE + TALL) / tall
        _section(made.add_axes((LEFT, bottom, _SIDE, TALL / tall)), found, grip)
        _curve(made.add_axes((_RIGHT, bottom + 0.1 / tall, 0.975 - _RIGHT, (TALL - 0.45) / tall)), grip)
    return made


def _head(drawn: Figure, found: SplitCylinder, title: str) -> float:
    """Title, what was measured with, what is missing; returns where that ends, in inches below the top."""
    text = f"{found.headline[:1].upper()}{found.headline[1:]}."
    y = further(drawn, heading(drawn, title), text)
    for kind, why in found.missing.items():
        y = further(drawn, y, f"No {kind} grasp: {why}.", GREY)
    return y + 0.5 * LINE


def _section(ax: Any, found: SplitCylinder, grip: Grip) -> None:
    """Seen along the axis, the normal of the split to the right."""
    from matplotlib.patches import Wedge

    r, around = 0.5 * found.diameter, grip.around
    across = _flat(around, grip.normal)
    axes = np.stack([across, np.cross(around.axis, across)])
    for begin, colour in zip((-90.0, 90.0), _HALVES, strict=True):
        ax.add_patch(Wedge((0.0, 0.0), r, begin, begin + 180.0, facecolor=colour, edgecolor=GREY, linewidth=1.0))
    ax.plot((0.0, 0.0), (-1.25 * r, 1.25 * r), color=RED, linewidth=1.6, linestyle=(0, (5, 2.5)), zorder=3)
    ax.text(0.0, 1.3 * r, "split", color=RED, fontsize=SMALL, ha="center", va="bottom")
    sizes = np.linalg.norm(around.forces, axis=1)
    press = sizes > _NOTHING * sizes.max(initial=0.0)  # others would only crowd out the labels of these
    places, forces = around.positions[press] @ axes.T, around.forces[press] @ axes.T
    long = float(np.linalg.norm(forces, axis=1).max(initial=0.0)) or 1.0
    style = {"arrowstyle": "-|>", "color": BLUE, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 13}
    tails = places - _ARROW * r * forces / long
    for p, tail in zip(places, tails, strict=True):
        ax.annotate("", xy=tuple(p), xytext=tuple(tail), arrowprops=style, zorder=4)
    names = shortened([name for name, yes in zip(grip.solution.names, press.tolist(), strict=True) if yes], _NAME)
    texts = [f"{name}\n{words.force(float(np.linalg.norm(f)))}" for name, f in zip(names, forces, strict=True)]
    for side in (-1.0, 1.0):
        _labels(ax, tails / r, texts, side, r)
    ax.axis("off")
    ax.set_aspect("equal")
    ax.set_xlim(-_ROOM * r * WIDTH * _SIDE / TALL, _ROOM * r * WIDTH * _SIDE / TALL)
    ax.set_ylim(-_ROOM * r, _ROOM * r)


def _labels(ax: Any, tails: Array, texts: list[str], side: float, r: float) -> None:
    """A column of what the arrows on one side (-1 left, 1 right) are, beside their tails (n, 2), in radii."""
    own = [k for k in np.argsort(tails[:, 1], kind="stable").tolist() if (tails[k, 0] > 0.0) == (side > 0.0)]
    wanted = [float(tails[k, 1]) - 0.5 * _TALL for k in own]
    for k, low in zip(own, spread(wanted, [_TALL] * len(own), -_ROOM, _ROOM), strict=True):
        x, y = side * _LABEL * r, (low + 0.5 * _TALL) * r
        ax.plot((tails[k, 0] * r, x), (tails[k, 1] * r, y), color=GREY, linewidth=0.6, zorder=2)
        align = {"ha": "left" if side > 0.0 else "right", "va": "center"}
        ax.text(x + 0.05 * side * r, y, texts[k], fontsize=SMALL - 1.0, color=INK, linespacing=1.05, **align)


def _flat(around: Any, normal: Array) -> Array:
    """The normal across the axis, of length 1."""
    n: Array = around.flat(np.asarray(normal))
    return n / np.linalg.norm(n)


def _curve(ax: Any, grip: Grip) -> None:
    """The force over the angle of the split from the one that is measured; vertical where it passes a contact."""
    panel(ax, "", "split turned by [°]", "force across the split [N]")
    angles = np.linspace(-90.0, 90.0, _ANGLES)
    x = _flat(grip.around, grip.normal)
    y = np.cross(grip.around.axis, x)
    turned = np.radians(angles)
    forces = [grip.around.across(np.cos(a) * x + np.sin(a) * y) for a in turned.tolist()]
    ax.plot(angles, forces, color=INK, linewidth=1.6)
    ax.plot([0.0], [grip.force], "o", color=RED, markersize=7, zorder=4)
    ax.axvline(0.0, color=RED, linewidth=1.2, linestyle=(0, (5, 2.5)), zorder=1.5)
    style: dict[str, Any] = {"color": RED, "fontsize": SMALL, "ha": "left", "va": "bottom"}
    says = f"{words.force(grip.force)} measured"
    ax.annotate(says, xy=(0.0, grip.force), xytext=(7, 6), textcoords="offset points", **style)
    low, high = min(0.0, grip.least), grip.largest
    ax.set_ylim(1.1 * low, 1.18 * high or 1.0)
    ax.set_xlim(-90.0, 90.0)
    ax.set_xticks(np.arange(-90, 91, 30))
