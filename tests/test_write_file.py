"""Files are written whole or not at all: full disks, links, permissions, pipes, and what stdout was redirected to."""

import os
import stat
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest

import handlcp as hl
from handlcp.design.sweep.journal import beside
from handlcp.write_file import check_destination, write_file
from tests.design.sweeps import bits, run_without_hands
from tests.support.processes import on_a_full_disk

ROOT = Path(__file__).parents[1]
posix = pytest.mark.skipif(os.name != "posix", reason="links, permissions, pipes and limits of POSIX")


def listed(folder):
    return sorted(p.name for p in folder.iterdir())


# ---------------------------------------------------------------- full disks
EVERY = """
from pathlib import Path
import handlcp as hl
from handlcp.studies.accuracy import accuracy_cost
from handlcp.design.sweep.table import write_table
from handlcp.viz.picture import figure

figure.PICTURE_DPI = 30  # drawn at once
folder = Path({folder!r})
hand = hl.example_hand("three_finger", joint_stiffness=6.0)
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)
solution, cost = grasp.solve(), accuracy_cost(grasp, seconds=0.1)
brief = hl.Brief(hl.Sphere(0.03, mass=0.1))
rows = [dict(design=k, x=0.1 * k) for k in range(300)]
sweep = dict(space=dict(x=[0.0, 1.0]))
writers = {{
    "a.json": solution.to_json,
    "a.toml": brief.to_toml,
    "a.urdf": lambda file: hl.finger_hand(3, (0.05, 0.04), joint_stiffness=3.0, file=file),
    "a.csv": cost.to_csv,
    "table.csv": lambda file: write_table(file, sweep, rows),
    "table.parquet": lambda file: write_table(file, sweep, rows),
    "a.png": solution.plot,
    "a.pdf": solution.plot,
    "a.html": solution.page,
    "a.npz": lambda file: (
        file.unlink(missing_ok=True), hl.reliability(grasp, dict(friction=0.1), 64, workers=1, resume=file)
    ),
}}
for name, write in writers.items():
    write(folder / name)
before = {{p.name: p.read_bytes() for p in folder.iterdir()}}
room(20)
for name, write in writers.items():
    if name == "a.npz":
        continue
    try:
        write(folder / name)
    except hl.InputError as error:
        assert str(folder / name) in str(error), error
        assert "a file that can be written" in str(error), error
        print(name)
assert before == {{p.name: p.read_bytes() for p in folder.iterdir()}}
try:
    writers["a.npz"](folder / "a.npz")
except hl.InputError as error:
    assert error.argument == "resume", error
    print("a.npz")
assert sorted(p.name for p in folder.iterdir()) == sorted({{*before}} - {{"a.npz"}})
"""


@posix
def test_a_full_disk_leaves_the_earlier_file_of_every_kind_and_says_which(tmp_path):
    for package in ("matplotlib", "trimesh", "pyarrow"):
        pytest.importorskip(package)
    said = on_a_full_disk(EVERY.format(folder=str(tmp_path)))
    kinds = ["a.json", "a.toml", "a.urdf", "a.csv", "table.csv", "table.parquet", "a.png", "a.pdf", "a.html"]
    assert said.split() == [*kinds, "a.npz"]


SWEEP = """
import handlcp as hl
from tests.design.sweeps import run_without_hands
room(4000)
try:
    run_without_hands({out!r})
except hl.InputError as error:
    print(error)
"""


@posix
def test_a_sweep_that_fills_the_disk_says_so_keeps_whole_rows_and_goes_on(tmp_path):
    out = tmp_path / "study.csv"
    said = on_a_full_disk(SWEEP.format(out=str(out)))
    assert said.startswith(f"out: expected a file that can be written, got '{beside(out)}': ")
    assert said.count("\n") == 1
    assert beside(out).read_bytes().endswith(b"\n"), "what did not fit is cut off"
    assert 0 < len(hl.Study.load(out)) < 100
    assert bits(run_without_hands(out)) == bits(run_without_hands(None))
    assert listed(tmp_path) == ["study.csv", "study.csv.json"]


@posix
def test_an_error_is_not_hidden_by_one_of_closing_the_journal(tmp_path):
    """A disk of a network may say only as a file is closed that it is full; here the file is closed already."""
    out = tmp_path / "study.csv"

    def broken(done, total):
        for number in map(int, os.listdir("/dev/fd")):
            with suppress(OSError):
                if os.path.samestat(os.fstat(number), os.stat(beside(out))):
                    os.close(number)
        raise ValueError("the first")

    with pytest.raises(ValueError, match="the first"):
        run_without_hands(out, progress=broken)


# ---------------------------------------------------------------- what a plainly opened file would do
@posix
@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_a_new_file_has_the_permissions_that_the_umask_leaves(mask, tmp_path):
    before = os.umask(mask)
    try:
        write_file("path", tmp_path / "a.json", "{}")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.json").stat().st_mode) == 0o666 & ~mask


