"""`handlcp limits`, `envelope` and `payload` from the outside."""

import json
from functools import partial

import numpy as np
import pytest

import handlcp as hl
from handlcp import scene as scenes
from tests.support import command
from tests.support.command import CUBE, changed
from tests.support.messages import without_compiling

RING = CUBE.replace("cube_three_fingers", "planar_ring")
FAST = ("--fixed", "--faces", "8")
FEW = ("--directions", "12", "--adaptive", "0", *FAST)
run, envelope, payload = (partial(command.run, name) for name in ("limits", "envelope", "payload"))


def limit(load, **more):
    return scenes.load(CUBE).build().load_limit(load, geometry="fixed", faces=8, **more)


def test_six_directions_are_a_table_within_80_columns():
    done = run(CUBE, *FAST, status=0)
    for way in ("+x", "-x", "+y", "-y", "+z", "-z"):
        assert f"force {way}" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert "Weakest: force -x, held up to 1.51 N" in done.stdout
    assert "lost at 2.26 N" in done.stdout
    assert without_compiling(done.stderr) == ""


def test_a_planar_scene_is_loaded_in_its_plane_alone():
    done = run(RING, "--fixed", "--json", status=0)
    found = {tuple(one["load_asked_N_Nm"]): one["factor"] for one in json.loads(done.stdout)["limits"]}
    assert set(found) == {(x, y, 0, 0, 0, 0) for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1))}
    ring = scenes.load(RING).build()
    assert found[1, 0, 0, 0, 0, 0] == pytest.approx(ring.load_limit((1, 0, 0), geometry="fixed").factor, rel=1e-6)


def test_json_has_the_limits_of_the_directions_that_are_asked_for():
    done = run(CUBE, *FAST, "--direction", "-z", "--direction", "1,1,0", "--json", status=0)
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
    done = run(changed(tmp_path, ("mass_kg = 0.2", "mass_kg = 3.0")), *FAST, status=1)
    assert "NOT HELD" in done.stdout


@pytest.mark.parametrize("name", ["limits", "payload", "envelope"])
def test_a_motion_is_in_metres_and_millimetres_are_asked_about(name):
    help_ = " ".join(command.run(name, "--help", width="200").stdout.split())
    assert "may move the object, in m, such as 0.002" in help_
    done = command.run(name, CUBE, "--motion", "2", width=None)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "--motion: expected m, less than the size of the grasp" in done.stderr
    assert "2 (millimetres? They are 0.002 m)" in done.stderr


# ---------------------------------------------------------------- the envelope
def test_it_prints_what_the_envelope_says_writes_pictures_and_a_page_and_exits_0(tmp_path):
    files = [tmp_path / name for name in ("a.png", "b.png", "c.html")]
    done = envelope(CUBE, *FEW, "--plot", files[0], "--polar", files[1], "--page", files[2], status=0)
    env = hl.envelope(scenes.load(CUBE).build(), 12, adaptive=0, faces=8, geometry="fixed")
    assert str(env) in done.stdout
    assert max(len(line) for line in done.stdout.splitlines() if str(tmp_path) not in line) <= 80
    assert all(file.stat().st_size > 10_000 for file in files)


def test_json_is_the_record_of_the_envelope():
    done = envelope(CUBE, "--directions", "xz,8", "--adaptive", "0", "--faces", "8", "--of", "gravity", "--json")
    told = json.loads(done.stdout)
    env = hl.envelope(scenes.load(CUBE).build(), ("xz", 8), of="gravity", adaptive=0, faces=8)
    assert told["title"] == "A cube held by three fingers"
    np.testing.assert_allclose(told["mass_kg"], env.factors)


# ---------------------------------------------------------------- the payload
@pytest.mark.parametrize(("arguments", "asked"), [((), (6, 0.0)), (("--any", "--acceleration", 2.0), ("any", 2.0))])
def test_what_is_asked_for_reaches_the_question_of_the_payload(arguments, asked, tmp_path):
    picture = tmp_path / "payload.png"
    found = scenes.load(CUBE).build().payload(*asked, geometry="fixed", faces=8)
    done = payload(CUBE, *FAST, *arguments, "--plot", picture, status=0)
    assert str(found) in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert picture.stat().st_size > 10_000
    told = json.loads(payload(CUBE, *FAST, *arguments, "--json").stdout)
    assert told["mass_kg"] == found.mass
    assert len(told["by_orientation"]) == len(found.by_orientation)
