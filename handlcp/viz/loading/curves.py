"""`Panel`: curves over the steps of a loading, with the names and colours of what they belong to."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.grasp import Grasp, GraspSolution
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.follow import Loading
from handlcp.hand.hand_grasp import make_grasp
from handlcp.viz.style import (
    BLUE,
    GREEN,
    INK,
    PURPLE,
    RED,
    SMALL_SIZE,
    TEXT_SIZE,
    has_visible_turn,
    shorten_names,
    spread_labels,
    style_panel as frame,
)

# ----------------------------------------------------------------
# The last step of a loading as a grasp of its own, for pictures and tables of what is known of one solve.


def grasp_at_end(loading: Loading) -> Grasp:
    """The grasp at the last step of a loading: its contacts, its load and the hand's posture there."""
    last = loading.last
    return make_grasp(loading.steps.grasp.made(last.iterate, last.loads))


def solution_at_end(loading: Loading) -> GraspSolution:
    """The solution at the last step of a loading, with the slips of the whole way.

    Each slip leads to where the object is, and is as long as the way on which it slid.
    """
    way, slip = loading.steps.slid[-1], loading.steps.slip_on_the_way
    straight = np.hypot(*slip.T)
    ahead = np.where(straight[:, None] > 0.0, slip, (1.0, 0.0)) / np.where(straight > 0.0, straight, 1.0)[:, None]
    return replace(loading.solution, slip=read_only(way[:, None] * ahead))


# ----------------------------------------------------------------

CURVE_COLOURS = (BLUE, RED, GREEN, PURPLE, "#B87800", "#3A9BD8", "#7A3E00", "#8C8C00")
OTHER_CURVES_COLOUR = "#B9BEC4"
MAX_NAME_LETTERS = 28  # of a curve's name
_MAX_NAMED_JOINTS = 6  # joints with a name in their panel: those nearest to their limits


@dataclass(frozen=True, slots=True)
class Curve:
    """One curve of a panel over the steps of a loading.

    name : at its end; "" for none. colour : "#rrggbb". values (m,) : at each step, NaN where there is none.
    """

    name: str
    colour: str
    values: Array


@dataclass(frozen=True, slots=True)
class Panel:
    """One panel of the figure of a loading: curves of one quantity over the steps.

    title : the quantity with its unit.
    all_curves_name : what to call all curves when they lie on each other, such as "all 5 fingers".
    limit : value of the line across; None without one.
    min_span : curves that span less than this, in the panel's unit, show rounding alone.
    """

    title: str
    curves: tuple[Curve, ...]
    all_curves_name: str
    limit: float | None = None
    min_span: float = 1e-6


def make_panels(spec: GraspSpec, forces: Array, used: Array | None, displacement: Array, torques: Array) -> list[Panel]:
    """Normal forces, friction, motion and turn of the object along the world's axes, joint torques: those that this
    grasp has.

    forces (m, n, 3) [N], displacement (m, 6) [m, rad], torques (m, nv) [N·m] : at m places. used (m, n) : shares of the
    friction limits; None: not known, and no friction is shown.
    """
    scene, mechanism = Grasp(spec).scene, spec.mechanism
    n, names = scene.n, shorten_names(spec.names, MAX_NAME_LETTERS)
    colours = [CURVE_COLOURS[i % len(CURVE_COLOURS)] for i in range(n)]
    every = f"all {n} {spec.who}s"
    out = [Panel("Normal force [N]", _make_curves(names, colours, forces[:, :, 2]), every)]
    if used is not None and (scene.mu > 0).any():
        out.append(Panel("Friction [% of its limit]", _make_curves(names, colours, 100.0 * used), every, 100.0))
    along, move, turn = (RED, GREEN, BLUE), displacement[:, :3], displacement[:, 3:]
    unit = words.choose_length_unit(move.ravel().tolist())
    title = f"Motion of the object [{unit.name}]"
    out.append(Panel(title, _make_curves("xyz", along, move / unit.size), "x, y, z"))
    if has_visible_turn(turn):
        out.append(Panel("Turn of the object [°]", _make_curves("xyz", along, np.degrees(turn)), "x, y, z"))
    if mechanism is not None:
        out.append(_make_torque_panel(mechanism.names, torques, mechanism.limits))
    return out


