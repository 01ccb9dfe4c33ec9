"""`handlcp reliability` from the outside."""

import json
import pathlib

from typer.testing import CliRunner

from handlcp.cli import app
from handlcp.grasp import parameters
from tests.support.messages import without_compiling

ROOT = pathlib.Path(__file__).parents[2]
CUBE = str(ROOT / "examples" / "cube_three_fingers.toml")


def run(*arguments):
    words = [str(a) for a in ("reliability", *arguments)]
    return CliRunner().invoke(app, words, env={"COLUMNS": "80", "NO_COLOR": "1"})


def test_a_scene_prints_its_chances_the_worst_sample_and_what_matters(tmp_path):
    done = run(CUBE, "--friction", "0.3", "--mass", "0.1", "--samples", "64", "--plot", tmp_path / "sure.png")
    assert done.exit_code == 0, done.output
    for word in ("holds, and within torque limits: ", "64 samples", "worst: sample", "friction", "mass"):
        assert word in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80 + len(str(tmp_path))
    assert without_compiling(done.stderr) == "", "no bar without a terminal"
    assert (tmp_path / "sure.png").stat().st_size > 20_000


def test_json_is_one_object_and_a_run_that_is_kept_is_not_repeated(tmp_path):
    file = tmp_path / "run.npz"
    both = [run(CUBE, "--friction", "0.3", "--samples", "64", "--resume", file, "--json") for _ in range(2)]
    one, two = (json.loads(done.stdout) for done in both)
    assert one == two
    assert one["samples"] == 64
    assert sum(one["counts"].values()) == 64
    assert one["chance_held"]["low"] <= one["chance_held"]["value"] <= one["chance_held"]["high"]
    assert file.exists()
    other = run(CUBE, "--friction", "0.2", "--samples", "64", "--resume", file)
    assert other.exit_code == 2
    assert "another spread" in " ".join(other.stderr.split())


def test_there_is_an_option_for_each_parameter_that_varies_and_it_says_what_a_number_is():
    text = " ".join(run("--help").stdout.replace("│", " ").split())
    options = [f"--{p.spread} <float> {p.uncertain}" for p in parameters() if p.spread]
    assert len(options) == 8
    assert [o for o in options if o not in text] == []
