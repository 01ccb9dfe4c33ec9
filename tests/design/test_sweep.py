"""A sweep: the same rows wherever they are computed, and a reason where a design fails."""

import os
import signal
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest

import handlcp as hl
from handlcp.design.space import Space
from handlcp.design.sweep.cells import MOST, cells_of
from handlcp.design.sweep.table import write_table
from tests.design.sweeps import NO_HANDS, bits, brief, no_hand, run, run_without_hands, stopped_after
from tests.support.browser import opened


@pytest.fixture(scope="module")
def study():
    return run()


# ---------------------------------------------------------------- The same rows.


def test_processes_change_no_bit_of_designs_that_fail(tmp_path):
    out = tmp_path / "study.csv"
    assert bits(run_without_hands(out, samples=20, executor=None)) == bits(run_without_hands(None, samples=20))
    assert bits(hl.Study.load(out)) == bits(run_without_hands(None, samples=20))


@pytest.mark.long
def test_processes_change_no_bit_and_only_the_table_is_left(study, tmp_path):
    out = tmp_path / "study.parquet"
    assert bits(run(out, None)) == bits(study) == bits(hl.Study.load(out))
    assert [file.name for file in tmp_path.iterdir()] == [out.name]


@pytest.mark.parametrize("end", ["parquet", "csv"])
def test_words_stay_words_and_numbers_numbers(tmp_path, end):
    space = {"word": ["3", ""], "whole": [1, 2], "number": (1.0, 2.0), "switch": [True, False], "fixed": "5"}

    def fails(**values):
        raise RuntimeError('a "quoted", word\nand a line')

    asked = hl.Brief(hl.Sphere(0.03))
    before = hl.sweep(fails, space, asked, samples=8, out=tmp_path / f"a.{end}", executor="serial")
    after = hl.Study.load(tmp_path / f"a.{end}", fails, asked)
    assert bits(after) == bits(before)
    assert [type(after.columns[name][0]) for name in space] == [str, int, float, bool, str]
    with pytest.raises(hl.InputError, match="differs in how hands are made"):
        hl.Study.load(tmp_path / f"a.{end}", no_hand, asked)


@pytest.mark.long
def test_no_row_is_worse_than_an_evaluation_of_its_own():
    """The grasp of the longer fingers, brought to the shorter ones, holds three times less than what they can."""
    lengths = [0.05, 0.044]
    asked = hl.Brief({"ball": hl.Sphere(0.03, mass=0.1)}, friction=0.7, tries=4)

    def fingers(length):
        return hl.finger_hand(3, (length, 0.04), joint_stiffness=3.5)

    found = hl.sweep(fingers, {"length": lengths}, asked, "grid", 2, executor="serial", progress=False)
    for row, length in zip(found, lengths, strict=True):
        fresh = hl.evaluate(fingers(length), asked)
        assert row["holds"] >= fresh.holds
        assert row["payload_kg"] >= fresh.payload * (1.0 - 1e-9)
        assert row["factor"] >= fresh.factor * (1.0 - 1e-9)


@pytest.mark.parametrize("end", ["parquet", "csv"])
def test_a_study_whose_rows_began_from_other_grasps_alone_says_that_it_is_old(tmp_path, end):
    out = tmp_path / f"old.{end}"
    made = run_without_hands(None, samples=4)
    assert "Beware" not in str(made)
    old = {key: value for key, value in made.sweep.items() if key != "rows"}
    write_table(out, old, list(made))
    assert str(hl.Study.load(out)).startswith("Beware: its rows are old")
    with pytest.raises(hl.InputError, match="its rows are old"):
        run_without_hands(out, samples=4)
    with pytest.raises(hl.InputError, match="its rows are old"):
        hl.Study.load(out, no_hand, hl.Brief(hl.Sphere(0.03)))


def test_the_page_shows_the_hand_of_a_design_on_the_front_with_the_numbers_of_its_row(study, tmp_path):
    front = study.pareto()
    file = study.page(tmp_path / "study.html", title="Three fingers")
    last = front.columns["design"][-1]
    page = opened(file, tmp_path, str(last))
    assert page.told.get("error") is None
    assert int(page.told["triangles"]) > 500
    assert page.words["number"] == str(last)
    assert f"{front.columns['payload_kg'][-1]:.4g}" in page.words["numbers"]
    assert f"{front.columns['payload_kg'][-1]:.4g}" in page.words["objects"]  # found again, by the hand made again
    assert "finger_1_tip" in page.words["contacts"]


