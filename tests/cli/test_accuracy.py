"""`handlcp accuracy` from the outside."""

import csv
from functools import partial
from itertools import pairwise

from handlcp.studies.accuracy import METHODS
from tests.support import command, patches
from tests.support.command import CUBE, changed, strict
from tests.support.messages import without_compiling
from tests.support.texts import says

run = partial(command.run, "accuracy")


def test_a_scene_prints_tables_and_one_sentence_and_exits_0(tmp_path, monkeypatch):
    patches.ticks_of_studies(monkeypatch, 2e-3)
    done = run(CUBE, "--seconds", "1", "--csv", tmp_path / "rows.csv", "--plot", tmp_path / "cost.png")
    assert done.exit_code == 0, done.output
    titles = [a for a, b in pairwise(done.stdout.splitlines()) if a[:1].strip() and not b.strip()]
    says("; ".join(line.strip() for line in titles), "friction")
    assert {m for m in METHODS if m not in done.stdout} == set()
    assert max(map(len, done.stdout.splitlines())) <= 80 + len(str(tmp_path))
    assert without_compiling(done.stderr) == "", "no bar without a terminal"
    with (tmp_path / "rows.csv").open(newline="", encoding="utf-8") as file:
        assert {line["method"] for line in csv.DictReader(file)} == set(METHODS)
    assert (tmp_path / "cost.png").stat().st_size > 50_000


def test_json_is_one_object_and_nothing_else(monkeypatch):
    patches.ticks_of_studies(monkeypatch, 2e-3)
    done = run(CUBE, "--seconds", "0.5", "--json")
    assert done.exit_code == 0, done.output
    found = strict(done.stdout)
    assert {r["method"] for r in found["rows"]} == set(METHODS)
    assert found["conditions"]["budget"] == 0.5
    assert "friction" in {e["effect"] for e in found["left_out"]}
    assert found["reference"]["residual"] < 1e-8


def test_a_scene_that_does_not_hold_exits_1_and_says_why(tmp_path):
    file = changed(tmp_path, ("friction = 0.8", "friction = 0.01"))
    done = run(file, "--seconds", "1")
    assert done.exit_code == 1
    assert done.stdout == ""
    found = run(file, "--json")
    assert found.exit_code == 1
    answer = strict(found.stdout)
    assert answer["status"] == "NOT_HOLDABLE"
    said = " ".join(done.stderr.split())
    assert answer["diagnosis"] in said
    says(said.replace(answer["diagnosis"], "…"), "Nothing")
