"""`report`: a hand and its better ones, in the numbers that `vary` knows by name."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import check_call
from handlcp.contact.friction import as_law
from handlcp.design.brief import Brief
from handlcp.design.evaluate import evaluate
from handlcp.design.evaluation import Evaluation, format_held
from handlcp.errors import InputError
from handlcp.geometry import YCB, Box, Cylinder, Ellipsoid, Object, Sphere
from handlcp.hand import Hand
from handlcp.hand.vary.hand_shape import AXIS, LENGTH, POSITION
from handlcp.hand.vary.vary import hand_numbers, number_unit
from handlcp.progress import track_progress
from handlcp.viz.output_file import (
    check_report_path,
    new_figure,
    read_web_files,
    word_class,
    write_page,
)
from handlcp.viz.picture.figure import draw_comparable_pictures

_MISSING_CELL = "–"
_COMPARED_DIGITS = 9  # to which numbers are the same
ComparedValue = tuple[Any, str]  # what is compared, and how it is shown


def _hand_numbers(hand: Hand) -> Iterator[tuple[str, ComparedValue]]:
    """By name, such as "finger_1_distal.length"."""
    numbers, model = hand_numbers(hand), hand.model
    for name, value in numbers.items():
        yield name, (float(f"{value:.{_COMPARED_DIGITS}g}"), f"{value:.4g} {number_unit(name)}")
    data, q = pin.Data(model), pin.neutral(model)
    for joint in hand.kinematics.movable:
        k = model.getJointId(joint)
        place, parent = model.jointPlacements[k], model.names[model.parents[k]]
        size = float(np.linalg.norm(place.translation))
        led = f"{parent}.{LENGTH}" in numbers and size > 0.0  # its distance is the length of the joint before
        at = place.translation / size if led else place.translation
        yield f"{joint}.{POSITION}", (_round_values(at), f"{_format_vector(1e3 * place.translation)} mm")
        turn = np.degrees(pin.rpy.matrixToRpy(place.rotation))
        yield f"{joint}.roll, pitch, yaw", (_round_values(place.rotation.reshape(-1)), f"{_format_vector(turn)}°")
        axis = pin.computeJointJacobian(model, data, q, k)[:, model.joints[k].idx_v]
        yield f"{joint}.{AXIS}", (_round_values(axis), _format_vector(axis[3:] if axis[3:].any() else axis[:3]))
    for joint, low, high in zip(hand.joint_names, hand.lower.tolist(), hand.upper.tolist(), strict=True):
        yield f"{joint}.range", (_round_values(np.array([low, high])), f"{low:.4g} to {high:.4g}")


def _round_values(values: Any) -> tuple[float, ...]:
    return tuple((np.round(values, _COMPARED_DIGITS) + 0.0).tolist())


def _format_vector(values: Any) -> str:
    return f"({', '.join(f'{x:.4g}' for x in (np.round(values, 6) + 0.0).tolist())})"


# ----------------------------------------------------------------
# What a report of several hands says in words: what was asked, how the hands differ, which is better at what.


_SAME_VALUE_TOLERANCE = 0.01  # numbers that differ by a smaller share are alike

# What hands are compared by: attribute of an evaluation, what the better one does, unit, and whether more is better
_COMPARED_NUMBERS = (
    ("payload", "carries more", "kg", True),
    ("factor", "holds its loads more times", "×", True),
    ("force", "presses less hard", "N", False),
    ("torque_used", "uses less of its torque limits", "%", False),
    ("motion", "lets objects move less", "mm", False),
)
UNIT_SCALES = {"%": 100.0, "mm": 1e3}


def describe_brief(brief: Brief) -> list[str]:
    """The brief, a sentence for each thing."""
    objects = [f"{name}, {_describe_shape(obj)} of {obj.mass:g} kg" for name, obj in brief.objects.items()]
    ways = "in six directions" if brief.orientations == 6 else "in any direction"
    said = [f"Objects: {'; '.join(objects)}", f"Gravity pulls {ways}"]
    if brief.acceleration:
        said.append(f"The hand speeds up by {brief.acceleration:g} m/s²")
    for name, load in brief.loads.items():
        size = _format_with_unit(load[:3], "N")
        size += f" and {_format_with_unit(load[3:], 'N·m')}" if np.any(load[3:]) else ""
        said.append(f"Load “{name}”: {size} beside the weight, the hand upright")
    law = as_law(brief.friction)
    said.append(f"Friction: {f'coefficient {law.mu:g}' if type(law).__name__ == 'Coulomb' else repr(law)}")
    said.append(f"The weight, and each load, is to be held {brief.safety:g} times")
    if brief.motion is not None:
        said.append(f"An object may move {words.format_length(brief.motion)} under it")
    if brief.most_force is not None:
        said.append(f"An object bears {words.format_force(brief.most_force)} at a contact")
    kinds = {"pinch": "fingertips alone", "power": "the whole hand", "any": "fingertips or the whole hand"}
    return [*said, f"Held by {kinds[brief.kind]}"]


def _describe_shape(obj: Object) -> str:
    """With its sizes in millimetres."""
    match obj:
        case Sphere():
            return f"a ball {2e3 * obj.radius:g} mm across"
        case Box():
            return f"a box of {' × '.join(f'{1e3 * x:g}' for x in obj.size)} mm"
        case Cylinder():
            return f"a cylinder {2e3 * obj.radius:g} mm across and {1e3 * obj.length:g} mm long"
        case Ellipsoid():
            return f"an ellipsoid of {' × '.join(f'{2e3 * x:g}' for x in obj.radii)} mm"
        case YCB():
            return f"the YCB object {obj.name}"
    return "a mesh"


def _format_with_unit(vector: Any, unit: str) -> str:
    return f"({', '.join(f'{x:g}' for x in vector)}) {unit}"


def compare_hands(hands: Mapping[str, Hand]) -> list[tuple[str, ...]]:
    """What differs in all: joints, fingertips, mass, size; then a row for each number, by its name for `vary`, in which
    hands differ, and for how joints stand and turn, with its value in each hand; names with the same values share one.
    """
    described = [hand.describe() for hand in hands.values()]
    more = [
        ("joints", *[str(len(d.joints)) for d in described]),
        ("fingertips", *[str(sum(tip.taken for tip in d.fingertips)) for d in described]),
        ("mass", *[f"{d.mass:.3g} kg" for d in described]),
        ("size", *[" × ".join(f"{1e3 * x:.0f}" for x in d.size) + " mm" for d in described]),
    ]
    facts, alike = [dict(_hand_numbers(hand)) for hand in hands.values()], dict[tuple[str, ...], list[str]]()
    for name in dict.fromkeys(name for found in facts for name in found):
        values = [found.get(name) for found in facts]
        if len({None if value is None else value[0] for value in values}) > 1:
            of, _, what = name.rpartition(".")
            cells = tuple([_MISSING_CELL if value is None else value[1] for value in values])
            alike.setdefault((what, *cells), []).append(of)
    rows = [(f"{what.replace('_', ' ')} of {words.list_names(of)}", *cells) for (what, *cells), of in alike.items()]
    return [*[row for row in more if len(set(row[1:])) > 1], *rows]


def describe_better_hands(found: Mapping[str, Evaluation]) -> list[str]:
    """Which hand is better at what, a sentence for each number; the others beside it. Forces, torques and motion are
    those of the same loads only where these are held: a hand that drops them sooner is not better.
    """
    said, names, holds = list[str](), list(found), [done.holds for done in found.values()]
    for attribute, what, unit, more in _COMPARED_NUMBERS:
        values = [UNIT_SCALES.get(unit, 1.0) * float(getattr(done, attribute)) for done in found.values()]
        known = [k for k, value in enumerate(values) if not np.isnan(value) and (more or holds[k])]
        if len(known) < (1 if more else 2):
            continue
        best = (max if more else min)(known, key=lambda k: values[k])
        least = [more and not done.gives_out for done in found.values()]
        cells = [f"{names[k]} {format_held(values[k], least[k])} {unit}".rstrip() for k in known]
        apart = max(abs(values[k] - values[best]) for k in known)
        if len(known) > 1 and not apart > _SAME_VALUE_TOLERANCE * abs(values[best]):
            said.append(f"None {what}: {words.list_names(cells)}")
        else:
            said.append(f"{names[best]} {what}: {words.list_names(cells)}")
    return said


def mark_best(values: Sequence[float], more: bool) -> list[bool]:
    """Which of these numbers are the best, where they are not all alike; NaN is none."""
    known = [v for v in values if not np.isnan(v)]
    if len(known) < 2 or not max(known) - min(known) > _SAME_VALUE_TOLERANCE * max(map(abs, known)):
        return [False] * len(values)
    best = max(known) if more else min(known)
    return [v == best for v in values]


# ----------------------------------------------------------------
# The page of several hands beside each other: pictures of the same side and scale, numbers, and what differs.


# Of each object: attribute of its case, its words, unit, and whether more is better
_OBJECT_NUMBERS = (
    ("payload", "payload", "kg", True),
    ("force", "largest force", "N", False),
    ("torque_used", "torque used", "%", False),
    ("motion", "moves", "mm", False),
)


@check_call()
def report(hands: Any, brief: Brief, path: Any) -> Path:
    """Evaluate hands by a brief, and write one page (html) that shows them beside each other and needs no network.

    hands : a sequence of at least two, or a mapping of names to them. On the page: a picture of each grasp, those of an
    object from the same side and to the same scales; every number by object and load; the numbers, by their names for
    `vary`, in which the hands differ; and which hand is better at what.
    Raises InputError, also for a file that cannot be written; Unsupported without matplotlib.
    """
    named = _name_hands(hands)
    if not isinstance(brief, Brief):
        raise InputError("brief", "a Brief", repr(brief)[:80])
    target = check_report_path(path)
    new_figure()  # whether matplotlib is there
    found = dict[str, Evaluation]()
    with track_progress("hands", len(named)) as done:
        for name, hand in named.items():
            found[name] = evaluate(hand, brief)
            done(1)
    frame, style = read_web_files("report.html", "report.css", package="handlcp.viz.report")
    heads, differ = ("", *named), [(row, [False] * len(row)) for row in compare_hands(named)]
    parts = {
        "verdicts": "".join(_hand_summary_html(name, done) for name, done in found.items()),
        "better": _list_items_html(describe_better_hands(found)),
        "asked": _list_items_html(describe_brief(brief)),
        "pictures": _pictures_html(brief, found),
        "numbers": _table_html(heads, _number_rows(brief, found)),
        "differ": _table_html(heads, differ) if differ else "<p>Nothing.</p>",
    }
    return write_page(target, frame, " beside ".join(named), style, parts)


def _name_hands(hands: Any) -> dict[str, Hand]:
    """The hands of a report by their names, checked. Raises InputError."""
    expected = "at least two hands, or a mapping of names to them"
    if isinstance(hands, Mapping):
        named = {str(name): hand for name, hand in hands.items()}
    elif isinstance(hands, Sequence) and not isinstance(hands, str):
        named = {f"hand {k}": hand for k, hand in enumerate(hands, 1)}
    else:
        raise InputError("hands", expected, repr(hands)[:80])
    if len(named) < 2:
        raise InputError("hands", expected, f"{len(named)}")
    for key, hand in zip(hands if isinstance(hands, Mapping) else range(len(named)), named.values(), strict=True):
        if not isinstance(hand, Hand):
            raise InputError(f"hands[{key!r}]", "a Hand", repr(hand)[:80])
    return named


def _list_items_html(sentences: Iterable[str]) -> str:
    return "".join(f"<li>{escape(sentence)}.</li>" for sentence in sentences)


def _hand_summary_html(name: str, done: Evaluation) -> str:
    """One hand in a few words."""
    word = _word_html("HELD" if done.holds else done.cases[done.worst_object].word)
    case = min(done.cases.values(), key=lambda one: one.payload)
    least = next(key for key, one in done.cases.items() if one is case)
    says = f"{case.mass} of {least}. First gives out: {_format_cause(done.gives_out)}."
    return f"<div><h2>{escape(name)}</h2>{word}<p>{escape(says)}</p></div>"


def _format_cause(what: str) -> str:
    """Without what follows a colon."""
    return what.partition(": ")[0] or "nothing up to what was asked"


def _word_html(word: str) -> str:
    return f'<span class="word {word_class(word)}">{escape(word)}</span>'


def _pictures_html(brief: Brief, found: Mapping[str, Evaluation]) -> str:
    """A row for each object, a picture in it for each hand."""
    rows = []
    for name in brief.objects:
        cases = [done.cases[name] for done in found.values()]
        drawn = draw_comparable_pictures([case.candidate for case in cases])
        cells = ""
        for hand, case, png in zip(found, cases, drawn, strict=True):
            code, alt = base64.b64encode(png).decode("ascii"), escape(f"{name} in {hand}")
            picture = f'<img alt="{alt}" src="data:image/png;base64,{code}">' if png else '<p class="none">no grasp</p>'
            says = escape(f"{hand}: first gives out: {_format_cause(case.gives_out)}")
            cells += f"<figure>{picture}<figcaption>{_word_html(case.word)} {says}</figcaption></figure>"
        rows.append(f'<h3>{escape(name)}</h3><div class="beside">{cells}</div>')
    return "".join(rows)


def _number_rows(brief: Brief, found: Mapping[str, Evaluation]) -> list[tuple[Sequence[str], list[bool]]]:
    """Rows of cells, and which of the cells are the best of their row."""
    rows = list[tuple[Sequence[str], list[bool]]]()
    for name in brief.objects:
        cases = [done.cases[name] for done in found.values()]
        for load in cases[0].factors:
            factors = [case.factors[load] for case in cases]
            cells = [f"{case.times(load)} ×, {case.verdicts[load]}" for case in cases]
            rows.append(((f"{name}: {load}", *cells), [False, *mark_best(factors, True)]))
        for attribute, what, unit, more in _OBJECT_NUMBERS:
            values = [UNIT_SCALES.get(unit, 1.0) * getattr(case, attribute) for case in cases]
            cells = ["–" if np.isnan(value) else f"{value:.3g} {unit}" for value in values]
            if attribute == "payload":
                cells = [case.mass for case in cases]
            rows.append(((f"{name}: {what}", *cells), [False, *mark_best(values, more)]))
    return rows


def _table_html(heads: Sequence[str], rows: Iterable[tuple[Sequence[str], list[bool]]]) -> str:
    """Cells that are best stand out."""
    lines = []
    for cells, best in rows:
        every = zip(cells, best, strict=True)
        lines.append("".join(f"<td{' class=best' if one else ''}>{escape(cell)}</td>" for cell, one in every))
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    top = "".join(f"<th>{escape(head)}</th>" for head in heads)
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'
