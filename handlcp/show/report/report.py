"""The page of several hands beside each other: pictures of the same side and scale, numbers, and what differs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.design.brief import Brief
from handlcp.design.evaluate import evaluate
from handlcp.design.evaluation import Evaluation, ObjectCase
from handlcp.errors import InputError, as_path
from handlcp.hand import Hand
from handlcp.keywords import helped
from handlcp.progress import told
from handlcp.show.file import new_figure
from handlcp.show.page.written import image, web_files, write
from handlcp.show.picture.figure import alike
from handlcp.show.report.told import SCALES, asked, best_of, better, differences
from handlcp.write_file import check_destination

_GOOD, _DOUBT = "HELD", "UNDECIDED"
# Of each object: attribute of its case, its words, unit, and whether more is better
_OF_OBJECT = (
    ("payload", "payload", "kg", True),
    ("force", "largest force", "N", False),
    ("torque_used", "torque used", "%", False),
    ("motion", "moves", "mm", False),
)


@helped()
def report(hands: Any, brief: Brief, path: Any) -> Path:
    """Evaluate hands by a brief, and write one page (html) that shows them beside each other and needs no network.

    hands : a sequence of at least two, or a mapping of names to them. On the page: a picture of each grasp, those of an
    object from the same side and to the same scales; every number by object and load; the numbers, by their names for
    `vary`, in which the hands differ; and which hand is better at what.
    Raises InputError, also for a file that cannot be written; Unsupported without matplotlib.
    """
    named = _named(hands)
    if not isinstance(brief, Brief):
        raise InputError("brief", "a Brief", repr(brief)[:80])
    target = _page(path)
    new_figure()  # whether matplotlib is there
    found = dict[str, Evaluation]()
    with told("hands", len(named)) as done:
        for name, hand in named.items():
            found[name] = evaluate(hand, brief)
            done(1)
    frame, style = web_files("report.html", "report.css", package="handlcp.show.report")
    return write(target, frame, " beside ".join(named), style, _parts(named, brief, found))


def _named(hands: Any) -> dict[str, Hand]:
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


def _page(path: Any) -> Path:
    file = as_path("path", path, "the name of a file that ends in .html")
    if file.suffix.lower() not in (".html", ".htm"):
        raise InputError("path", "the name of a file that ends in .html", repr(str(path)))
    return check_destination("path", file)


def _parts(hands: Mapping[str, Hand], brief: Brief, found: Mapping[str, Evaluation]) -> dict[str, str]:
    """The parts of the report's page, as HTML."""
    differ = differences(hands)
    return {
        "verdicts": "".join(_in_all(name, done) for name, done in found.items()),
        "better": _items(better(found)),
        "asked": _items(asked(brief)),
        "pictures": _pictures(brief, found),
        "numbers": _table(("", *hands), _numbers(brief, found)),
        "differ": _table(("", *hands), [(row, [False] * len(row)) for row in differ]) if differ else "<p>Nothing.</p>",
    }


def _items(sentences: Iterable[str]) -> str:
    return "".join(f"<li>{escape(sentence)}.</li>" for sentence in sentences)


def _in_all(name: str, done: Evaluation) -> str:
    """One hand in a few words."""
    word = _chip("HELD" if done.holds else done.cases[done.worst_object].word)
    case = min(done.cases.values(), key=lambda one: one.payload)
    least = next(key for key, one in done.cases.items() if one is case)
    says = f"{case.mass} of {least}. First gives out: {_gives_out(done.gives_out)}."
    return f"<div><h2>{escape(name)}</h2>{word}<p>{escape(says)}</p></div>"


def _gives_out(what: str) -> str:
    """Without what follows a colon."""
    return what.partition(": ")[0] or "nothing up to what was asked"


def _chip(word: str) -> str:
    kind = {_GOOD: "good", _DOUBT: "doubt"}.get(word, "bad")
    return f'<span class="word {kind}">{escape(word)}</span>'


def _pictures(brief: Brief, found: Mapping[str, Evaluation]) -> str:
    """A row for each object, a picture in it for each hand."""
    rows = []
    for name in brief.objects:
        cases = [done.cases[name] for done in found.values()]
        drawn = alike([case.candidate for case in cases])
        cells = [_picture(hand, name, case, png) for hand, case, png in zip(found, cases, drawn, strict=True)]
        rows.append(f'<h3>{escape(name)}</h3><div class="beside">{"".join(cells)}</div>')
    return "".join(rows)


def _picture(hand: str, name: str, case: ObjectCase, png: bytes) -> str:
    drawn = image(png, f"{name} in {hand}") if png else '<p class="none">no grasp</p>'
    says = f"{hand}: first gives out: {_gives_out(case.gives_out)}"
    return f"<figure>{drawn}<figcaption>{_chip(case.word)} {escape(says)}</figcaption></figure>"


def _numbers(brief: Brief, found: Mapping[str, Evaluation]) -> list[tuple[Sequence[str], list[bool]]]:
    """Rows of cells, and which of the cells are the best of their row."""
    rows = list[tuple[Sequence[str], list[bool]]]()
    for name in brief.objects:
        cases = [done.cases[name] for done in found.values()]
        for load in cases[0].factors:
            factors = [case.factors[load] for case in cases]
            cells = [f"{case.times(load)} ×, {case.verdicts[load]}" for case in cases]
            rows.append(((f"{name}: {load}", *cells), [False, *best_of(factors, True)]))
        for attribute, what, unit, more in _OF_OBJECT:
            values = [SCALES.get(unit, 1.0) * getattr(case, attribute) for case in cases]
            cells = ["–" if np.isnan(value) else f"{value:.3g} {unit}" for value in values]
            if attribute == "payload":
                cells = [case.mass for case in cases]
            rows.append(((f"{name}: {what}", *cells), [False, *best_of(values, more)]))
    return rows


def _table(heads: Sequence[str], rows: Iterable[tuple[Sequence[str], list[bool]]]) -> str:
    """Cells that are best stand out."""
    lines = []
    for cells, best in rows:
        every = zip(cells, best, strict=True)
        lines.append("".join(f"<td{' class=best' if one else ''}>{escape(cell)}</td>" for cell, one in every))
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    top = "".join(f"<th>{escape(head)}</th>" for head in heads)
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'
