"""`handlcp payload` from the outside."""

import json
import pathlib

import pytest
from typer.testing import CliRunner

from handlcp import scene as scenes
from handlcp.cli import app

CUBE = str(pathlib.Path(__file__).parents[2] / "examples" / "cube_three_fingers.toml")
FAST = ("--fixed", "--faces", "8")


def run(*arguments):
    return CliRunner().invoke(app, ["payload", *map(str, arguments)], env={"COLUMNS": "80", "NO_COLOR": "1"})


@pytest.mark.parametrize(("arguments", "asked"), [((), (6, 0.0)), (("--any", "--acceleration", 2.0), ("any", 2.0))])
def test_what_is_asked_for_reaches_the_question(arguments, asked, tmp_path):
    picture = tmp_path / "payload.png"
    found = scenes.load(CUBE).build().payload(*asked, geometry="fixed", faces=8)
    done = run(CUBE, *FAST, *arguments, "--plot", picture)
    assert done.exit_code == 0, done.output
    assert str(found) in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert picture.stat().st_size > 10_000
    told = json.loads(run(CUBE, *FAST, *arguments, "--json").stdout)
    assert told["mass_kg"] == found.mass
    assert len(told["by_orientation"]) == len(found.by_orientation)
