"""`handlcp sweep` from the outside: hands from numbers and from files, names with a star, the table, exit status."""

import json

import pytest

import handlcp as hl
from handlcp.design.sweep.study_file import HandFrom
from tests.support import command

URDF = command.ROOT / "urdf" / "three_finger.urdf"
BRIEF = 'tries = 6\n[objects.ball]\nshape = "sphere"\nradius_m = 0.03\nmass_kg = 0.1\n'
STUDY = """
brief = "brief.toml"
samples = 2
out = "study.csv"

[hand]
fingers = 3
joint_stiffness = 4.0

[space]
palm_radius = { low = 0.04, high = 0.045 }
"*_distal.length" = [0.04, 0.02, -1.0]
"brief.friction" = 0.7
"""


def run(folder, text, *options):
    (folder / "brief.toml").write_text(BRIEF)
    (folder / "study.toml").write_text(text)
    return command.run("sweep", folder / "study.toml", "--serial", *options)


def test_the_best_are_printed_and_the_table_is_written(tmp_path):
    done = run(tmp_path, STUDY, "--best", "1", "--json")
    assert done.exit_code == 0, done.output
    told, study = json.loads(done.stdout), hl.Study.load(tmp_path / "study.csv")
    assert told["best"] == list(study.best(1))
    assert len(study) == 2
    again = run(tmp_path, STUDY)
    assert again.stdout.splitlines()[0].startswith("2 designs")
    assert "study.csv" in again.stdout.replace("\n", "")  # a long path is broken


def test_nothing_that_could_be_evaluated_is_exit_status_1(tmp_path):
    done = run(tmp_path, STUDY.replace("[0.04, 0.02, -1.0]", "-1.0"))
    assert done.exit_code == 1
    assert "2 failed" in done.stdout


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("samples", "sample", "sample"), ('"brief.toml"', "3", "brief"), ("high = 0.045", "hi = 0.045", "palm_radius"),
        ('brief = "brief.toml"', 'brief = "other.toml"', "other.toml"),
        ("palm_radius", "palm_radus", "did you mean 'palm_radius'"), ("fingers", "finger", "did you mean 'fingers'"),
        ("_distal.length", "_dital.length", "distal.length"), ("brief.friction", "brief.mass", "a number of the brief"),
        ("[hand]\nfingers = 3\njoint_stiffness = 4.0", '[hand]\nurdf = "URDF"', "joint_stiffness in N·m/rad"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_exit_status_2(tmp_path, old, new, said):
    done = run(tmp_path, STUDY.replace(old, new.replace("URDF", URDF.as_posix())))
    assert done.exit_code == 2
    assert said in done.stderr.replace("\n", " ")
    assert not list(tmp_path.glob("study.csv*")), "nothing stands in the way of the file when it is right"


def test_a_star_stands_for_all_joints_that_fit():
    hand = hl.finger_hand(3)
    lengths = hl.finger_hand(3, (0.05, 0.03)).at([0.1] * 6).tip_positions
    for make in (HandFrom(None, {"fingers": 3}), HandFrom(hand, {})):
        assert abs(make(**{"*_distal.length": 0.03, "brief.x": 1}).at([0.1] * 6).tip_positions - lengths).max() < 1e-12
    softer = HandFrom(hand, {})(**{"*.stiffness": 2.5})
    assert (softer.joint_stiffness.diagonal() == 2.5).all(), "of joints: fingertips have none"
    with pytest.raises(hl.UnknownName, match="distal"):
        HandFrom(hand, {})(**{"*_dital.length": 0.03})


def test_a_urdf_with_springs_beside_it_goes_on_with_the_sweep_that_python_began(tmp_path):
    hand = hl.Hand.from_urdf(URDF, joint_stiffness=4.0, tip_radius=0.008)
    (tmp_path / "brief.toml").write_text(BRIEF)
    asked = hl.Brief({"ball": hl.Sphere(0.03, mass=0.1)}, tries=6)
    hl.sweep(hand, {"finger_1_distal.length": [-1.0, -2.0]}, asked, samples=2, out=tmp_path / "study.csv")
    begun = (tmp_path / "study.csv").read_bytes()
    head = f'brief = "brief.toml"\nsamples = 2\nout = "study.csv"\n[hand]\nurdf = "{URDF.as_posix()}"\n'
    head += 'joint_stiffness = 4.0\ntip_radius = 0.008\n[space]\n"finger_1_distal.length" = [-1.0, -2.0]'
    done = run(tmp_path, head)
    assert done.exit_code == 1, done.output
    assert (tmp_path / "study.csv").read_bytes() == begun
