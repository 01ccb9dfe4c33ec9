"""Whatever is malformed, on the command line or in a file: exit status 2, one sentence on stderr, nothing on stdout."""

import os
import pathlib

import pytest

from handlcp.studies.envelope.question import EnvelopeQuestion
from tests.support.command import CUBE, ROOT, run

PAPER, PLANAR = ROOT / "examples" / "paper", ROOT / "examples" / "planar_ring.toml"
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
    "an empty page": ("solve", CUBE, "--page", ""),
    "no such hand": ("hands", "inspir"),
    "no such option": ("--foo",),
    "no such command": ("solv", CUBE),
}


def refused(arguments):
    done = run(*arguments)
    assert done.exception is None or isinstance(done.exception, SystemExit), repr(done.exception)[:200]
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith("Error: ")
    assert len(done.stderr.splitlines()) == 1
    assert len(done.stderr) < 1000
    return done.stderr


# (command and arguments, a word that stderr says); each argument of a command that is checked, by one wrong value
REFUSED = [
    (("solve", "nothing_here.toml"), "nothing_here.toml"),
    (("solve", CUBE, "--faces", "2"), "faces"),
    (("solve", CUBE, "--seed", "-1"), "seed"),
    (("solve", CUBE, "--plot", "picture.doc"), "plot"),
    (("solve", CUBE, "--accuracy", "0"), "accuracy"),
    (("solve", CUBE, "--accuracy", "1e-3", "--faces", "8"), "accuracy"),
    (("solve",), "scene"),
    (("solve", ""), "which is empty"),
    (("audit", "nothing_here.urdf"), "nothing_here.urdf"),
    (("audit", CUBE), "path"),
    (("accuracy", CUBE, "--seconds", "0"), "seconds"),
    (("accuracy", CUBE, "--plot", "nowhere/cost.png"), "plot"),
    (("accuracy", CUBE, "--csv", "nowhere/rows.csv"), "csv"),
    (("follow", CUBE, "--steps", "0"), "steps"),
    (("follow", CUBE, "--order", "load,then"), "order"),
    (("follow", CUBE, "--plot", "way.doc"), "plot"),
    (("follow", CUBE, "--picture", "nowhere/end.png"), "a folder that exists"),
    (("follow", f"{PAPER}/partially_known_forces.toml"), "PrescribedForce"),
    (("limits", CUBE, "--direction", "up"), "direction"),
    (("limits", CUBE, "--direction", "0,0,0"), "direction"),
    (("limits", CUBE, "--direction", "nan,0,1"), "direction"),
    (("limits", CUBE, "--wrench", *"000000"), "wrench"),
    (("limits", CUBE, "--wrench", *"100000", "--direction", "+x"), "direction"),
    (("limits", CUBE, "--motion", "-1"), "motion"),
    (("motors", CUBE, "--load", "push"), "--load"),
    (("motors", CUBE, "--load", "push=1,2"), "--load"),
    (("motors", CUBE, "--load", "a=0,0,1", "--load", "a=0,0,2"), "--load"),
    (("motors", CUBE, "--load", "=0,0,1"), "--load"),
    (("motors", CUBE, "--load", "a=0,0,nan"), "--load"),
    (("motors", CUBE, "--safety", "0"), "safety"),
    (("motors", CUBE, "--motor", "0.03,0.01"), "otor"),
    (("motors", CUBE, "--motor", "1,2,3,4"), "otor"),
    (("motors", f"{PAPER}/hard_finger.toml"), "[hand]"),
    (("payload", CUBE, "--fixed", "--acceleration", "-1"), "acceleration: expected"),
    (("payload", CUBE, "--fixed", "--accuracy", "0"), "accuracy"),
    (("reliability", CUBE), "friction"),
    (("reliability", CUBE, "--friction", "-1"), "friction"),
    (("reliability", CUBE, "--friction", "0.1", "--samples", "3"), "samples"),
    (("reliability", CUBE, "--friction", "0.1", "--plot", "sure.doc"), "plot"),
    (("reliability", CUBE, "--friction", "0.1", "--resume", "nowhere/run.npz"), "resume"),
    (("reliability", f"{PAPER}/total_bound.toml", "--mass", "0.1"), "mass"),
    (("envelope", CUBE, "--directions", "yx"), "directions"),
    (("envelope", CUBE, "--directions", "xy,2"), "directions"),
    (("envelope", CUBE, "--of", "weight"), "of: expected"),
    (("envelope", CUBE, "--plot", "picture.txt"), "plot"),
    (("envelope", CUBE, "--page", "page.txt"), "page"),
    (("envelope", CUBE, "--page", "page.html", "--directions", "xy"), "--page: expected directions all around"),
    (("envelope", f"{PLANAR}", "--page", "page.html"), "planar scene"),
    (("envelope", CUBE, "--turn", "5"), "5 (degrees? They are 0.0873 rad)"),
]


@pytest.mark.parametrize(
    ("arguments", "word"), REFUSED, ids=lambda x: " ".join(x[:1] + x[2:]) if isinstance(x, tuple) else ""
)
def test_an_argument_is_refused_by_its_name_before_any_work(arguments, word, monkeypatch):
    monkeypatch.setattr(EnvelopeQuestion, "find_factors", lambda *_, **__: pytest.fail("work has begun"))
    assert word in refused(arguments)


@pytest.mark.parametrize("name", TEXTS)
def test_a_scene_file(name, tmp_path):
    file = tmp_path / "scene.toml"
    text = TEXTS[name]
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    refused(("solve", file))


@pytest.mark.parametrize("name", OPTIONS)
def test_an_option(name):
    refused(OPTIONS[name])


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
