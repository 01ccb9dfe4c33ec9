"""`handlcp demo` from the outside: what a stranger sees first."""

import pathlib
import sys
from functools import partial

from tests.support import command
from tests.support.command import CUBE

run = partial(command.run, "demo")


def test_it_shows_a_verdict_a_picture_a_page_and_leaves_the_scene_to_go_on_from(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run(status=0)
    assert "HELD: the joint closest to its limit is finger_2_proximal at 38 %" in done.stdout
    left = {file.name: file for file in (tmp_path / "handlcp_demo").iterdir()}
    assert set(left) == {"cube.toml", "cube.png", "cube.html"}
    assert left["cube.toml"].read_bytes() == pathlib.Path(CUBE).read_bytes()
    assert left["cube.png"].read_bytes()[:4] == b"\x89PNG"
    assert "<canvas" in left["cube.html"].read_text(encoding="utf-8")
    for file in left:
        assert f"handlcp_demo/{file}" in done.stdout


def test_a_scene_that_was_changed_is_kept_and_run(tmp_path):
    file = tmp_path / "cube.toml"
    text = pathlib.Path(CUBE).read_text(encoding="utf-8")
    file.write_text(text.replace("mass_kg = 0.2", "mass_kg = 2.0"), encoding="utf-8")
    done = run(tmp_path, status=1)
    assert "NOT HELD" in done.stdout
    assert "mass_kg = 2.0" in file.read_text(encoding="utf-8")


def test_without_what_draws_it_says_what_to_install_for_more(tmp_path, monkeypatch):
    for package in ("matplotlib", "trimesh"):
        monkeypatch.setitem(sys.modules, package, None)  # as if it were not installed
    done = run(tmp_path, status=0)
    assert [file.name for file in tmp_path.iterdir()] == ["cube.toml"]
    assert "a picture, too: pip install 'matplotlib>=3.8'" in done.stdout
    assert "a page to turn, too: pip install 'trimesh>=4.8.3'" in done.stdout
