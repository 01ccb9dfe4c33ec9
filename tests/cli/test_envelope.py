"""`handlcp envelope` from the outside."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pytest
from typer.testing import CliRunner

import handlcp as hl
from handlcp import scene as scenes
from handlcp.cli import app
from handlcp.studies.envelope.question import EnvelopeQuestion

CUBE = str(pathlib.Path(__file__).parents[2] / "examples" / "cube_three_fingers.toml")
FEW = ("--directions", "12", "--adaptive", "0", "--faces", "8", "--fixed")


def run(*arguments):
    words = ["envelope", *(str(a) for a in arguments)]
    return CliRunner().invoke(app, words, env={"COLUMNS": "80", "NO_COLOR": "1"})


def test_it_prints_what_the_envelope_says_writes_pictures_and_a_page_and_exits_0(tmp_path):
    files = [tmp_path / name for name in ("a.png", "b.png", "c.html")]
    done = run(CUBE, *FEW, "--plot", files[0], "--polar", files[1], "--page", files[2])
    assert done.exit_code == 0, done.output
    env = hl.envelope(scenes.load(CUBE).build(), 12, adaptive=0, faces=8, geometry="fixed")
    assert str(env) in done.stdout
    assert max(len(line) for line in done.stdout.splitlines() if str(tmp_path) not in line) <= 80
    assert all(file.stat().st_size > 10_000 for file in files)


def test_json_is_the_record_of_the_envelope():
    done = run(CUBE, "--directions", "xz,8", "--adaptive", "0", "--faces", "8", "--of", "gravity", "--json")
    told = json.loads(done.stdout)
    env = hl.envelope(scenes.load(CUBE).build(), ("xz", 8), of="gravity", adaptive=0, faces=8)
    assert told["title"] == "A cube held by three fingers"
    np.testing.assert_allclose(told["mass_kg"], env.factors)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--directions", "yx"), "directions"),
        (("--directions", "xy,many"), "--directions"),
        (("--of", "weight"), "of: expected"),
        (("--plot", "picture.txt"), "plot"),
        (("--page", "page.txt"), "page"),
        (("--page", "page.html", "--directions", "xy"), "--page: expected directions all around"),
        (("--directions", "xy,2"), "directions"),
        (("--motion", "-1"), "motion"),
    ],
)
def test_bad_input_is_one_message_before_any_work_and_exit_status_2(arguments, says, monkeypatch):
    def asked(*_arguments, **_options):
        raise AssertionError("no direction is asked before the arguments are checked")

    monkeypatch.setattr(EnvelopeQuestion, "find_factors", asked)
    done = run(CUBE, *arguments)
    assert done.exit_code == 2
    assert says in done.stderr
    assert done.stdout == ""


def test_a_page_of_a_planar_scene_is_refused_before_any_work():
    done = run(pathlib.Path(CUBE).with_name("planar_ring.toml"), "--page", "page.html")
    assert done.exit_code == 2
    assert "--page: expected directions all around" in done.stderr
    assert "planar scene" in done.stderr
