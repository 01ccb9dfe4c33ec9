"""The file of sentences holds what tests compare with it and nothing else, and comes back as it was written."""

from __future__ import annotations

import ast
import os
import pathlib
import re
from functools import cache

import pytest

from tests.support import texts

TESTS = pathlib.Path(__file__).parent


def keys_in(file: pathlib.Path) -> list[str]:
    """A pattern for each key that this file hands to `same`, with .* for what a parameter of the test fills in."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    named = {
        node.targets[0].id: node.value.value
        for node in tree.body
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and isinstance(node.value, ast.Constant)
    }
    calls = [n for n in ast.walk(tree) if isinstance(n, ast.Call) and ast.unparse(n.func) in ("same", "texts.same")]
    found = []
    for part in (call.args[0] for call in calls if call.args):
        if isinstance(part, ast.Constant):
            found.append(re.escape(part.value))
        elif isinstance(part, ast.JoinedStr):
            found.append("".join(pattern(piece, named) for piece in part.values))
    return found


def pattern(piece: ast.expr, named: dict[str, object]) -> str:
    """What may stand for one piece of an f-string."""
    if isinstance(piece, ast.Constant):
        return re.escape(piece.value)
    name = ast.unparse(piece.value)
    return re.escape(named[name]) if name in named else ".*"


@cache
def asked() -> dict[pathlib.Path, list[str]]:
    """The patterns of each file of tests."""
    return {file: keys_in(file) for file in TESTS.rglob("test_*.py") if file.name != "test_texts.py"}


@pytest.mark.skipif(texts.WRITE in os.environ, reason="the file is being written")
def test_no_sentence_is_left_behind_by_a_test_that_is_gone():
    known = re.compile("|".join(key for keys in asked().values() for key in keys))
    kept = [f"{where}: {what}" for where, sentences in texts.stored().items() for what in sentences]
    assert len(kept) <= 30
    assert [key for key in kept if not known.fullmatch(key)] == []


def test_a_key_says_in_which_file_its_test_is():
    for file, keys in asked().items():
        for key in keys:
            where = re.escape(file.relative_to(TESTS).with_suffix("").as_posix() + ": ")
            assert key.startswith(where), f"{key} in {file.name}"


def test_what_is_written_is_what_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(texts, "FILE", tmp_path / "new" / "sentences.toml")
    said = {
        "a: one": "μ ≤ 0.5 \"so\" \\ it 'is'",
        "a: two, of lines": "\nfirst\n  second\n",
        "b: three": "",
        "b: one": "x",
    }
    monkeypatch.setenv(texts.WRITE, "1")
    for key, text in said.items():
        texts.same(key, text)
    monkeypatch.delenv(texts.WRITE)
    for key, text in said.items():
        texts.same(key, text)
    with pytest.raises(AssertionError, match="reworded"):
        texts.same("a: one", "another")
    with pytest.raises(AssertionError, match=r"not in sentences\.toml yet"):
        texts.same("b: four", "x")


def test_facts_are_asked_for_while_the_file_is_written_too(tmp_path, monkeypatch):
    monkeypatch.setattr(texts, "FILE", tmp_path / "sentences.toml")
    monkeypatch.setenv(texts.WRITE, "1")
    with pytest.raises(AssertionError, match="finger_2"):
        texts.same("a: one", "finger 1 slides", "finger_2")
    assert texts.stored() == {}


def test_numbers_are_taken_out_whole_and_names_keep_theirs():
    assert texts.without_numbers("finger_2 slides  1.2e-03 mm,\n-4 N of 5 %") == "finger_2 slides # mm, # N of # %"
