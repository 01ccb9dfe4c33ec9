"""`handlcp payload` from the outside."""

import json
from functools import partial

import pytest

from handlcp import scene as scenes
from tests.support import command
from tests.support.command import CUBE

FAST = ("--fixed", "--faces", "8")
run = partial(command.run, "payload")


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
