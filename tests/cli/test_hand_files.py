"""`handlcp hands FILE` and `handlcp audit FILE`: a hand of which nothing but its file is known."""

from __future__ import annotations

import json
from importlib.util import find_spec

import pytest

import handlcp as hl
from handlcp.hand.library import allegro, psyonic, urdf
from tests.support.command import run
from tests.support.texts import says

MJCF = """<mujoco model="claw"><worldbody>
<body name="l" pos="0.02 0 0"><joint name="a" axis="0 1 0" range="-60 60" limited="true"/>
<geom size="0.01 0.02" type="capsule" pos="0 0 0.03"/></body>
<body name="r" pos="-0.02 0 0"><joint name="b" axis="0 1 0" range="-60 60" limited="true"/>
<geom size="0.01 0.02" type="capsule" pos="0 0 0.03"/></body></worldbody></mujoco>"""


def test_a_file_is_described():
    """As `describe_urdf` says it, and as JSON."""
    done = run("hands", urdf("three_finger"), status=0)
    described = hl.describe_urdf(urdf("three_finger"))
    assert done.stdout.strip() == str(described)
    assert json.loads(run("hands", urdf("three_finger"), "--json").stdout) == described.to_dict()


def test_a_name_means_that_hand():
    """For `hands` and `audit`; a name of none is refused with the names there are."""
    hand = hl.example_hand("three_finger")
    assert run("hands", "three_finger").stdout.strip() == str(hand.describe())
    assert run("audit", "three_finger").stdout.strip() == str(hand.audit())
    for command in ("hands", "audit"):
        wrong = run(command, "three_fingr")
        assert wrong.exit_code == 2
        assert "did you mean 'three_finger'" in wrong.stderr
        assert "inspire" in wrong.stderr
    assert "--package-dir" in run("hands", "three_finger", "--package-dir", ".").stderr


@pytest.mark.parametrize(("file", "base"), [(urdf("three_finger"), None), (psyonic()[0], "LeftPsyonicAbilityBaseLink")])
def test_a_description_counts_the_doubts_that_an_audit_lists(file, base):
    assert hl.describe_urdf(file, base).audit == hl.audit_urdf(file, base)


@pytest.mark.skipif(find_spec("mujoco") is None, reason="mujoco is not installed")
def test_mjcf_files_are_described_and_audited(tmp_path):
    file = tmp_path / "claw.xml"
    file.write_text(MJCF)
    done = run("hands", file, status=0)
    says(done.stdout, "claw", "far end")
    assert "effort limit" in run("audit", file).stdout


def test_an_audit_is_sorted():
    """The most serious first, in print and as JSON, and no wider than 80 columns."""
    file, share = allegro()
    done = run("audit", file, "--package-dir", share, status=0)
    assert done.stdout.index("Serious") < done.stdout.index("Minor")
    assert max(map(len, done.stdout.splitlines())) <= 80
    doubts = json.loads(run("audit", file, "--json").stdout)["doubts"]
    order = [d["severity"] for d in doubts]
    assert order == sorted(order, key=("serious", "minor", "information").index)


@pytest.mark.parametrize("command", ["hands", "audit"])
@pytest.mark.parametrize("text", ["", "<robot>", "<robot name='r'/>", "<html/>", "x" * 100])
def test_files_that_are_no_hand_are_bad_input(tmp_path, command, text):
    """One sentence on stderr and exit status 2; an audit of a robot without joints has little to say."""
    file = tmp_path / "no.urdf"
    file.write_text(text)
    done = run(command, file)
    if command == "audit" and text == "<robot name='r'/>":
        assert done.exit_code == 0
        return
    assert done.exit_code == 2
    assert done.stderr.startswith("Error: path:")
    assert not done.stdout