@posix
def test_a_file_keeps_its_permissions(tmp_path):
    file = tmp_path / "a.json"
    file.write_text("old")
    file.chmod(0o640)
    write_file("path", file, "new")
    assert (file.read_text(), stat.S_IMODE(file.stat().st_mode)) == ("new", 0o640)
    assert listed(tmp_path) == ["a.json"]


@posix
@pytest.mark.parametrize("there", [True, False])
def test_a_link_stays_and_what_it_points_to_is_written(there, tmp_path):
    (tmp_path / "far").mkdir()
    target, link = tmp_path / "far" / "a.json", tmp_path / "a.json"
    if there:
        target.write_text("old")
    link.symlink_to(Path("far") / "a.json")
    write_file("path", link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert listed(target.parent) == ["a.json"]


@posix
def test_links_in_a_circle_are_refused_and_stay(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    for check in (check_destination, lambda *given: write_file(*given, "new")):
        with pytest.raises(hl.InputError, match="a file that can be written"):
            check("path", tmp_path / "a")
    assert (tmp_path / "a").is_symlink()


@posix
@pytest.mark.skipif(os.name == "posix" and os.getuid() == 0, reason="root may write anything")
def test_a_file_that_may_not_be_written_is_refused_and_stays(tmp_path):
    file = tmp_path / "a.json"
    file.write_text("old")
    file.chmod(0o444)
    with pytest.raises(hl.InputError, match="Permission denied"):
        write_file("path", file, "new")
    assert file.read_text() == "old"


@pytest.mark.parametrize("file", [5, None, {}, b"a", "a\0b"])
def test_what_is_no_name_of_a_file_is_refused(file):
    for check in (check_destination, lambda *given: write_file(*given, "new")):
        with pytest.raises(hl.InputError, match="path: expected"):
            check("path", file)


def test_a_folder_or_none_is_refused_and_nothing_is_left(tmp_path):
    for file in (tmp_path, tmp_path / "none" / "a.json"):
        for check in (check_destination, lambda *given: write_file(*given, "new")):
            with pytest.raises(hl.InputError, match=r"path: expected a file (that can be written|in a folder)"):
                check("path", file)
    assert listed(tmp_path) == []


def test_looking_whether_a_file_can_be_written_leaves_no_trace(tmp_path):
    (tmp_path / "a").write_text("old")
    for name in ("a", "b"):
        assert check_destination("path", tmp_path / name) == tmp_path / name
    assert listed(tmp_path) == ["a"]
    assert (tmp_path / "a").read_text() == "old"


def test_half_a_pair_of_surrogates_is_written_as_its_escape(tmp_path):
    """As the name of a file that is no UTF-8 brings one along."""
    assert write_file("path", tmp_path / "a", 'a "\udcff"').read_bytes() == b'a "\\udcff"'


# ---------------------------------------------------------------- places that are no files
STDOUT = """
import handlcp as hl
print("before")
hl.Brief(hl.Sphere(0.03, mass=0.1)).to_toml({place!r})
print("after")
"""


@posix
@pytest.mark.parametrize(
    ("place", "to"),
    [
        ("/dev/stdout", "pipe"),
        pytest.param("/dev/stdout", "file", marks=pytest.mark.long),
        ("/dev/fd/1", "appended"),
    ],
)
def test_stdout_gets_a_file_between_what_is_printed_before_and_after(place, to, tmp_path):
    file = tmp_path / "out.txt"
    file.write_text("first\n")
    with file.open("a" if to == "appended" else "w") as out:
        given = subprocess.PIPE if to == "pipe" else out
        code = STDOUT.format(place=place)
        done = subprocess.run([sys.executable, "-c", code], stdout=given, check=True, cwd=ROOT, timeout=60)
    said = done.stdout.decode() if to == "pipe" else file.read_text()
    lines = said.splitlines()
    assert [line for line in lines if line in ("first", "before", "after")] == [
        *(["first"] if to == "appended" else []), "before", "after",
    ]  # fmt: skip
    assert lines[-1] == "after"
    assert "radius_m = 0.03" in said
    assert listed(tmp_path) == ["out.txt"]


@posix
def test_a_named_pipe_stays_one_and_its_reader_gets_everything(tmp_path):
    pipe, got = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    content = b"x" * 200_000  # more than a pipe holds
    write_file("path", check_destination("path", pipe), content)
    reader.join(30)
    assert got == [content]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@posix
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no such device")
def test_devices_are_written_in_place(tmp_path):
    write_file("path", "/dev/null", "gone")
    with pytest.raises(hl.InputError, match="No space left on device"):
        write_file("path", "/dev/full", "new")
    with pytest.raises(hl.InputError, match="No space left on device"):
        check_destination("path", "/dev/full")


CUBE = str(ROOT / "examples" / "cube_three_fingers.toml")


@posix
def test_the_command_line_writes_a_file_to_stdout_too():
    command = [sys.executable, "-m", "handlcp", "accuracy", CUBE, "--seconds", "0.1", "--csv", "/dev/stdout"]
    done = subprocess.run(command, stdout=subprocess.PIPE, check=True, cwd=ROOT, timeout=120)
    assert done.stdout.decode().startswith("method,")
