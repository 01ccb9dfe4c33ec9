"""`handlcp envelope` from the outside."""

import json
from functools import partial

import numpy as np

import handlcp as hl
from handlcp import scene as scenes
from tests.support import command
from tests.support.command import CUBE

FEW = ("--directions", "12", "--adaptive", "0", "--faces", "8", "--fixed")
run = partial(command.run, "envelope")


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
