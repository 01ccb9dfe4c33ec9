"""What a page says in words, as HTML: every text is escaped."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from handlcp.grasp import Loading, Verdict
from handlcp.show.loading.report import motion

_CLASSES = {"HELD": "good", "REACHED": "good", "UNDECIDED": "doubt"}  # the rest is bad
_HEADS = {"warning": "Warning", "advice": "Advice"}


def verdict(v: Verdict) -> str:
    """The word, and its reasons."""
    return _said(v.word, ((_HEADS.get(r.severity, ""), r.severity, f"{r.sentence}.") for r in v.reasons))


def outcome(loading: Loading) -> str:
    """Whether the end is reached, and how far the object has moved; what happens on the way is beside the slider."""
    word = "REACHED" if loading.reached else "LOST"
    why = loading.why.removeprefix("reached ").removeprefix("lost ")
    return _said(word, (("", "decides", f"{why}."), ("", "note", f"{motion(loading)}.")))


def _said(word: str, lines: Iterable[tuple[str, str, str]]) -> str:
    """A word with lines of (head, severity, sentence)."""
    items = "".join(
        f'<li class="{escape(severity)}">{f"<b>{head}:</b> " if head else ""}{escape(_capital(text))}</li>'
        for head, severity, text in lines
    )
    return f'<p class="word {_CLASSES.get(word, "bad")}">{escape(word)}</p><ul class="reasons">{items}</ul>'


def _capital(text: str) -> str:
    """As a sentence begins, unless it begins with a name that is written otherwise."""
    first = text.split(" ", 1)[0]
    return text[:1].upper() + text[1:] if first.isalpha() else text
