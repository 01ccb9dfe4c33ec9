"""`handlcp reliability` from the outside."""

import json
from functools import partial

from handlcp.grasp import parameters
from tests.support import command
from tests.support.command import CUBE
from tests.support.messages import without_compiling

run = partial(command.run, "reliability")


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
