"""`draw_legend` and what else is written of a picture: title, verdict, labels of contacts, torques of joints."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from handlcp import words
from handlcp.grasp import Verdict
from handlcp.grasp.model.status import SEPARATED, SLIDING, STICKING, UNKNOWN, ContactStatus, contact_words
from handlcp.viz.picture.content import (
    ESCAPE_COLOUR,
    LOAD_COLOUR,
    MIN_DRAWN_MOMENT,
    SLIP_COLOUR,
    STATUS_COLOURS,
    UNKNOWN_COLOUR,
    PictureContent,
)
from handlcp.viz.style import (
    BAD_COLOUR,
    BLUE,
    GREY,
    INK,
    LEFT_MARGIN,
    RED,
    WORD_COLOURS,
    describe_motion,
    draw_title,
    draw_word_and_sentence,
    shorten_names,
    wrap_to_width,
)

# kind ("patch", "hatch", "outline", "cone", "dot", "ring", "line", "dashed", "dashed-thin", "turn", "none"), colour,
# and text
LegendEntry = tuple[str, str, str]

TORQUE_ROW = 0.058  # height of a joint, as a share of the figure
MAX_BAR_LETTERS = 31  # that fit a bar's width: joint and share, bold, at full size
MIN_NAME_LETTERS = 20  # letters of a joint's name that are always shown
_MAX_PEAK_RATIO = 2.0  # times what is held for good: how far the peak of a motor is drawn
_UNIT_PATTERN = re.compile(r"(\d) (?=\S)")  # between a number and its unit


def draw_verdict_headline(figure: Any, v: Verdict, title: str, drawn: str) -> float:
    """Title, the verdict's word and first reason, and which state is drawn, at the top; returns where the picture may
    begin, as a share of the height.
    """
    reason = f"{v.reasons[0].sentence}." if v.reasons else ""
    colour = WORD_COLOURS.get(v.word, BAD_COLOUR)
    y = draw_word_and_sentence(figure, draw_title(figure, title), v.word, colour, reason, most=4)
    tall = float(figure.get_size_inches()[1])
    figure.text(LEFT_MARGIN, 1.0 - (y + 0.01) / tall, drawn, color=GREY, fontsize=9.5, va="top")
    return 1.0 - (y + 0.31) / tall


def draw_legend(figure: Any, left: float, top: float, entries: list[LegendEntry]) -> float:
    """Symbols and their meaning, from (left, top) down; returns where they end. All in shares of the figure."""
    across = 0.985 - left - 0.034  # beside the symbols
    style = {"frameon": False, "fontsize": 9.5, "labelcolor": INK}
    handles = []
    for kind, colour, meaning in entries:
        whole = _UNIT_PATTERN.sub("\\1\N{NO-BREAK SPACE}", meaning)
        lines = [part for line in whole.split("\n") for part in wrap_to_width(figure, line, 44, across, fontsize=9.5)]
        handles.append(_legend_symbol(kind, colour, "\n".join(lines)))
    spacing = {"handlelength": 1.7, "labelspacing": 0.62, "borderaxespad": 0.0, "borderpad": 0.0}
    shown = figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(left, top), **style, **spacing)
    return float(shown.get_window_extent().y0 / figure.bbox.height)


def _legend_symbol(kind: str, colour: str, meaning: str) -> Any:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    if kind in ("patch", "cone"):
        alpha = 0.55 if kind == "patch" else 0.25
        return Patch(facecolor=colour, alpha=alpha, edgecolor=colour, label=meaning)
    if kind == "hatch":
        return Patch(facecolor="#D5D7DA", edgecolor=colour, hatch="//////", linewidth=0.0, label=meaning)
    if kind == "outline":
        return Patch(facecolor="white", edgecolor=colour, linewidth=0.9, linestyle=(0, (3, 1.5)), label=meaning)
    point: dict[str, Any] = {"linestyle": "", "color": colour, "label": meaning}
    if kind == "dot":
        return Line2D([], [], marker="o", markersize=7, **point)
    if kind == "ring":
        return Line2D([], [], marker="o", markersize=6, markerfacecolor="white", markeredgewidth=1.6, **point)
    if kind == "turn":
        return Line2D([], [], marker=r"$\circlearrowleft$", markersize=11, markeredgewidth=0.4, **point)
    dash: Any = {"line": "-", "dashed": (0, (1.6, 0.8)), "dashed-thin": (0, (4, 2))}.get(kind, "")
    return Line2D([], [], color=colour, linewidth=1.0 if kind == "dashed-thin" else 3.2, linestyle=dash, label=meaning)


def draw_torque_bars(figure: Any, across: tuple[float, float], top: float, check: Any) -> None:
    """A bar for each of the joints nearest to their limits, below `top`, and on it how far the peak of a motor goes
    beyond what it holds for good. across : left and width.
    """
    known = [r for r in check if r.known and np.isfinite(r.limit)]
    most = max(2, int((top - 0.055) / TORQUE_ROW))
    rows = sorted(known, key=lambda r: (-round(r.utilisation, 6), r.joint != check.binding))[:most]
    ax = figure.add_axes((across[0], top - TORQUE_ROW * max(len(rows), 1), across[1], TORQUE_ROW * max(len(rows), 1)))
    ax.axis("off")
    title = "Joint torque, share of limit"
    figure.text(across[0], top + 0.012, title, fontsize=10, weight="bold", color=INK, va="bottom")
    if not rows:
        ax.text(0, 1, "no joint has a known limit", fontsize=9.5, color=INK, va="top")
        return
    peaks = [0.0 if r.motor is None else r.motor.gives / r.limit for r in rows]
    widest = max(1.0, max(r.utilisation for r in rows), min(max(peaks), _MAX_PEAK_RATIO))
    said = [f"{words.format_percent(r.utilisation)} of {words.format_effort(r.limit, r.unit)}" for r in rows]
    names = shorten_names([r.joint for r in rows], max(MIN_NAME_LETTERS, MAX_BAR_LETTERS - max(map(len, said))))
    longest = max(len(name) + len(words) for name, words in zip(names, said, strict=True))
    size = 9.0 * min(1.0, MAX_BAR_LETTERS / longest)
    for k, r in enumerate(rows):
        over, binding = r.over, r.joint == check.binding
        colour = RED if over else BLUE if binding else "#8FB8D4"
        ax.barh(k + 0.72, 1.0, height=0.26, color="#ECEEF0", zorder=1)
        if peaks[k] > 1.0:  # for a moment
            moment = {"color": "white", "edgecolor": "#9AA0A6", "linewidth": 0.7, "zorder": 0.5}
            ax.barh(k + 0.72, min(peaks[k], widest), height=0.26, **moment)
        ax.barh(k + 0.72, r.utilisation, height=0.26, color=colour, zorder=2)
        style = {"va": "bottom", "fontsize": size, "color": INK, "weight": "bold" if over or binding else "normal"}
        ax.text(0, k + 0.54, names[k], ha="left", **style)
        ax.text(widest, k + 0.54, said[k], ha="right", **style)
    notes = ["grey: held for good; outline: peak"] if max(peaks) > 1.0 else []
    if (left_out := len(known) - len(rows)) > 0:
        least = words.format_percent(rows[-1].utilisation)
        notes.append(f"and {left_out} joint{'s' if left_out > 1 else ''} with {least} or less")
    ax.text(0, len(rows) + 0.18, "\n".join(notes), fontsize=9, color="#555555", va="top")
    ax.set_xlim(0, widest)
    ax.set_ylim(len(rows), 0)


# ----------------------------------------------------------------
# What is written of a picture's content: the legend, the labels of contacts, and which state is drawn.

MOVED_OBJECT_COLOUR = "#7A5A10"


LabelText = tuple[tuple[int, ...], str, str]  # contacts that share a label, its name, and what stands below the name

_NUMBER_PATTERN = re.compile(r"[\s_]*\d+$")


def describe_drawn_state(shown: PictureContent, path: Any, at_end: bool) -> str:
    """A sentence or two. path : the loading that the verdict is about, or None; at_end : whether its end is drawn."""
    if at_end:
        what = "end" if path.reached else "last step"
        return f"Drawn: the {what} of the loading. The object has {describe_motion(path.displacement)}."
    hand = getattr(shown.grasp, "state", None) is not None
    where, squeeze = ("in the given posture", "squeeze") if hand else ("with the given contacts", "preload")
    if not shown.solution.held:
        return f"Drawn: the grasp {where}, without forces, as no equilibrium was found."
    drawn = f"Drawn: one solve {where}, {squeeze} and load at once"
    return f"{drawn}." if path is None else f"{drawn}. The verdict follows the loading in steps."


def make_label_texts(shown: PictureContent, room: int) -> list[LabelText]:
    """One label for each contact; where there is no room for so many, one for all contacts of a name and a state, the
    largest such groups first, or of a link and a state.
    """
    names = shown.solution.names
    single = {i: ((i,), names[i], _contact_detail(shown, i)) for i in shown.drawn_contacts}
    groups, links = dict[tuple[str, ContactStatus], list[int]](), shown.grasp.spec.links
    for i in shown.drawn_contacts:
        alike = links.get(names[i], names[i]) if links else _NUMBER_PATTERN.sub("", names[i])
        groups.setdefault((alike, shown.statuses[i]), []).append(i)
    out, count = list[LabelText](), len(shown.drawn_contacts)
    for (stem, status), members in sorted(groups.items(), key=lambda group: -len(group[1])):
        if len(members) > 1 and (count > room or (links and len(shown.drawn_contacts) > room)):
            count -= len(members) - 1
            forces = shown.solution.normal_force[members]
            low, high = words.format_force(float(forces.min())), words.format_force(float(forces.max()))
            each = f"{low} each" if low == high else f"{low.removesuffix(' N')} to {high}"
            does = {SEPARATED: "let go", STICKING: f"{each}, stick", SLIDING: f"{each}, slide"}.get(status, "")
            out.append((tuple(members), f"{stem}: {len(members)} contacts", does))
        else:
            out += [single[i] for i in members]
    return sorted(out)


def _contact_detail(shown: PictureContent, i: int) -> str:
    """What a contact's label says below its name."""
    s = shown.solution
    if not s.held:
        return f"μ = {shown.grasp.contacts[i].mu:g}" if shown.grasp.contacts[i].mu else "frictionless"
    if shown.statuses[i] == SEPARATED:
        return f"lets go, gap {words.format_length(float(s.gap[i]))}"
    normal, friction = float(s.normal_force[i]), float(np.linalg.norm(s.tangential_force[i]))
    push = words.format_contact_force(normal, friction)
    # A moment is written in place of the state, which the colour shows: a longer line would shrink the picture
    if s.torsion is not None and abs(s.torsion[i]) > MIN_DRAWN_MOMENT:
        return f"{push}, {words.format_torque(abs(float(s.torsion[i])))}"
    return f"{push}, {'sticks' if shown.statuses[i] == STICKING else 'slides'}"


