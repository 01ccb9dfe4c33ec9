"""`handlcp solve --suggest` says what is left out, in print and as JSON."""

from __future__ import annotations

import json

from typer.testing import CliRunner

from handlcp.cli import app
from tests.support.texts import same

SCENE = "examples/allegro_pinch.toml"


def run(*words):
    return CliRunner().invoke(app, ["solve", SCENE, *words])


def test_it_prints_what_matters_and_what_does_not():
    plain, said = run().stdout, run("--suggest").stdout
    assert said.startswith(plain)
    same("cli/test_suggest: what is left out", " ".join(said.removeprefix(plain).split()), "finger weight", "joint_5.0")


def test_json_has_the_same():
    left_out = json.loads(run("--suggest", "--json").stdout)["left_out"]
    assert [s["effect"] for s in left_out["found"]] == ["finger weight"]
    assert left_out["least"] == 0.05
    assert json.loads(run("--json").stdout)["left_out"] is None
