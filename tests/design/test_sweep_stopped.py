"""A sweep that is stopped, by whatever: what was done is kept, damaged rows are done again, one run writes at once."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import handlcp as hl
from handlcp.design.sweep.journal import beside
from tests.design.sweeps import bits, no_hand, run_without_hands, stopped_after

ROOT = Path(__file__).parents[2]
SLOWLY = """
import time
from tests.design.sweeps import no_hand, run_without_hands

def slow(x, kind):
    time.sleep({pause})
    no_hand(x, kind)

run_without_hands({out!r}, make=slow, executor={executor!r})
"""


def killed_after(out, seconds, executor="serial", pause=0.01):
    """The program of a sweep is killed after so many seconds with its journal there; whether it was killed."""
    code = SLOWLY.format(out=str(out), executor=executor, pause=pause)
    own = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    with subprocess.Popen([sys.executable, "-c", code], env=own, cwd=ROOT, start_new_session=True) as program:
        while program.poll() is None and not beside(out).exists():
            time.sleep(0.01)
        time.sleep(seconds)
        if ended := program.poll() is not None:
            assert program.returncode == 0
        else:
            os.killpg(program.pid, signal.SIGKILL)
    return not ended


def test_a_program_that_was_killed_goes_on_with_what_is_missing(tmp_path):
    out = tmp_path / "study.parquet"
    assert killed_after(out, 0.3)
    assert not out.exists()
    so_far = hl.Study.load(out)
    assert 0 < len(so_far) < 100
    done = []

    def counted(x, kind):
        done.append(x)
        no_hand(x, kind)

    before, now = (json.loads(line) for line in _headers(tmp_path, counted))
    beside(out).write_text(beside(out).read_text().replace(before["make"], now["make"]))
    again = run_without_hands(out, make=counted)
    assert bits(again) == bits(run_without_hands(None))
    assert len(done) <= 100 - len(so_far) + 2 * 8  # the heads of two cells once more


def _headers(folder, function):
    """The first lines of the journal of a sweep that was killed, and of one with another function."""
    run_without_hands(folder / "other.csv", make=function, samples=1)
    return (folder / "study.parquet.rows").read_text().splitlines()[0], (folder / "other.csv.json").read_text()


@pytest.mark.long
@pytest.mark.parametrize("executor", ["serial", None])
def test_killed_ten_times_at_random_every_row_is_there_once(tmp_path, executor):
    out, dice = tmp_path / "study.parquet", random.Random(3)
    kills = sum(killed_after(out, dice.uniform(0.0, 0.5), executor, 0.03) for _ in range(10))
    assert kills >= 3
    while killed_after(out, 20.0, executor, 0.03):
        pass
    there = hl.Study.load(out)
    assert bits(there) == bits(run_without_hands(None))
    assert there.columns["design"] == list(range(100))


@pytest.mark.parametrize("cut", [1, 10, 200])
def test_a_torn_last_line_is_computed_again(tmp_path, cut):
    out = tmp_path / "study.csv"
    stopped_after(out, 20)
    journal = beside(out)
    journal.write_bytes(journal.read_bytes()[:-cut])
    assert bits(run_without_hands(out)) == bits(run_without_hands(None))


def test_a_journal_cut_anywhere_in_its_first_line_begins_anew(tmp_path):
    out = tmp_path / "study.csv"
    beside(out).write_bytes(b'{"handlcp": "0.')
    assert bits(run_without_hands(out)) == bits(run_without_hands(None))


def test_a_damaged_journal_is_refused(tmp_path):
    out = tmp_path / "study.csv"
    stopped_after(out, 20)
    journal = beside(out)
    journal.write_bytes(journal.read_bytes().replace(b"\n", b"\x00\n", 3))
    with pytest.raises(hl.InputError, match="damaged in line 1"):
        run_without_hands(out)


def test_a_damaged_row_is_computed_again_in_the_journal_and_in_the_table(tmp_path):
    out = tmp_path / "study.csv"
    stopped_after(out, 20)
    first, row, *rows = beside(out).read_text().split("\n")
    beside(out).write_text("\n".join([first, row.replace("a 0.", "b 0.").replace("b 0.", "c 0."), *rows]))
    whole = bits(run_without_hands(None))
    assert bits(run_without_hands(out)) == whole
    first, row, *rows = out.read_text().split("\n")
    out.write_text("\n".join([first, row.replace("0.", "0.1", 1), *rows]))
    assert bits(run_without_hands(out)) == whole == bits(hl.Study.load(out))


def test_a_file_has_one_run_at_a_time(tmp_path):
    out, said = tmp_path / "study.csv", []

    def again(done, total):
        if not said:
            with pytest.raises(hl.InputError, match="another run is writing now") as caught:
                run_without_hands(out)
            said.append(caught.value.argument)

    run_without_hands(out, progress=again)
    assert said == ["out"]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["study.csv", "study.csv.json"]


def test_what_is_there_when_it_is_interrupted_is_kept(tmp_path):
    out = tmp_path / "study.parquet"
    assert len(stopped_after(out, 20)) >= 20
    assert not out.exists()
    assert bits(run_without_hands(out)) == bits(run_without_hands(None))
    assert not beside(out).exists()


_GROWS = """
import time, warnings
from handlcp.grasp.batch.worker_pool import worker_pool

GROW = "globals().setdefault('held', bytearray(b'x' * 500_000_000)) and __import__('time').sleep(2)"
warnings.simplefilter("error")
pool = worker_pool(2)
for job in [pool.submit(time.sleep, 1.2) for _ in range(4)]:
    job.result()  # from here on growth is measured
jobs = [pool.submit(eval, GROW), *[pool.submit(time.sleep, 1.5) for _ in range(8)]]
for job in jobs:
    job.result(timeout=30)
print("all done")
"""


@pytest.mark.long  # it sleeps until its size is measured
def test_a_process_that_is_replaced_for_its_size_holds_nothing_up_where_warnings_are_errors():
    pytest.importorskip("psutil", reason="without it loky measures no size")
    own = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run([sys.executable, "-c", _GROWS], capture_output=True, text=True, env=own, timeout=110)
    assert done.stdout == "all done\n", done.stderr[-2000:]
