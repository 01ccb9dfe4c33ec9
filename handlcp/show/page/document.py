"""The page: one HTML file that needs nothing else, and asks the network for nothing; what it says in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from handlcp.errors import InputError
from handlcp.geometry.object import Object
from handlcp.grasp import Grasp, GraspSolution, Loading, Verdict
from handlcp.hand.hand_grasp import make_grasp
from handlcp.keywords import helped
from handlcp.record import plain
from handlcp.show.file import checked_page, three_js
from handlcp.show.loading.report import motion
from handlcp.show.page.content import content, escape_of, path_of
from handlcp.show.page.frames import at_steps, of_solution
from handlcp.show.page.written import data_of, web_files, write
from handlcp.show.picture.content import Content

_SCRIPTS = ("solids.js", "marks.js", "labels.js", "view.js", "panel.js", "player.js", "page.js", "opened.js")
_DIGITS = 6


def save(
    grasp: Grasp,
    solution: GraspSolution,
    path: Any,
    obj: Any = None,
    title: str = "",
    verdict: Verdict | None = None,
    loading: Loading | None = None,
) -> Path:
    """Write the page of a solved grasp. obj : what to draw as the object where the grasp knows none.

    loading : of the same grasp, for the slider; None: the one that the verdict is about. verdict : of `check`; None:
    whether the loading holds the object, or without one what the solution says.

    Raises InputError for a file that cannot be written, or another grasp's loading; Unsupported without trimesh.
    """
    target = checked_page(path)
    if loading is None and verdict is not None:
        loading = verdict.loading
    if loading is not None and loading.steps.names != solution.names:
        raise InputError("loading", "one of the same grasp: grasp.follow()", f"contacts {loading.steps.names}")
    said = solution.verdict if verdict is None else verdict
    drawn = Content(grasp, solution, obj, verdict=said)
    told = _verdict(said) if verdict is not None or loading is None else _outcome(loading)
    shown, steps = [of_solution(grasp, solution, drawn.acts_at)], None
    if loading is not None:
        steps = path_of(loading, 1)
        shown += at_steps(loading, drawn.acts_at, getattr(grasp, "state", None))
    return document(target, title, told, content(drawn, shown, steps, escape_of(drawn)))


@helped()
def save_loading(
    loading: Loading, path: Any, title: str = "", obj: Object | None = None, verdict: Verdict | None = None
) -> Path:
    """Write the page of a loading alone, which begins at its last step.

    obj : as in `save`, where it stands at the start.
    verdict : of `check`; None: whether the loading holds the object.

    Raises as `save`.
    """
    target = checked_page(path)
    grasp = make_grasp(loading.steps.grasp.spec)
    drawn = Content(grasp, loading.solution, obj, verdict=verdict)
    shown = at_steps(loading, drawn.acts_at, getattr(grasp, "state", None))
    told = _outcome(loading) if verdict is None else _verdict(verdict)
    return document(target, title, told, content(drawn, shown, path_of(loading, 0), None))


class Own(NamedTuple):
    """Texts that one kind of page has for itself.

    stage : HTML of the side with the picture. tables : HTML beside the legend. style : CSS that comes after that of all
    pages. scripts : JavaScript, in order.
    """

    stage: str
    tables: str
    style: str
    scripts: Sequence[str]


def document(target: Path, title: str, said: str, found: Mapping[str, Any], own: Own | None = None) -> Path:
    """Write one HTML file that holds words, data and scripts of a page, and return it.

    target : the file, checked already. title : not yet HTML; "" for none. said : the verdict, as HTML.
    found : what the page's scripts read, with `notes` for the reader.
    own : texts of this kind of page; None: those of a grasp.

    Raises InputError for a file that cannot be written.
    """
    if own is None:
        stage, tables = web_files("stage.html", "tables.html")
        own = Own(stage, tables, "", web_files(*_SCRIPTS))
    parts = {
        "heading": f"<h1>{escape(title)}</h1>" if title else "",
        "stage": own.stage,
        "tables": own.tables,
        "verdict": said,
        "notes": "".join(f"<li>{escape(str(note))}</li>" for note in found["notes"]),
        "data": data_of(_short(plain(found))),
        "three": three_js(),
        "scripts": "\n".join(own.scripts),
    }
    return write(target, web_files("frame.html")[0], title or "A grasp", own.style, parts)


def _short(value: Any) -> Any:
    """The same data with six digits for each number."""
    if isinstance(value, dict):
        return {k: _short(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_short(v) for v in value]
    if isinstance(value, float):
        short = float(f"{value:.{_DIGITS}g}")
        return int(short) if abs(short) < 1e9 and short == int(short) else short
    return value


# ----------------------------------------------------------------
# What a page says in words, as HTML: every text is escaped.

_CLASSES = {"HELD": "good", "UNDECIDED": "doubt"}  # the rest is bad
_HEADS = {"warning": "Warning", "advice": "Advice"}


def _verdict(v: Verdict) -> str:
    """A verdict as HTML: its word and its reasons."""
    return _said(v.word, ((_HEADS.get(r.severity, ""), r.severity, f"{r.sentence}.") for r in v.reasons))


def _outcome(loading: Loading) -> str:
    """Whether the object is held, and how far it has moved; what happens on the way is beside the slider."""
    return _said(loading.word, (("", "decides", f"{loading.sentence}."), ("", "note", f"{motion(loading)}.")))


def _said(word: str, lines: Iterable[tuple[str, str, str]]) -> str:
    """A word and a list of sentences as HTML. lines : (head, severity, sentence) of each."""
    items = "".join(
        f'<li class="{escape(severity)}">{f"<b>{head}:</b> " if head else ""}{escape(_capital(text))}</li>'
        for head, severity, text in lines
    )
    return f'<p class="word {_CLASSES.get(word, "bad")}">{escape(word)}</p><ul class="reasons">{items}</ul>'


def _capital(text: str) -> str:
    """As a sentence begins, unless it begins with a name that is written otherwise."""
    first = text.split(" ", 1)[0]
    return text[:1].upper() + text[1:] if first.isalpha() else text