def legend_entries(shown: PictureContent, unseen: list[int], load_seen: bool, hidden: bool) -> list[LegendEntry]:
    """The lines of a picture's legend: solids, contacts, load, motion.

    unseen : contacts whose slip is too small to draw. load_seen : whether the load is not.
    hidden : whether a contact point is behind object or hand.
    """
    return [*_solid_entries(shown), *_contact_entries(shown, hidden), *_motion_entries(shown, unseen, load_seen)]


def _solid_entries(shown: PictureContent) -> Iterator[LegendEntry]:
    if shown.object_body is not None:
        yield "patch", "#C08A2B", shown.object_body.label
    if shown.links_inside:
        most, names = words.format_length(max(shown.links_inside.values())), list(shown.links_inside)
        who = names[0] if len(names) == 1 else f"{len(names)} links"
        depth = most if len(names) == 1 else f"up to {most}"
        yield "hatch", STATUS_COLOURS[SLIDING], f"inside the object: {who}, {depth}"
    if shown.tip_triangles:
        which = "link's" if shown.grasp.spec.links else "fingertip"
        yield "outline", LOAD_COLOUR, f"{which} shape that finds the contact"


def _contact_entries(shown: PictureContent, hidden: bool) -> Iterator[LegendEntry]:
    s, scene = shown.solution, shown.grasp.scene
    who = shown.grasp.spec.who
    for status, word in zip((STICKING, SLIDING), contact_words((STICKING, SLIDING)), strict=True):
        if status in shown.statuses:
            yield "line", STATUS_COLOURS[status], f"{who} force, {word}"
    if SEPARATED in [shown.statuses[i] for i in shown.drawn_contacts]:
        yield "dot", STATUS_COLOURS[SEPARATED], f"{who} that lets go"
    if hidden:
        yield "ring", UNKNOWN_COLOUR, "contact seen through object or hand"
    if any(shown.cone_height(i) > 0.0 for i in range(scene.n)):
        sense = "moments take their part of it" if s.torsion is not None else "an arrow at its rim slides"
        text = f"friction cone, to the forces' scale:\n{sense}" if s.held else "friction cone"
        yield "cone", STATUS_COLOURS[STICKING if s.held else UNKNOWN], text
    if s.held and scene.frictional:
        yield "none", UNKNOWN_COLOUR, "labels: normal force + friction"
    if shown.moment_arcs:
        yield "turn", STATUS_COLOURS[STICKING], f"moment of a {who} about its normal, longer for larger"


