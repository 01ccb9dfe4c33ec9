"""`handlcp motors` and `reliability` from the outside."""

import json
from functools import partial

import pytest

from handlcp.grasp import parameters
from tests.support import command
from tests.support.command import CUBE, changed
from tests.support.messages import without_compiling
from tests.support.texts import same

run, reliability = partial(command.run, "motors"), partial(command.run, "reliability")


def test_a_scene_gets_its_motors_within_80_columns_and_exits_0():
    done = run(CUBE, "--safety", "2", status=0)
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert without_compiling(done.stderr) == ""
    said = " ".join(done.stdout[done.stdout.index("FOUND:") :].partition("\n\n")[0].split())
    same("cli/test_motors: a cube", said, "the load × 2", "enough")
    for part in ("finger_1_distal", "squeeze", "finger_2_tip", "of limit"):
        assert part in done.stdout


@pytest.mark.long
def test_loads_and_directions_of_gravity_are_named_in_json():
    done = run(CUBE, "--load", "push=0,2,0", "--load", "twist=0,0,0,0,0,0.01", "--turned", "--json", status=0)
    found = json.loads(done.stdout)
    assert list(found["verdicts"]) == ["push", "twist", "x up", "x down", "y up", "y down", "z up", "z down"]
    assert set(found["verdicts"].values()) == {"HELD"}
    assert all(0 < row["torque_Nm"] <= row["limit_Nm"] for row in found["joints"])


@pytest.mark.long
def test_a_load_that_no_grip_holds_exits_1_and_says_which(tmp_path):
    done = run(changed(tmp_path, ("friction = 0.8", "friction = 0.01")), status=1)
    assert "NONE: No grip was found that holds the load × 1.5" in " ".join(done.stdout.split())


def test_what_check_does_not_call_held_is_not_confirmed_and_exits_1(tmp_path):
    deep = ("size_m = 0.05", "size_m = [0.05, 0.05, 0.13]"), ("0.0, 0.08]", "0.0, 0.05]")
    done = run(changed(tmp_path, *deep), status=1)
    said = " ".join(done.stdout.split())
    assert "NOT CONFIRMED: " in said
    assert "UNDECIDED: " in said
    assert "inside" in said
    assert " held" not in said.partition("Torque of each joint")[0].partition("NOT CONFIRMED")[2]


@pytest.mark.long
def test_a_motor_to_buy_gets_the_reduction_that_it_needs_at_each_joint():
    done = run(CUBE, "--motor", "0.01,0.03", "--efficiency", "0.7", "--json", status=0)
    found = json.loads(done.stdout)
    for row, reduction in zip(found["joints"], found["reductions"], strict=True):
        needs = max(row["peak_Nm"] / (0.7 * 0.03), row["continuous_Nm"] / (0.7 * 0.01))
        assert reduction == pytest.approx(needs, rel=1e-12)
    table = run(CUBE, "--motor", "0.01,0.03", "--efficiency", "0.7").stdout
    assert max(map(len, table.splitlines())) <= 80
    assert "Reduction that the motor needs" in table
    assert "tendon" not in table
    rubs = json.loads(run(CUBE, "--motor", "0.01,0.03,0.05", "--efficiency", "0.7", "--json").stdout)
    for row, reduction in zip(rubs["joints"], rubs["reductions"], strict=True):
        closes, holds = max(row["closing_Nm"] + 0.05, row["torque_Nm"] - 0.05), max(row["continuous_Nm"] - 0.05, 0.0)
        assert reduction == pytest.approx(max(closes / (0.7 * 0.03), holds / (0.7 * 0.01)), rel=1e-12)


@pytest.mark.long
def test_tendons_with_motors_get_the_reductions_and_the_joints_that_they_move_none(tmp_path):
    arms = ", ".join([f"pull_{k} = {{ finger_{k}_proximal = 0.012, finger_{k}_distal = 0.008 }}" for k in (1, 2, 3)])
    tendons = f"stiffness_N_per_m = 2e4\npassive_Nm_per_rad = 4.0\nmoment_arms_m = {{ {arms} }}\n"
    motors = "".join([f"[hand.tendons.motors.pull_{k}]\ncontinuous_Nm = 1\nreduction_N_per_Nm = 200\n" for k in (1, 2)])
    file = changed(tmp_path, ("joint_stiffness_Nm_per_rad = 6.0\n", f"[hand.tendons]\n{tendons}{motors}"))
    done = run(file, "--motor", "0.01,0.03", "--efficiency", "0.7", "--json", status=0)
    found = json.loads(done.stdout)
    assert found["reductions"][:4] == [None] * 4
    assert min(found["reductions"][4:]) > 0.0  # no motor pulls at the third tendon: its joints may have their own
    for row, reduction in zip(found["tendons"], found["tendon_reductions"], strict=True):
        needs = max(row["peak_N"] / (0.7 * 0.03), row["continuous_N"] / (0.7 * 0.01))
        assert reduction == pytest.approx(needs, rel=1e-12)
    said = run(file, "--motor", "0.01,0.03", "--efficiency", "0.7").stdout
    assert max(map(len, said.splitlines())) <= 80
    pull, _, gears = " ".join(said.split()).partition("Pull of the tendons")[2].partition("Reduction that the motor")
    at_joints, _, at_tendons = gears.partition("Reduction at each tendon")
    assert "pull_1" in pull
    assert "finger_3_distal" in at_joints
    assert "finger_1_distal" not in at_joints
    assert "pull_1" in at_tendons


# ---------------------------------------------------------------- reliability
def test_a_scene_prints_its_chances_the_worst_sample_and_what_matters(tmp_path):
    varies, file = ("--friction", "0.3", "--mass", "0.1", "--samples", "64"), tmp_path / "sure.png"
    done = reliability(CUBE, *varies, "--plot", file, status=0)
    for word in ("holds, and within torque limits: ", "64 samples", "worst: sample", "friction", "mass"):
        assert word in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80 + len(str(tmp_path))
    assert without_compiling(done.stderr) == "", "no bar without a terminal"
    assert file.stat().st_size > 20_000


def test_json_of_a_reliability_is_one_object_and_a_run_that_is_kept_is_not_repeated(tmp_path):
    file = tmp_path / "run.npz"
    both = [reliability(CUBE, "--friction", "0.3", "--samples", "64", "--resume", file, "--json") for _ in range(2)]
    one, two = (json.loads(done.stdout) for done in both)
    assert one == two
    assert one["samples"] == 64
    assert sum(one["counts"].values()) == 64
    assert one["chance_held"]["low"] <= one["chance_held"]["value"] <= one["chance_held"]["high"]
    assert file.exists()
    other = reliability(CUBE, "--friction", "0.2", "--samples", "64", "--resume", file)
    assert other.exit_code == 2
    assert "another spread" in " ".join(other.stderr.split())


def test_there_is_an_option_for_each_parameter_that_varies_and_it_says_what_a_number_is():
    text = " ".join(reliability("--help").stdout.replace("│", " ").split())
    options = [f"--{p.spread} <float> {p.uncertain}" for p in parameters() if p.spread]
    assert len(options) == 8
    assert [o for o in options if o not in text] == []
