"""`handlcp` from the outside: exit status, what is printed where, JSON that machines can read."""

from __future__ import annotations

import json
import pathlib
import re
import subprocess
import sys
from itertools import pairwise
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app
from handlcp.hand.library import urdf
from handlcp.studies.effect_catalogue import Cost, entries
from tests.support import patches
from tests.support.messages import without_compiling
from tests.support.texts import same, says, without_numbers

ROOT = pathlib.Path(__file__).parents[2]
CUBE = str(ROOT / "examples" / "cube_three_fingers.toml")
SMOOTH = """
title = "No friction"
[[contact]]
position_m = [0.03, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
friction = "frictionless"
[[contact]]
position_m = [-0.03, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
friction = 0
[grasp]
flexibility_m_per_N = 1e-3
[load]
force_N = [0.0, 0.0, -1.0]
"""


def run(*arguments, width="100"):
    return CliRunner().invoke(app, [str(a) for a in arguments], env={"COLUMNS": width, "NO_COLOR": "1"})


def scene(tmp_path, text):
    file = tmp_path / "scene.toml"
    file.write_text(text)
    return file


def verdict_of(stdout, word):
    """The paragraph that starts with the verdict's word."""
    return " ".join(stdout[stdout.index(f"{word}: ") :].partition("\n\n")[0].split()).removeprefix(f"{word}: ")


def heading_of(stdout):
    """The words over the first rule of the table of effects."""
    stdout = stdout[stdout.index("Effects") :]
    return next(" ".join(a.split()) for a, rule in pairwise(stdout.splitlines()) if set(rule.strip()) == {"─"})


def strict(text):
    """JSON without NaN or Infinity."""
    return json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))


def test_a_held_scene_prints_the_verdict_then_contacts_and_torques_and_exits_0():
    done = run("solve", CUBE)
    assert done.exit_code == 0, done.output
    assert done.stdout.index("HELD:") < done.stdout.index("finger_2_tip   ") < done.stdout.index("finger_1_distal  ")
    assert "sticking" in done.stdout
    assert "Coulomb friction" not in done.stdout, "effects are told with --explain"
    titles = [a for a, b in pairwise(done.stdout.splitlines()) if a[:1].strip() and not (b.strip() or a.endswith("."))]
    says("; ".join(line.strip() for line in titles), "squeezed")
    same("cli/test_cli: a held scene, verdict", verdict_of(done.stdout, "HELD"), "finger_2_proximal", "38 % of 0.8 N·m")


def test_explain_prints_each_effects_share_of_the_time_and_json_has_it(tmp_path, monkeypatch):
    patches.shares_of_a_quarter(monkeypatch)
    done = run("solve", CUBE, "--explain")
    assert done.exit_code == 0, done.output
    says(heading_of(done.stdout), "unknowns")
    assert "soft finger" in done.stdout, "which is off"
    (flexible,) = (line for line in done.stdout.splitlines() if "finger flexibility" in line)
    assert flexible.rstrip().endswith("25 %")
    (balance,) = (line for line in done.stdout.splitlines() if "object balance" in line)
    assert balance.rstrip().endswith("–")
    found = strict(run("solve", CUBE, "--explain", "--json").stdout)
    assert found["problem"]["solve_s"] == 2.0
    shares = {e["title"]: e["share_of_solve"] for e in found["effects"]}
    assert shares["object balance"] is shares["soft wrist"] is None
    assert shares["finger flexibility"] == 0.25
    plain = strict(run("solve", CUBE, "--json").stdout)
    assert plain["problem"]["solve_s"] is None
    none = run("solve", scene(tmp_path, SMOOTH), "--explain")
    assert none.exit_code == 1
    says(none.stdout.splitlines()[-1], "measured")


def test_a_scene_that_does_not_hold_exits_1_and_says_which_way_the_object_goes(tmp_path):
    done = run("solve", scene(tmp_path, SMOOTH))
    assert done.exit_code == 1
    same("cli/test_cli: which way it slides out", verdict_of(done.stdout, "NOT HELD"), "(0, 0, -1)")


def test_motors_that_are_too_weak_exit_1(tmp_path):
    text = pathlib.Path(CUBE).read_text().replace("[object]", "torque_limits_Nm = 0.2\n[object]")
    done = run("solve", scene(tmp_path, text))
    assert done.exit_code == 1
    same("cli/test_cli: motors too weak", verdict_of(done.stdout, "OVER LIMIT"), "finger_2_proximal", "0.2 N·m")
    (row,) = (line for line in done.stdout.splitlines() if line.startswith(" finger_2_proximal"))
    says(re.split("[█·]", row)[-1].strip(), "limit")


