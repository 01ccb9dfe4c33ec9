"""`handlcp sweep` from the outside: hands from numbers and from files, names with a star, the table, exit status."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app
from tests.support.sweeps import BriefFrom, HandFrom

BRIEF = 'tries = 16\n[objects.ball]\nshape = "sphere"\nradius_m = 0.03\nmass_kg = 0.1\n'
STUDY = """
brief = "brief.toml"
samples = 2
out = "study.csv"

[hand]
fingers = 3
joint_stiffness = 4.0

[space]
palm_radius = { low = 0.04, high = 0.045 }
"*_distal.length" = [0.04, 0.02, -1.0]
"brief.friction" = 0.7
"""


def run(folder, text, *options):
    (folder / "brief.toml").write_text(BRIEF)
    (folder / "study.toml").write_text(text)
    arguments = ["sweep", str(folder / "study.toml"), "--serial", *options]
    return CliRunner().invoke(app, arguments, env={"COLUMNS": "80", "NO_COLOR": "1"})


def test_the_best_are_printed_and_the_table_is_written(tmp_path):
    done = run(tmp_path, STUDY, "--best", "1", "--json")
    assert done.exit_code == 0, done.output
    told, study = json.loads(done.stdout), hl.Study.load(tmp_path / "study.csv")
    assert told["best"] == list(study.best(1))
    assert len(study) == 2
    again = run(tmp_path, STUDY)
    assert again.stdout.splitlines()[0].startswith("2 designs")
    assert "study.csv" in again.stdout.replace("\n", "")  # a long path is broken


def test_nothing_that_could_be_evaluated_is_exit_status_1(tmp_path):
    done = run(tmp_path, STUDY.replace("[0.04, 0.02, -1.0]", "-1.0"))
    assert done.exit_code == 1
    assert "2 failed" in done.stdout


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("samples", "sample", "sample"), ('"brief.toml"', "3", "brief"), ("high = 0.045", "hi = 0.045", "palm_radius"),
        ('brief = "brief.toml"', 'brief = "other.toml"', "other.toml"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_exit_status_2(tmp_path, old, new, said):
    done = run(tmp_path, STUDY.replace(old, new))
    assert done.exit_code == 2
    assert said in done.stderr


def test_a_star_stands_for_all_joints_that_fit():
    hand = hl.finger_hand(3)
    lengths = hl.finger_hand(3, (0.05, 0.03)).at([0.1] * 6).tip_positions
    for make in (HandFrom(None, {"fingers": 3}), HandFrom(hand, {})):
        assert abs(make(**{"*_distal.length": 0.03, "brief.x": 1}).at([0.1] * 6).tip_positions - lengths).max() < 1e-12
    with pytest.raises(hl.UnknownName, match="distal"):
        HandFrom(hand, {})(**{"*_dital.length": 0.03})


def test_numbers_of_the_brief_are_parameters_too():
    asked = hl.Brief(hl.Sphere(0.03), friction=0.5)
    assert BriefFrom(asked)(**{"brief.friction": 0.9, "palm_radius": 0.04}).friction == 0.9
