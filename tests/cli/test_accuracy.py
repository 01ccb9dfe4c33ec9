"""`handlcp accuracy` and `compare` from the outside: what both say, in print and as JSON."""

import csv
import re
from functools import partial
from itertools import pairwise

import pytest

from handlcp.studies.accuracy import METHODS
from tests.support import command, patches
from tests.support.command import CUBE, changed, strict
from tests.support.messages import without_compiling
from tests.support.texts import says

run = partial(command.run, "accuracy")


def test_a_scene_prints_tables_and_one_sentence_and_exits_0(tmp_path, monkeypatch):
    patches.ticks_of_studies(monkeypatch, 2e-3)
    done = run(CUBE, "--seconds", "1", "--csv", tmp_path / "rows.csv", "--plot", tmp_path / "cost.png", status=0)
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
    done = run(CUBE, "--seconds", "0.5", "--json", status=0)
    found = strict(done.stdout)
    assert {r["method"] for r in found["rows"]} == set(METHODS)
    assert found["conditions"]["budget"] == 0.5
    assert "friction" in {e["effect"] for e in found["left_out"]}
    assert found["reference"]["residual"] < 1e-8


def test_a_scene_that_does_not_hold_exits_1_and_says_why(tmp_path):
    file = changed(tmp_path, ("friction = 0.8", "friction = 0.01"))
    done = run(file, "--seconds", "1", status=1)
    assert done.stdout == ""
    found = run(file, "--json", status=1)
    answer = strict(found.stdout)
    assert answer["status"] == "NOT_HOLDABLE"
    said = " ".join(done.stderr.split())
    assert answer["diagnosis"] in said
    says(said.replace(answer["diagnosis"], "…"), "Nothing")


# ---------------------------------------------------------------- beside MuJoCo
BESIDE_MUJOCO = """
title = "A cube"
[hand]
name = "three_finger"
joint_stiffness_Nm_per_rad = 6.0
[object]
shape = "box"
size_m = 0.05
position_m = [0.0, 0.0, 0.08]
mass_kg = 0.05
[grasp]
friction = 0.8
joint_offset_rad = { %s }
"""
JOINTS = [f"finger_{i}_{part}" for i in (1, 2, 3) for part in ("proximal", "distal")]


def compared(folder, offset, *words):
    pytest.importorskip("mujoco")
    file = folder / "cube.toml"
    file.write_text(BESIDE_MUJOCO % ", ".join(f"{joint} = {offset}" for joint in JOINTS), encoding="utf-8")
    return command.run("compare", file, "--seconds", "0.5", *words, width=None)


def test_a_comparison_prints_both_and_how_far_they_are_apart(tmp_path):
    ran = compared(tmp_path, 0.02)
    assert ran.exit_code == 0
    said = " ".join(ran.stdout.split())
    for words in ("A cube", "finger_1_tip", "finger_3_distal", "handlcp: HELD", "MuJoCo: HELD"):
        assert words in said
    forces = re.search(r"Difference: forces ([\d.e-]+) % of the largest force", said)
    assert forces is not None
    assert float(forces[1]) < 0.3
    assert re.search(r"Time: handlcp \S+ s, MuJoCo \S+ s", said)


def test_json_of_a_comparison_has_the_same_numbers(tmp_path):
    ran = compared(tmp_path, 0.02, "--json", "--together")
    found = strict(ran.stdout)
    assert found["both_hold"]
    assert found["agree"]
    assert found["force_error"] < 3e-3
    assert len(found["mujoco"]["forces_N"]) == len(found["handlcp"]["forces_N"]) == len(found["contacts"]) == 3
    assert found["handlcp"]["lost_at"] is None


def test_a_cube_that_drops_is_exit_status_1(tmp_path):
    ran = compared(tmp_path, 0.0)
    assert ran.exit_code == 1
    assert "handlcp: NOT HELD" in ran.stdout
    assert "MuJoCo: NOT HELD" in ran.stdout