def test_a_bad_scene_exits_2_with_one_message_on_stderr(tmp_path):
    done = run("solve", scene(tmp_path, SMOOTH + "[grasp2]\nx = 1"))
    assert done.exit_code == 2
    assert done.stdout == ""
    same("cli/test_cli: a bad scene", " ".join(done.stderr.split()), "scene.toml: grasp2: ", "'grasp'")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ("solve", "nothing_here.toml"),
        ("solve", CUBE, "--faces", "2"),
        ("solve", CUBE, "--faces", "many"),
        ("solve", CUBE, "--seed", "-1"),
        ("solve", CUBE, "--seed", "x"),
        ("solve", CUBE, "--plot", "picture.doc"),
        ("solve", CUBE, "--unknown"),
        ("solve",),
        ("audit", "nothing_here.urdf"),
        ("audit", CUBE),
        ("no_such_command",),
    ],
)
def test_bad_input_exits_2_and_prints_nothing_on_stdout(arguments):
    done = run(*arguments)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "rror" in done.stderr


def test_json_is_one_object_with_everything_and_no_nan():
    done = run("solve", CUBE, "--json")
    found = strict(done.stdout)
    assert done.exit_code == 0
    assert found["status"] == "SOLVED"
    assert found["verdict"]["word"] == "HELD"
    assert {e["title"] for e in found["effects"] if e["on"]} >= {"object balance", "unilateral contact"}
    assert [c["name"] for c in found["contacts"]] == ["finger_1_tip", "finger_2_tip", "finger_3_tip"]
    lift = sum(c["force_world_N"][2] for c in found["contacts"])
    assert lift == pytest.approx(0.2 * 9.81, rel=1e-9)
    assert found["load"]["force_N"][2] == pytest.approx(-lift)
    assert [t["joint"] for t in found["torques"] if t["binding"]] == ["finger_2_proximal"]
    assert found["residuals"]["worst"] < 1e-8
    assert found["uniqueness"]["forces_determined"] is True
    assert found["certificate"] is found["required_preload_m"] is found["proven_within"] is None
    assert found["versions"]["handlcp"] == hl.__version__


def test_json_of_a_scene_that_does_not_hold_has_null_for_forces_and_a_certificate(tmp_path):
    done = run("solve", scene(tmp_path, SMOOTH), "--json")
    found = strict(done.stdout)
    assert done.exit_code == 1
    assert found["status"] == "NOT_HOLDABLE"
    assert found["contacts"][0]["force_N"] == [None, None, None]
    assert found["torques"] is None
    assert found["certificate"]["linear_m"][2] < 0, "down"


def test_json_of_a_scene_without_equilibrium_says_which_squeeze_would_hold(tmp_path):
    file = scene(tmp_path, pathlib.Path(CUBE).read_text().replace("squeeze_m = 0.005", ""))
    done = run("solve", file, "--json")
    found = strict(done.stdout)
    assert (done.exit_code, found["status"]) == (1, "NO_EQUILIBRIUM")
    assert found["proven_within"]["force_N"] > 100
    assert 0.003 < found["required_preload_m"] < 0.004
    said = run("solve", file).stdout
    same("cli/test_cli: nothing squeezes", verdict_of(said, "NOT HELD"))
    same("cli/test_cli: which squeeze would hold", verdict_of(said, "Advice"), "1.5 mm")
    assert said.count("1.5 mm") == 1


def test_faces_and_seed_override_the_file():
    def normals(*extra):
        contacts = strict(run("solve", CUBE, "--json", *extra).stdout)["contacts"]
        return [c["force_N"][2] for c in contacts]

    assert normals("--seed", "5") == pytest.approx(normals(), rel=1e-9)
    told = run("solve", CUBE, "--faces", "16", "--explain").stdout
    (pyramid,) = (line for line in told.splitlines() if "λ 48" in line)
    assert "Coulomb" in pyramid, "3 contacts with 16 faces each"


def test_a_picture_is_written_on_request(tmp_path):
    out = tmp_path / "cube.png"
    done = run("solve", CUBE, "--plot", out, "--json")
    assert done.exit_code == 0
    strict(done.stdout)
    assert out.stat().st_size > 20_000


def test_everything_fits_80_columns():
    for arguments in (("solve", CUBE), ("keys",), ("effects",), ("hands",), ("audit", urdf("two_finger"))):
        lines = run(*arguments, width="80").stdout.splitlines()
        assert max(map(len, lines)) <= 80, arguments


def test_audit_lists_doubts(tmp_path):
    file = tmp_path / "weak.urdf"
    file.write_text(urdf("two_finger").read_text().replace('effort="0.4"', 'effort="0"'))
    done = run("audit", file)
    assert done.exit_code == 0
    assert "finger_1_distal" in done.stdout
    doubts = strict(run("audit", file, "--json").stdout)["doubts"]
    (said,) = (d["what"] for d in doubts if "finger_1_distal" in d["joint"])
    says(said, "unknown")
    assert {word for word in said.split() if word not in done.stdout} == set()


