"""The sentences that a user sees most, word for word, in one file; of all others tests assert facts, by `says`.

    same("grasp/test_diagnosis: a screw", text, "(0, 0, -1)")

compares a text with `tests/texts/sentences.toml`, where it stands under the part of the key before the colon; what
follows are facts that it has to hold whatever its wording: names, numbers, codes. Whoever rewords a sentence writes the
file anew and looks at what changed in it:

    HANDLCP_WRITE_TEXTS=1 python -m pytest && git diff tests/texts

Numbers that depend on the machine have no place in a text: a test takes them out before (`without_numbers`).
"""

from __future__ import annotations

import json
import os
import pathlib
import re
import tempfile
import tomllib

FILE = pathlib.Path(__file__).parents[1] / "texts" / "sentences.toml"
WRITE = "HANDLCP_WRITE_TEXTS"
_HEAD = f"# The package's sentences, word for word. Tests with {WRITE}=1 write this file: tests/support/texts.py\n"
_written: dict[str, str] = {}  # in this process
_NUMBER = re.compile(r"(?<![\w.])[+-]?\d+(?:[.,]\d+)*(?:e[+-]?\d+)?")


def same(key, text, *facts):
    """The text holds these facts, and is the one in the file, or becomes it when the file is being written."""
    says(text, *facts)
    where, what = key.split(": ", 1)
    if os.environ.get(WRITE) == "1":
        assert _written.setdefault(key, text) == text, f"{key!r} is the key of two texts"
        _write(where, what, text)
        return
    known = stored().get(where, {})
    assert what in known, f"{key!r} is not in {FILE.name} yet: run this test with {WRITE}=1"
    assert text == known[what], f"{key!r}: reworded? With {WRITE}=1 the file is written anew"


def says(text, *facts):
    """The text holds these facts, whatever its wording: names, numbers, codes."""
    for fact in facts:
        assert fact in text, f"no {fact!r} in {text!r}"


def without_numbers(text):
    """With # for every number, and single blanks."""
    return _NUMBER.sub("#", " ".join(text.split()))


def stored():
    """All texts: file of the test → what it is → the text."""
    return tomllib.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}


def _write(where, what, text):
    """One at a time: the workers of a parallel run write the same file."""
    import fcntl

    FILE.parent.mkdir(exist_ok=True)
    with open(pathlib.Path(tempfile.gettempdir()) / "handlcp_sentences.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        every = stored()
        every.setdefault(where, {})[what] = text
        lines = [_HEAD]
        for table in sorted(every):
            lines.append(f"\n[{_quoted(table)}]\n")
            lines += [f"{_quoted(k)} = {_quoted(every[table][k])}\n" for k in sorted(every[table])]
        new = FILE.with_suffix(".new")
        new.write_text("".join(lines), encoding="utf-8")
        new.replace(FILE)  # at once: another worker may be reading


def _quoted(text):
    """As a TOML basic string, which JSON's strings are, too; texts of several lines as they are read."""
    if "\n" not in text:
        return json.dumps(text, ensure_ascii=False)
    lines = [json.dumps(line, ensure_ascii=False)[1:-1] for line in text.split("\n")]
    return '"""\n' + "\n".join(lines) + '"""'