def test_a_design_that_fails_is_a_row_with_its_reason(study):
    failed = study.failed
    assert 0 < len(failed) < len(study)
    assert set(failed.columns["error"]) == {"ValueError: too short"}
    assert failed.columns["payload_kg"] == [None] * len(failed)
    assert "Most often: ValueError: too short" in " ".join(str(study).split())


def test_a_hand_is_varied_by_the_names_that_the_brief_does_not_take():
    hand = hl.example_hand("three_finger", joint_stiffness=4.0)
    space = {"finger_1_distal.stiffness": (3.0, 5.0), "friction": 0.7}
    found = hl.sweep(hand, space, brief, samples=1, executor="serial")
    assert found.columns["error"] == [None]
    with pytest.raises(hl.UnknownName, match=r"did you mean 'finger_1_distal.stiffness'"):
        hl.sweep(hand, {"finger_1_distal.stifness": (3.0, 5.0), "friction": 0.7}, brief, samples=1)


def test_a_design_that_ends_the_program_is_a_row_and_ctrl_c_is_not():
    def exits(x, kind):
        sys.exit(f"no {kind}")

    assert set(run_without_hands(None, make=exits, samples=4).columns["error"]) == {
        "SystemExit: no a",
        "SystemExit: no b",
    }

    def interrupted(x, kind):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_without_hands(None, make=interrupted, samples=4)


@pytest.mark.parametrize("end", ["parquet", "csv"])
def test_what_nothing_ends_is_infinite_in_tables(tmp_path, end):
    rows = [{"design": k, "x": 0.5, "factor": factor} for k, factor in enumerate((1.5, float("inf"), None))]
    write_table(tmp_path / f"a.{end}", {"space": {"x": {"low": 0.0, "high": 1.0}}}, rows)
    assert hl.Study.load(tmp_path / f"a.{end}").columns["factor"] == [1.5, float("inf"), None]


def test_any_executor_will_do_and_is_left_open(study):
    with ThreadPoolExecutor(1) as threads:
        assert bits(run_without_hands(None, executor=threads)) == bits(run_without_hands(None))
        assert threads.submit(int, 3).result() == 3


@pytest.mark.long
def test_a_dask_worker_killed_midway_changes_no_bit(tmp_path):
    distributed = pytest.importorskip(
        "distributed", reason="Dask is not installed here: pip install '.[test]' brings it"
    )
    alone = run(samples=12)
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=tmp_path
    )
    killed = []
    with cluster, distributed.Client(cluster) as client:
        workers = list(client.run(os.getpid).values())

        def kill(done, total):
            if done and not killed:
                killed.append(workers[0])
                os.kill(workers[0], signal.SIGKILL)

        many = run(tmp_path / "study.parquet", client, samples=12, progress=kill)
    assert killed
    assert bits(many) == bits(alone)
    assert bits(hl.Study.load(tmp_path / "study.parquet")) == bits(alone)


# ---------------------------------------------------------------- Another sweep, and what cannot be.


@pytest.mark.parametrize("stopped", [False, True])
@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"samples": 101}, r"the samples \(100, now 101\)"), ({"seed": 1}, r"the seed \(0, now 1\)"),
        ({"sampling": "sobol"}, r"the sampling \('lhs', now 'sobol'\)"),
        ({"make": lambda x, kind: None}, "how hands are made"),
        ({"space": dict(reversed(NO_HANDS.items()))}, r"the space \(another order\)"),
        ({"space": NO_HANDS | {"kind": ["a", "c"]}}, r"the space \(kind: \['a', 'b'\], now \['a', 'c'\]\)"),
    ],
)  # fmt: skip
def test_another_sweep_is_not_written_into_the_same_file(tmp_path, changed, said, stopped):
    out = tmp_path / "study.csv"
    stopped_after(out, 20) if stopped else run_without_hands(out)
    before = {f: f.read_bytes() for f in tmp_path.iterdir()}
    with pytest.raises(hl.InputError, match=f"differs in {said}"):
        run_without_hands(out, **changed)
    assert {f: f.read_bytes() for f in tmp_path.iterdir()} == before


class _Maker:
    def __init__(self, stiffness):
        self.stiffness = stiffness

    def __call__(self, length):
        return made_of(length, self.stiffness)


def made_of(length, stiffness):
    return hl.finger_hand(3, (length, 0.04), joint_stiffness=stiffness)


def _radius(tip_radius):
    return hl.finger_hand(3, (0.05, 0.04), tip_radius=tip_radius)


