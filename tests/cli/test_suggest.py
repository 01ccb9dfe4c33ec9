"""`handlcp solve --suggest` says what is left out, in print and as JSON."""

import json
import pathlib

from typer.testing import CliRunner

from handlcp.cli import app
from tests.support.texts import same

SCENE = "examples/allegro_pinch.toml"


def run(*words):
    return CliRunner().invoke(app, ["solve", SCENE, *words])


def test_a_scene_that_fails_is_told_what_would_hold_it(tmp_path):
    file = tmp_path / "scene.toml"
    text = pathlib.Path("examples/cube_three_fingers.toml").read_text(encoding="utf-8")
    file.write_text(text.replace("squeeze_m = 0.005", ""), encoding="utf-8")
    done = CliRunner().invoke(app, ["solve", str(file), "--suggest"])
    assert done.exit_code == 1
    said = " ".join(done.stdout.partition("Suggestions:")[2].split())
    same("cli/test_suggest: what would hold it", said, "1.5 mm")
    assert done.stdout.count("1.5 mm") == 1, "it is told once"
    found = json.loads(CliRunner().invoke(app, ["solve", str(file), "--suggest", "--json"]).stdout)
    assert [s["effect"] for s in found["left_out"]["found"]] == ["squeeze"]
    assert found["left_out"]["word"] == "NOT HELD"
    assert found["cause"] == found["diagnosis"] != ""


def test_json_has_the_same():
    left_out = json.loads(run("--suggest", "--json").stdout)["left_out"]
    assert [s["effect"] for s in left_out["found"]] == ["finger weight"]
    assert left_out["least"] == 0.05
    assert json.loads(run("--json").stdout)["left_out"] is None