def _make_curves(names: Sequence[str], colours: Sequence[str], values: Array) -> tuple[Curve, ...]:
    return tuple([Curve(*each) for each in zip(names, colours, values.T, strict=True)])


def _make_torque_panel(names: Sequence[str], torques: Array, limits: Array) -> Panel:
    """Against their limits where these are known; the nearest to them are named."""
    known = np.flatnonzero(np.isfinite(limits) & (limits > 0.0))
    shown = known if len(known) else np.arange(len(names))
    names = shorten_names(names, MAX_NAME_LETTERS)
    values = 100 * abs(torques[:, known]) / limits[known] if len(known) else torques
    most = abs(values).max(axis=0)
    ranked = np.argsort(-np.round(most, 6), kind="stable")
    curves = [Curve("", OTHER_CURVES_COLOUR, values[:, j]) for j in ranked[_MAX_NAMED_JOINTS:]]
    curves += [Curve(names[shown[j]], CURVE_COLOURS[k], values[:, j]) for k, j in enumerate(ranked[:_MAX_NAMED_JOINTS])]
    title = "Joint torque [% of its limit]" if len(known) else "Joint torque [N·m]"
    if len(ranked) > _MAX_NAMED_JOINTS:
        title += f", the {_MAX_NAMED_JOINTS} largest of {len(ranked)} in colour"
    every = f"all {len(curves)} joints"
    near = bool(len(known)) and float(most.max(initial=0.0)) > 50.0
    return Panel(title, tuple(curves), every, 100.0 if near else None)


# ----------------------------------------------------------------
# The axis that all panels share: stages side by side, each from 0 to 100 %; and what any such axis has.

_CROWDED_STAGES = 5  # stages from which on only their ends have a tick
_MAX_QUARTERED_STAGES = 2  # stages up to which every quarter has one


@dataclass(frozen=True, slots=True)
class PanelAxis:
    """What panels need of the axis along x, which begins at 0.

    places (m,) : place of each point of the curves.
    lost_at : where the path ends before the axis does; None where it does not. lost_label : how that is marked.
    end : where the axis ends.
    draw_ticks : draws ticks into axes, with their names below them if the second argument says so.
    """

    places: Array
    lost_at: float | None
    lost_label: str
    end: float
    draw_ticks: Callable[[Any, bool], None]


def stage_axis(loading: Loading) -> PanelAxis:
    """The axis of a loading: stage k lies from k to k + 1."""
    stages, n = loading.stages, len(loading.stages)

    def draw_ticks(ax: Any, named: bool) -> None:
        from matplotlib.ticker import FixedFormatter, FixedLocator

        shares = (0.25, 0.5, 0.75) if n <= _MAX_QUARTERED_STAGES else (0.5,) if n < _CROWDED_STAGES else ()
        places = [0.0, *(k + share for k in range(n) for share in (*shares, 1.0))]
        texts = ["0", *([f"{100 * share:.0f} %" for share in shares] + ["100 %"]) * n]
        ax.set_xlim(0.0, n)
        ax.xaxis.set_major_locator(FixedLocator(places))
        ax.xaxis.set_major_formatter(FixedFormatter(texts))
        ax.tick_params(labelbottom=named, labelsize=SMALL_SIZE)
        for k in range(1, n):
            ax.axvline(k, color="#9A9A9A", linewidth=0.9, zorder=1.5)
        for k, name in enumerate(stages if named else ()):
            style = {"fontsize": TEXT_SIZE, "weight": "bold", "color": INK, "ha": "center", "va": "top"}
            across = (ax.transAxes.inverted().transform(ax.transData.transform((k + 0.5, 0.0))))[0]
            ax.annotate(name, (across, 0.0), (0.0, -19.0), "axes fraction", textcoords="offset points", **style)

    lost_at = next((e.number + e.share for e in loading.events if e.kind == "lost"), None)
    return PanelAxis(loading.steps.stage + loading.steps.share, lost_at, "lost", float(n), draw_ticks)


# ----------------------------------------------------------------
# One panel of a loading: its curves, and their names at the right edge.

