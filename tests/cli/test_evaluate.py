"""`handlcp evaluate` from the outside: hands by name, by file and from a scene, requirements, exit status."""

import json
from functools import partial

import pytest

import handlcp as hl
from tests.support import command
from tests.support.command import CUBE, ROOT
from tests.support.design import evaluated_by

run = partial(command.run, "evaluate")
URDF = ROOT / "urdf" / "three_finger.urdf"
GIVEN = ("--joint-stiffness", 1.0, "--pad-flexibility", 1e-4, "--tip-radius", 0.008)
BRIEF = 'tries = 4\n[objects.ball]\nshape = "sphere"\nradius_m = 0.03\nmass_kg = 0.05\n'
SCENE = '[hand]\nname = "three_finger"\njoint_stiffness_Nm_per_rad = 1.0\n[object]\nshape = "sphere"\nradius_m = 0.03\n'


@pytest.fixture
def brief(tmp_path):
    file = tmp_path / "brief.toml"
    file.write_text(BRIEF)
    return file


def test_what_is_printed_is_the_evaluation_of_the_hand_and_what_is_not_met(brief):
    found = hl.evaluate(hl.example_hand("three_finger"), hl.Brief.from_toml(brief))
    assert found.holds
    done = run(URDF, brief, *GIVEN, "--require", "payload>=50", "--require", "motion<1", status=1)
    assert done.stdout.startswith(str(found))
    assert "payload >= 50 kg is not met" in done.stdout
    assert "motion <" not in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_a_hand_by_name_by_file_and_from_a_scene_is_the_same_hand(brief, tmp_path, monkeypatch):
    hands = []
    known = hl.evaluate(hl.example_hand("three_finger"), hl.Brief.from_toml(brief))
    evaluated_by(monkeypatch, lambda hand, brief: hands.append(hand) or known)
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE)
    for hand, options in (("three_finger", ()), (URDF, GIVEN), (scene, ())):
        assert run(hand, brief, *options).exit_code == 0
    assert len({str(hand.describe().to_dict()["joints"]) for hand in hands}) == 1
    told = json.loads(run("three_finger", brief, "--json", "--require", "payload>0.05").stdout)
    assert told["payload_kg"] == known.payload
    assert told["unmet"] == []


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("three_finger", "BRIEF", "--require", "paylaod>=1"), "--require: expected a number among"),
        (("three_finger", "BRIEF", "--require", "payload=1"), "--require"),
        (("three_finger", "nowhere.toml"), "a brief (TOML), got 'nowhere.toml'"),
        (("three_fingers", "BRIEF"), "did you mean 'three_finger'"),
        ((URDF, "BRIEF"), "--joint-stiffness"),
        (("nofile.urdf", "BRIEF"), "'nofile.urdf', which does not exist"),
        (("three_finger", "BRIEF", "--tip-radius", "-1"), "--tip-radius: expected"),
        (("BRIEF", "BRIEF"), "brief.toml"),
        ((CUBE, "BRIEF", "--joint-stiffness", "2"), "beside a scene file"),
    ],
)
def test_bad_input_is_one_message_and_exit_status_2(arguments, says, brief):
    done = run(*[brief if a == "BRIEF" else a for a in arguments])
    assert (done.exit_code, done.stdout) == (2, "")
    assert says in done.stderr
