"""What is printed at 80 columns and into a pipe is what is printed with all the room in the world, word by word.

A word or a number that a column cuts or breaks is another word: the words at 80 columns then differ from those at 1000.
"""

from __future__ import annotations

import pathlib
import re
from collections import Counter

import pytest
import typer
from rich.console import Console
from typer.testing import CliRunner

import handlcp as hl
from handlcp import scene
from handlcp.cli import app
from handlcp.hand.library import urdf
from handlcp.studies.accuracy import accuracy_cost
from handlcp.studies.effect_catalogue import Cost, entries
from handlcp.viz import terminal_table as tables
from handlcp.viz.accuracy import all_tables
from tests.support import patches

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLES = ("cube_three_fingers", "box_on_table", "planar_ring")
CUBE = str(ROOT / "examples" / "cube_three_fingers.toml")
LISTS = [("keys",), ("effects",), ("hands",), ("audit", str(urdf("two_finger")))]


def words(text) -> Counter:
    """Every word and number, without the rules of tables."""
    return Counter(word for word in text.split() if not all("\u2500" <= letter <= "\u257f" for letter in word))


def printed(arguments, columns):
    done = CliRunner().invoke(app, list(arguments), env={"COLUMNS": columns, "NO_COLOR": "1"})
    assert done.exception is None or isinstance(done.exception, SystemExit)
    return done.stdout


def shown(things, width) -> str:
    console = Console(width=width, color_system=None)
    with console.capture() as said:
        for thing in things:
            console.print(thing)
    return said.get()


@pytest.mark.parametrize("arguments", LISTS, ids=lambda a: a[0])
def test_lists_break_no_word_at_80_columns_nor_in_a_pipe(arguments):
    roomy = printed(arguments, "1000")
    for columns in ("80", None):
        narrow = printed(arguments, columns)
        assert words(narrow) == words(roomy)
        assert max(map(len, narrow.splitlines())) <= 80


def test_a_long_name_is_not_cut(tmp_path):
    file = tmp_path / "hand.urdf"
    text = urdf("two_finger").read_text()
    file.write_text(text.replace("finger_1_proximal", "right_hand_middle_finger_metacarpal"))
    table = tables.hand_table({"a_hand": hl.Hand.from_urdf(file, ["finger_2_tip"], joint_stiffness=6.0)})
    assert "right_hand_middle_finger_metacarpal" in shown([table], 80)


def test_measured_effects_break_no_word():
    costs = {e.title: Cost(-12, 1.25) for e in entries()}
    table = tables.catalogue_table(entries(), costs)
    assert words(shown([table], 80)) == words(shown([table], 1000))


@pytest.mark.parametrize("name", EXAMPLES)
def test_solutions_break_no_word(name):
    file = str(ROOT / "examples" / f"{name}.toml")
    narrow, roomy = (printed(("solve", file), columns) for columns in ("80", "1000"))
    assert words(narrow) == words(roomy)


def test_a_loading_breaks_no_word():
    narrow, roomy = (printed(("follow", CUBE, "--steps", "4"), columns) for columns in ("80", "1000"))
    assert words(narrow) == words(roomy)


def test_accuracy_tables_break_no_word(monkeypatch):
    patches.ticks_of_studies(monkeypatch, 2e-3)
    found = all_tables(accuracy_cost(scene.load(CUBE).build(), seconds=0.3))
    assert words(shown(found, 80)) == words(shown(found, 1000))


def test_no_unit_in_a_help_text_is_taken_for_markup_and_left_out():
    """Rich takes [m] for a style, and prints nothing of it."""
    commands = typer.main.get_command(app).commands
    texts = {f"{name} {p.name}": getattr(p, "help", None) for name, one in commands.items() for p in one.params}
    assert len(texts) > 50
    assert [where for where, text in texts.items() if re.search(r"(?<!\\)\[[a-z#/@]", text or "")] == []
