"""`handlcp` from the outside: exit status, what is printed where, JSON that machines can read."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from functools import partial
from itertools import pairwise

import pytest
import typer

import handlcp as hl
from handlcp.cli import app
from handlcp.hand.library import urdf
from handlcp.studies.effect_catalogue import Cost, entries
from tests.support import command, patches
from tests.support.command import CUBE, ROOT, changed, strict
from tests.support.messages import without_compiling
from tests.support.texts import same, says, without_numbers

run = partial(command.run, width="100")
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


def test_a_held_scene_prints_the_verdict_then_contacts_and_torques_and_exits_0():
    done = run("solve", CUBE, status=0)
    assert done.stdout.index("HELD:") < done.stdout.index("finger_2_tip   ") < done.stdout.index("finger_1_distal  ")
    assert "sticking" in done.stdout
    assert "Coulomb friction" not in done.stdout, "effects are told with --explain"
    titles = [a for a, b in pairwise(done.stdout.splitlines()) if a[:1].strip() and not (b.strip() or a.endswith("."))]
    says("; ".join(line.strip() for line in titles), "squeezed")
    same("cli/test_cli: a held scene, verdict", verdict_of(done.stdout, "HELD"), "finger_2_proximal", "38 % of 0.8 N·m")


def test_explain_prints_each_effects_share_of_the_time_and_json_has_it(tmp_path, monkeypatch):
    patches.shares_of_a_quarter(monkeypatch)
    done = run("solve", CUBE, "--explain", status=0)
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
    none = run("solve", scene(tmp_path, SMOOTH), "--explain", status=1)
    says(none.stdout.splitlines()[-1], "measured")


def test_a_scene_that_does_not_hold_exits_1_and_says_which_way_the_object_goes(tmp_path):
    done = run("solve", scene(tmp_path, SMOOTH), status=1)
    same("cli/test_cli: which way it slides out", verdict_of(done.stdout, "NOT HELD"), "(0, 0, -1)")


def test_motors_that_are_too_weak_exit_1(tmp_path):
    done = run("solve", changed(tmp_path, ("[object]", "torque_limits_Nm = 0.2\n[object]")), status=1)
    same("cli/test_cli: motors too weak", verdict_of(done.stdout, "OVER LIMIT"), "finger_2_proximal", "0.2 N·m")
    (row,) = (line for line in done.stdout.splitlines() if line.startswith(" finger_2_proximal"))
    says(re.split("[█·]", row)[-1].strip(), "limit")


def test_a_bad_scene_exits_2_with_one_message_on_stderr(tmp_path):
    done = run("solve", scene(tmp_path, SMOOTH + "[grasp2]\nx = 1"), status=2)
    assert done.stdout == ""
    same("cli/test_cli: a bad scene", " ".join(done.stderr.split()), "scene.toml: grasp2: ", "'grasp'")
    assert "Traceback" not in done.stderr


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


def test_faces_and_seed_override_the_file():
    def normals(*extra):
        contacts = strict(run("solve", CUBE, "--json", *extra).stdout)["contacts"]
        return [c["force_N"][2] for c in contacts]

    assert normals("--seed", "5") == pytest.approx(normals(), rel=1e-9)
    told = run("solve", CUBE, "--faces", "16", "--explain").stdout
    (pyramid,) = (line for line in told.splitlines() if "λ 48" in line)
    assert "Coulomb" in pyramid, "3 contacts with 16 faces each"


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


def test_as_a_program_of_its_own():
    def program(*arguments):
        return subprocess.run([sys.executable, "-m", "handlcp", *arguments], capture_output=True, text=True, cwd=ROOT)

    done = program("solve", CUBE, "--json")
    assert done.returncode == 0, done.stderr
    assert without_compiling(done.stderr) == ""
    assert strict(done.stdout)["verdict"]["ok"] is True
    bad = program("solve", "no.toml")
    assert (bad.returncode, bad.stdout) == (2, "")
    assert "Traceback" not in bad.stderr


def test_an_accuracy_is_asked_for_in_place_of_faces():
    done = run("solve", CUBE, "--accuracy", "1e-3", status=0)
    (said,) = (line for line in done.stdout.splitlines() if "1.0e-03" in line)
    but_for_the_time = said.rpartition(",")[0]
    says(without_numbers(but_for_the_time), "exact cone")
    reached = strict(run("solve", CUBE, "--accuracy", "1e-3", "--json").stdout)["accuracy"]
    assert (reached["asked"], reached["met"], reached["setting"]) == (1e-3, True, "exact cone")
    assert 0 < reached["error"] < 1e-9
    assert strict(run("solve", CUBE, "--json").stdout)["accuracy"] is None


# ---------------------------------------------------------------- What is printed at 80 columns and into a pipe is wh

LISTS = [("keys",), ("effects",), ("hands",), ("audit", str(urdf("two_finger")))]


def words(text) -> Counter:
    """Every word and number, without the rules of tables."""
    return Counter(word for word in text.split() if not all("\u2500" <= letter <= "\u257f" for letter in word))


def printed(arguments, columns):
    done = run(*arguments, width=columns)
    assert done.exception is None or isinstance(done.exception, SystemExit)
    return done.stdout


@pytest.mark.parametrize("arguments", LISTS, ids=lambda a: a[0])
def test_lists_break_no_word_at_80_columns_nor_in_a_pipe(arguments):
    roomy = printed(arguments, "1000")
    for columns in ("80", None):
        narrow = printed(arguments, columns)
        assert words(narrow) == words(roomy)
        assert max(map(len, narrow.splitlines())) <= 80


def test_no_unit_in_a_help_text_is_taken_for_markup_and_left_out():
    """Rich takes [m] for a style, and prints nothing of it."""
    commands = typer.main.get_command(app).commands
    texts = {f"{name} {p.name}": getattr(p, "help", None) for name, one in commands.items() for p in one.params}
    assert len(texts) > 50
    assert [where for where, text in texts.items() if re.search(r"(?<!\\)\[[a-z#/@]", text or "")] == []


def test_a_scene_that_fails_is_told_what_would_hold_it(tmp_path):
    file = changed(tmp_path, ("squeeze_m = 0.005", ""))
    done = run("solve", file, "--suggest", status=1)
    said = " ".join(done.stdout.partition("Suggestions:")[2].split())
    same("cli/test_cli: what would hold it", said, "1.5 mm")
    assert done.stdout.count("1.5 mm") == 1, "it is told once"
    found = strict(run("solve", file, "--suggest", "--json").stdout)
    assert [s["effect"] for s in found["left_out"]["found"]] == ["squeeze"]
    assert found["left_out"]["word"] == "NOT HELD"
    assert found["cause"] == found["diagnosis"] != ""
    held = strict(run("solve", ROOT / "examples" / "allegro_pinch.toml", "--suggest", "--json").stdout)["left_out"]
    assert [s["effect"] for s in held["found"]] == ["finger weight"]
    assert held["least"] == 0.05
    assert strict(run("solve", CUBE, "--json").stdout)["left_out"] is None