def _motion_entries(shown: PictureContent, unseen: list[int], load_seen: bool) -> Iterator[LegendEntry]:
    """The load, and how the object moves."""
    s = shown.solution
    if shown.load_size > 0:
        much = words.format_force(shown.load_size)
        yield "line", LOAD_COLOUR, f"load on the object, {much}{'' if load_seen else ', too small to draw'}"
    if shown.torque_arc is not None:
        torque = words.format_torque(float(np.linalg.norm(shown.load_torque)))
        yield "turn", LOAD_COLOUR, f"torque on the object, {torque}"
    largest = max((float(np.hypot(*s.slip[i])) for i in shown.slip_arrows), default=0.0)
    if any(i not in unseen for i in shown.slip_arrows):
        factor = shown.slip_factor
        times = f"× {factor:g}" if factor >= 1 else f"÷ {1 / factor:g}"
        yield "line", SLIP_COLOUR, f"slip of the object, {times}\n(up to {words.format_length(largest)})"
    if unseen:
        most = max(float(np.hypot(*s.slip[i])) for i in unseen)
        below = f"at most {words.format_length(most)}" if most > words.NEGLIGIBLE_LENGTH else "zero"
        yield "none", SLIP_COLOUR, f"slip not drawn, {below}:\n{words.list_names([s.names[i] for i in unseen])}"
    if shown.moved_object is not None:
        yield "dashed-thin", MOVED_OBJECT_COLOUR, f"object after its motion:\n{describe_motion(s.object_displacement)}"
    if shown.escape_arrow.any():
        yield "dashed", ESCAPE_COLOUR, "the way the object escapes"
    if shown.escape_arc is not None:
        alone = not shown.escape_arrow.any()
        yield "turn", ESCAPE_COLOUR, "the way the object turns out" if alone else "and turns as it escapes"
