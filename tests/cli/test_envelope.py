"""`handlcp envelope` from the outside."""

import json
import pathlib

import numpy as np
from typer.testing import CliRunner

import handlcp as hl
from handlcp import scene as scenes
from handlcp.cli import app

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
