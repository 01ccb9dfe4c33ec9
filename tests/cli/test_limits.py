"""`handlcp limits` from the outside."""

import json
import pathlib

import numpy as np
import pytest
from typer.testing import CliRunner

from handlcp import scene as scenes
from handlcp.cli import app
from tests.support.messages import without_compiling

ROOT = pathlib.Path(__file__).parents[2]
CUBE = str(ROOT / "examples" / "cube_three_fingers.toml")
FAST = ("--fixed", "--faces", "8")


def run(*arguments, width="80"):
    words = ["limits", *(str(a) for a in arguments)]
    return CliRunner().invoke(app, words, env={"COLUMNS": width, "NO_COLOR": "1"})


def limit(load, **more):
    return scenes.load(CUBE).build().load_limit(load, geometry="fixed", faces=8, **more)


def test_six_directions_are_a_table_within_80_columns():
    done = run(CUBE, *FAST)
    assert done.exit_code == 0, done.output
    for way in ("+x", "-x", "+y", "-y", "+z", "-z"):
        assert f"force {way}" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert "Weakest: force -x, held up to 2.26 N" in done.stdout
    assert without_compiling(done.stderr) == ""


def test_json_has_the_limits_of_the_directions_that_are_asked_for():
    done = run(CUBE, *FAST, "--direction", "-z", "--direction", "1,1,0", "--json")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    down, aside = found["limits"]
    assert down["factor"] == pytest.approx(limit((0, 0, -1, 0, 0, 0)).factor, rel=1e-6)
    assert aside["load_asked_N_Nm"] == pytest.approx([0.5**0.5, 0.5**0.5, 0, 0, 0, 0])
    assert {b["kind"] for b in down["binds"]} == {"slips"}
    assert down["events"][0]["factor"] < down["factor"]
    assert {"bound", "some_equilibrium", "geometry", "why"} <= set(down)


def test_a_wrench_and_a_tolerance_of_motion_reach_the_limit():
    load = (0.0, 0.0, -1.0, 0.0, 0.0, 0.1)
    done = run(CUBE, *FAST, "--wrench", *load, "--motion", "2e-4", "--json")
    (one,) = json.loads(done.stdout)["limits"]
    assert one["factor"] == pytest.approx(limit(load, motion=2e-4).factor, rel=1e-6)
    assert one["binds"] == [{"kind": "motion", "who": "the object"}]
    np.testing.assert_allclose(one["load_held_N_Nm"], one["factor"] * np.array(load))


def test_what_does_not_hold_its_weight_holds_no_load_and_exits_1(tmp_path):
    file = tmp_path / "heavy.toml"
    file.write_text(pathlib.Path(CUBE).read_text(encoding="utf-8").replace("mass_kg = 0.2", "mass_kg = 3.0"))
    done = run(file, *FAST)
    assert done.exit_code == 1
    assert "NOT HELD" in done.stdout


@pytest.mark.parametrize("command", ["limits", "payload", "envelope"])
def test_a_motion_is_in_metres_and_millimetres_are_asked_about(command):
    help_ = " ".join(
        CliRunner().invoke(app, [command, "--help"], env={"COLUMNS": "200", "NO_COLOR": "1"}).stdout.split()
    )
    assert "may move the object, in m, such as 0.002" in help_
    done = CliRunner().invoke(app, [command, CUBE, "--motion", "2"])
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "--motion: expected m, less than the size of the grasp" in done.stderr
    assert "2 (millimetres? They are 0.002 m)" in done.stderr
