"""What is printed at 80 columns and into a pipe is what is printed with all the room in the world, word by word.

A word or a number that a column cuts or breaks is another word: the words at 80 columns then differ from those at 1000.
"""

from __future__ import annotations

import re
from collections import Counter

import pytest
import typer
from typer.testing import CliRunner

from handlcp.cli import app
from tests.support.hand import urdf

LISTS = [("keys",), ("effects",), ("hands",), ("audit", str(urdf("two_finger")))]


def words(text) -> Counter:
    """Every word and number, without the rules of tables."""
    return Counter(word for word in text.split() if not all("\u2500" <= letter <= "\u257f" for letter in word))


def printed(arguments, columns):
    done = CliRunner().invoke(app, list(arguments), env={"COLUMNS": columns, "NO_COLOR": "1"})
    assert done.exception is None or isinstance(done.exception, SystemExit)
    return done.stdout


@pytest.mark.parametrize("arguments", LISTS, ids=lambda a: a[0])
def test_lists_break_no_word_at_80_columns_nor_in_a_pipe(arguments):
    roomy = printed(arguments, "1000")
    for columns in ("80", None):
        narrow = printed(arguments, columns)
        assert words(narrow) == words(roomy)
        assert max(map(len, narrow.splitlines())) <= 80


def test_no_unit_in_a_help_text_is_taken_for_markup_and_left_out():
    """Rich takes [m] for a style, and prints nothing of it."""
    commands = typer.main.get_command(app).commands
    texts = {f"{name} {p.name}": getattr(p, "help", None) for name, one in commands.items() for p in one.params}
    assert len(texts) > 50
    assert [where for where, text in texts.items() if re.search(r"(?<!\\)\[[a-z#/@]", text or "")] == []
