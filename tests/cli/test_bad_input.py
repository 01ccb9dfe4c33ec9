"""Whatever is malformed, on the command line or in a file: exit status 2, one sentence on stderr, nothing on stdout."""

from __future__ import annotations

import os
import pathlib

import pytest
from typer.testing import CliRunner

from handlcp.cli import app

ROOT = pathlib.Path(__file__).parents[2]
CUBE = str(ROOT / "examples" / "cube_three_fingers.toml")
TEXT = pathlib.Path(CUBE).read_text(encoding="utf-8")
LONG, DIGITS = "a" * 5000, "9" * 5000
MESH = ('shape = "box"\nsize_m = 0.05', 'shape = "mesh"\nfile = ')

TEXTS = {
    "arrays in arrays": "a = " + "[" * 3000 + "]" * 3000,
    "arrays in arrays, shallow enough to be parsed": TEXT.replace("= 0.8", "= " + "[" * 200 + "1" + "]" * 200),
    "tables in tables": "a = " + "{a=" * 3000 + "1" + "}" * 3000,
    "a dotted key": ".".join(["a"] * 3000) + " = 1",
    "5000 digits": "a = " + DIGITS,
    "4000 digits": TEXT.replace("= 0.2", "= " + DIGITS[:4000]),
    "5000 hexadecimal digits": TEXT.replace("= 0.2", "= 0x" + "f" * 5000),
    "65 bits": TEXT + f"[solve]\nseed = {2**63}",
    "a number beyond floats": TEXT.replace("= 0.2", "= 1e99999"),
    "a long hand": TEXT.replace('"three_finger"', f'"{LONG}"'),
    "a long URDF": TEXT.replace('name = "three_finger"', f'urdf = "{LONG}"'),
    "a NUL in a URDF": TEXT.replace('name = "three_finger"', 'urdf = "a\\u0000b"'),
    "a long mesh": TEXT.replace(MESH[0], f'{MESH[1]}"{LONG}.stl"'),
    "a NUL in a mesh": TEXT.replace(MESH[0], f'{MESH[1]}"a\\u0000.stl"'),
    "a folder for a mesh": TEXT.replace(MESH[0], f'{MESH[1]}"/"'),
    "a long package folder": TEXT.replace('name = "three_finger"', f'urdf = "x"\npackage_dirs = ["{LONG}"]'),
    "NUL bytes": "\0\0\0",
    "no UTF-8": b"\xff\xfe\x00",
}
OPTIONS = {
    "a long seed": ("solve", CUBE, "--seed", DIGITS),
    "a long negative seed": ("solve", CUBE, f"--seed=-{DIGITS}"),
    "a seed of 4000 digits": ("solve", CUBE, "--seed", DIGITS[:4000]),
    "many faces": ("solve", CUBE, "--faces", DIGITS),
    "a superscript": ("solve", CUBE, "--faces", "²"),
    "digits of another script": ("solve", CUBE, "--faces", "٨"),
    "an accuracy beyond floats": ("solve", CUBE, "--accuracy", DIGITS),
    "an accuracy of nothing": ("solve", CUBE, "--accuracy", "nan"),
    "seconds beyond floats": ("accuracy", CUBE, "--seconds", DIGITS),
    "many steps": ("follow", CUBE, "--steps", DIGITS),
    "a long order": ("follow", CUBE, "--order", LONG),
    "a long scene": ("solve", LONG),
    "a long path": ("solve", "/".join(["a" * 200] * 30)),
    "a NUL in a scene": ("solve", "a\0b"),
    "a NUL in a picture": ("solve", CUBE, "--plot", "a\0.png"),
    "a folder": ("solve", "/"),
    "a device": ("solve", os.devnull),
    "a folder for a URDF": ("audit", "/"),
    "a long URDF": ("audit", LONG),
    "a long base": ("audit", str(ROOT / "urdf" / "two_finger.urdf"), "--base", LONG),
    "a long picture": ("solve", CUBE, "--plot", f"{LONG}.png"),
    "a long curve": ("follow", CUBE, "--plot", f"{LONG}.png"),
    "a long picture of the end": ("follow", CUBE, "--picture", f"{LONG}.png"),
    "a long table": ("accuracy", CUBE, "--csv", LONG),
    "a folder for a table": ("accuracy", CUBE, "--csv", "/"),
    "5000 faces": ("solve", CUBE, "--faces", DIGITS),
    "an empty scene": ("solve", ""),
    "an empty page": ("solve", CUBE, "--page", ""),
    "no such hand": ("hands", "inspir"),
    "no such option": ("--foo",),
    "no such command": ("solv", CUBE),
}


def refused(arguments):
    done = CliRunner().invoke(app, [str(a) for a in arguments], env={"COLUMNS": "80", "NO_COLOR": "1"})
    assert done.exception is None or isinstance(done.exception, SystemExit), repr(done.exception)[:200]
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith("Error: ")
    assert len(done.stderr.splitlines()) == 1
    assert len(done.stderr) < 1000
    return done.stderr


@pytest.mark.parametrize("name", TEXTS)
def test_a_scene_file(name, tmp_path):
    file = tmp_path / "scene.toml"
    text = TEXTS[name]
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    refused(("solve", file))


@pytest.mark.parametrize("name", OPTIONS)
def test_an_option(name):
    refused(OPTIONS[name])


def test_an_empty_argument_is_called_empty():
    assert "which is empty" in refused(("solve", ""))


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_a_file_that_may_not_be_read(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(TEXT)
    file.chmod(0)
    assert "Permission denied" in refused(("solve", file))


def test_a_picture_where_no_file_can_be_is_refused_before_the_work(tmp_path, monkeypatch):
    monkeypatch.setattr("handlcp.scene.load", lambda file: pytest.fail("work has begun"))
    (tmp_path / "folder.png").mkdir()
    refused(("solve", CUBE, "--plot", tmp_path / "folder.png"))
    (tmp_path / "full.png").symlink_to("/dev/full")
    if pathlib.Path("/dev/full").exists():
        assert "No space left" in refused(("solve", CUBE, "--plot", tmp_path / "full.png"))
        assert "No space left" in refused(("follow", CUBE, "--picture", tmp_path / "full.png"))


def test_asking_whether_a_picture_can_be_written_leaves_no_trace(tmp_path):
    bad, new, old = tmp_path / "bad.toml", tmp_path / "new.png", tmp_path / "old.png"
    bad.write_text("[nothing]")
    old.write_bytes(b"precious")
    for file in (new, old):
        refused(("solve", bad, "--plot", file))
    assert not new.exists()
    assert old.read_bytes() == b"precious"