@pytest.mark.parametrize(
    ("kept", "space", "before", "now"),
    [
        ("partial", "length", partial(made_of, stiffness=2.0), partial(made_of, stiffness=8.0)),
        ("object", "length", _Maker(2.0), _Maker(8.0)),
        ("hand", "finger_1_distal.length", _radius(0.008), _radius(0.004)),
        ("links", "finger_1_distal.length", hl.finger_hand(), hl.finger_hand(link_radius=0.006, tip_radius=0.008)),
        ("varied", "finger_1_distal.length", _radius(0.008), _radius(0.008).vary({"tip_radius": 0.004})),
    ],
)
def test_hands_that_are_made_otherwise_are_another_sweep(tmp_path, kept, space, before, now):
    """Each of them would answer with rows of the other."""

    def run(make):
        asked = hl.Brief(hl.Sphere(0.0005, mass=0.1), tries=1)
        return hl.sweep(
            make, {space: (0.038, 0.042)}, asked, samples=1, out=tmp_path / f"{kept}.csv", executor="serial"
        )

    rows = run(before).columns
    assert run(before).columns == rows
    with pytest.raises(hl.InputError, match="differs in how hands are made"):
        run(now)


def test_another_brief_is_another_sweep_and_the_same_one_made_again_is_not(tmp_path):
    def with_mass(mass):
        asked = hl.Brief({"ball": hl.Sphere(0.03, mass=mass), "box": hl.Box((0.1, 0.1, 0.1), mass=1)}, friction=0.5)
        return hl.sweep(no_hand, NO_HANDS, asked, samples=2, out=tmp_path / "a.csv", executor="serial")

    with_mass(0.1)
    with_mass(0.1)
    with pytest.raises(hl.InputError, match="differs in the brief"):
        with_mass(0.2)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"sampling": "random"}, "sampling"), ({"samples": 0}, "samples"), ({"samples": None}, "how many designs"),
        ({"executor": 3}, "executor"),
        ({"out": "study.xlsx"}, r"\.parquet or \.csv"), ({"out": "nowhere/study.csv"}, "a folder that exists"),
        ({"space": {"z": (0, 1)}}, "make: expected a function of z"), ({"brief": 3}, "brief: expected a Brief"),
        ({"space": {**NO_HANDS, "z": 1}}, "space: expected parameters that make or brief takes, got z"),
        ({"space": {**NO_HANDS, "holds": 1}}, "not columns of the outcome, got holds"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_named_before_anything_is_made(given, said):
    words = {"make": no_hand, "space": NO_HANDS, "brief": hl.Brief(hl.Sphere(0.03)), "samples": 2, "executor": "serial"}
    with pytest.raises(hl.InputError, match=said):
        hl.sweep(**{**words, **given})


def test_another_file_is_not_taken_for_a_table(tmp_path):
    for name in ("a.parquet", "a.csv"):
        (tmp_path / name).write_text("x,y\n1,2\n")
        with pytest.raises(hl.InputError, match="which is another file"):
            run_without_hands(tmp_path / name)
    with pytest.raises(hl.InputError, match="does not exist"):
        hl.Study.load(tmp_path / "b.csv")


# ---------------------------------------------------------------- Cells.


def test_every_design_is_in_one_cell_with_those_near_it_that_are_hands_of_the_same_kind():
    space = Space({"a": (0, 1), "b": (0, 1), "fingers": [3, 4], "pad": ["soft", "hard"], "friction": [0.3, 0.5, 0.7]})
    cube = space.sobol(1024)
    cells = cells_of(space, cube)
    assert sorted(k for cell in cells for k in cell) == list(range(1024))
    assert max(map(len, cells)) <= MOST
    for cell in cells:
        own = cube[cell]
        assert len({(u[2] < 0.5, u[3] < 0.5) for u in own}) == 1
        away = ((own[:, [0, 1, 4]] - (own[:, [0, 1, 4]].min(axis=0) + own[:, [0, 1, 4]].max(axis=0)) / 2) ** 2).sum(
            axis=1
        )
        assert (away[1:] >= away[:-1]).all()


@pytest.mark.long
def test_a_design_that_ends_its_process_is_a_row_and_the_others_go_on():
    def deadly(x, kind):
        if x > 0.9:
            os.kill(os.getpid(), signal.SIGKILL)
        no_hand(x, kind)

    rows = list(run_without_hands(None, make=deadly, samples=20, executor=None))
    died = [row["design"] for row in rows if "the process that evaluated it ended" in row["error"]]
    assert died == [row["design"] for row in rows if row["x"] > 0.9]
    assert len(died) == 2
    assert len(rows) == 20