def test_hands_lists_every_hand_with_joints_and_tips():
    found = strict(run("hands", "--json").stdout)
    names = {h["name"]: h for h in found["hands"]}
    assert {"two_finger", "three_finger", "five_finger", "planar_ring"} <= set(names)
    assert len(names["three_finger"]["joints"]) == 6
    assert names["three_finger"]["fingertips"] == ["finger_1_tip", "finger_2_tip", "finger_3_tip"]
    assert "three_finger" in run("hands").stdout


def test_keys_lists_what_a_scene_file_may_hold():
    found = strict(run("keys", "--json").stdout)["keys"]
    assert {"radius_m", "preload_m", "faces"} <= {k["key"] for k in found}
    assert "joint_stiffness_Nm_per_rad" in run("keys").stdout


def test_effects_lists_every_effect_and_measures_when_asked(monkeypatch):
    found = strict(run("effects", "--json").stdout)["effects"]
    assert [e["title"] for e in found] == [e.title for e in entries()]
    assert {e["cost"] for e in found} == {None}
    text = run("effects", width="80").stdout
    for e in entries():
        assert e.title in text
        for key in e.file_keys:
            assert key in text
    patches.costs_of_effects(monkeypatch, lambda: {e.title: Cost(-3, 1.25) for e in entries()})
    assert {str(e["cost"]) for e in strict(run("effects", "--measure", "--json").stdout)["effects"]} == {
        "{'unknowns': -3, 'ratio': 1.25}"
    }
    lines = run("effects", "--measure", width="80").stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert sum("-3   × 1.2" in line for line in lines) == len(found)


def test_paper_passes_on_the_studys_verdict(monkeypatch):
    report = SimpleNamespace(ok=False, to_json=lambda: '{"ok": false}')
    patches.paper_report(monkeypatch, lambda: report)
    done = run("paper", "--json")
    assert (done.exit_code, strict(done.stdout)) == (1, {"ok": False})


def test_version():
    done = run("--version")
    assert (done.exit_code, done.stdout) == (0, f"handlcp {hl.__version__}\n")


def test_as_a_program_of_its_own():
    done = subprocess.run(
        [sys.executable, "-m", "handlcp", "solve", CUBE, "--json"], capture_output=True, text=True, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    assert without_compiling(done.stderr) == ""
    assert strict(done.stdout)["verdict"]["ok"] is True
    bad = subprocess.run(
        [sys.executable, "-m", "handlcp", "solve", "no.toml"], capture_output=True, text=True, cwd=ROOT
    )
    assert (bad.returncode, bad.stdout) == (2, "")
    assert "Traceback" not in bad.stderr


NOISY = """
import ctypes, sys
from handlcp import cli, scene
load = scene.load
scene.load = lambda file: (ctypes.CDLL(None).puts(b"noise of a C library"), load(file))[1]
sys.argv[1:] = ["solve", sys.argv[1], "--json"]
cli.main()
"""


def test_what_c_libraries_print_is_not_part_of_the_answer():
    done = subprocess.run([sys.executable, "-c", NOISY, CUBE], capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, without_compiling(done.stderr)) == (0, "")
    assert strict(done.stdout)["status"] == "SOLVED"


def test_a_closed_stdout_is_no_crash():
    command = f"'{sys.executable}' -m handlcp solve '{CUBE}' >&-"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, cwd=ROOT)
    assert "Traceback" not in done.stderr


def test_an_accuracy_is_asked_for_in_place_of_faces():
    done = run("solve", CUBE, "--accuracy", "1e-3")
    assert done.exit_code == 0
    (said,) = (line for line in done.stdout.splitlines() if "1.0e-03" in line)
    but_for_the_time = said.rpartition(",")[0]
    says(without_numbers(but_for_the_time), "exact cone")
    reached = strict(run("solve", CUBE, "--accuracy", "1e-3", "--json").stdout)["accuracy"]
    assert (reached["asked"], reached["met"], reached["setting"]) == (1e-3, True, "exact cone")
    assert 0 < reached["error"] < 1e-9
    assert strict(run("solve", CUBE, "--json").stdout)["accuracy"] is None


@pytest.mark.parametrize("options", [("--accuracy", "0"), ("--accuracy", "1e-3", "--faces", "8")])
def test_an_accuracy_that_makes_no_sense_exits_2(options):
    done = run("solve", CUBE, *options)
    assert done.exit_code == 2
    assert "accuracy" in done.stderr


def test_an_empty_line_follows_a_tables_caption():
    """That of slips on the whole way, which the scene's three sliding fingers have."""
    lines = run("solve", ROOT / "examples" / "psyonic_grasp.toml").stdout.splitlines()
    (at,) = (i for i, line in enumerate(lines) if line.strip() == "slip: on the whole way")
    assert not lines[at + 1].strip()
    assert lines[at + 2].startswith("Joint torques")