LABEL_LETTERS = 29  # of a line of names
SAME_CURVE_TOLERANCE = 0.01  # of the panel's height: curves no further apart than this share a name
LABEL_ROW = 0.165  # inches of a line of a name
LABEL_GAP = 0.12  # inches from the panel to the names


def draw_panel(ax: Any, axis: PanelAxis, panel: Panel, last: bool) -> None:
    """Draw the curves of one panel with room around them, the line of its limit, and the names of the curves at the
    right edge; zero is always shown.

    last : whether it is the lowest panel, below which the stages have their names.
    """
    frame(ax, panel.title, "", "")
    axis.draw_ticks(ax, last)
    for c in panel.curves:
        ax.plot(axis.places, c.values, color=c.colour, linewidth=1.6 if c.name else 0.9, zorder=3 if c.name else 2.5)
        if np.isfinite(c.values[-1]):
            ax.plot(axis.places[-1:], c.values[-1:], "o", color=c.colour, markersize=3.2, clip_on=False, zorder=5)
    also = [0.0] if panel.limit is None else [0.0, panel.limit]
    every = np.concatenate([*(c.values for c in panel.curves), also])
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    if high - low < panel.min_span:
        low, high = 0.0, 1.0
    span = high - low
    ax.set_ylim(low - (0.08 * span if low < 0.0 else 0.0), high + 0.08 * span)
    ax.ticklabel_format(axis="y", style="plain", useOffset=False)
    if panel.limit is not None:
        ax.axhline(panel.limit, color=INK, linewidth=1.0, linestyle=(0, (4, 2.5)), zorder=1.7)
    _draw_labels(ax, axis, _curve_labels(ax, panel))


CurveEndLabel = tuple[float, str, str]  # height of the curve's end as a share of the panel's, name, colour


def _curve_labels(ax: Any, panel: Panel) -> list[CurveEndLabel]:
    """One for each group of curves that lie on each other, from below; none for curves that end before the last step,
    such as the friction of a finger that has let go.
    """
    low, high = ax.get_ylim()
    groups = list[list[Curve]]()
    for c in panel.curves:
        if not c.name or not np.isfinite(c.values[-1]):
            continue
        for group in groups:
            if np.allclose(group[0].values, c.values, 0.0, SAME_CURVE_TOLERANCE * (high - low), equal_nan=True):
                group.append(c)
                break
        else:
            groups.append([c])
    out = []
    for group in reversed(groups):
        first, *rest = [c.name for c in group]
        alike = f"{first} and {len(rest)} alike" if len(rest) > 1 else ", ".join([first, *rest])
        name = panel.all_curves_name if len(group) == len(panel.curves) > 1 else alike
        top = group[-1]  # the curve that is drawn over the others
        out.append((float((top.values[-1] - low) / (high - low)), name, top.colour))
    return sorted(out, key=lambda label: round(label[0], 3))


def _draw_labels(ax: Any, axis: PanelAxis, labels: list[CurveEndLabel]) -> None:
    """Names at the right edge, as near to the ends of their curves as there is room, each with a line to there."""
    box, dpi = ax.get_window_extent(), ax.figure.dpi
    texts = [textwrap.fill(name, LABEL_LETTERS, break_long_words=False) for _, name, _ in labels]
    row = LABEL_ROW * dpi / box.height
    sizes = [row * (1 + text.count("\n")) for text in texts]
    wanted = [height - size / 2 for (height, _, _), size in zip(labels, sizes, strict=True)]
    places = spread_labels(wanted, sizes, -np.inf, 1.25)
    inch = dpi / box.width
    x, bend, text_at = float(axis.places[-1] / axis.end), 1.0 + 0.03 * inch, 1.0 + LABEL_GAP * inch
    for (height, _, colour), text, size, low in zip(labels, texts, sizes, places, strict=True):
        middle = low + size / 2
        leader = [x, bend, text_at - 0.04 * inch], [height, height, middle]
        ax.plot(*leader, transform=ax.transAxes, color=colour, linewidth=0.7, clip_on=False, zorder=2.2)
        style = {"fontsize": TEXT_SIZE - 0.5, "color": colour, "va": "center", "linespacing": 1.1}
        ax.text(text_at, middle, text, transform=ax.transAxes, **style)
