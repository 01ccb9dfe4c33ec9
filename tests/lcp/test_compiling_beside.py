"""Compiling beside the work: calls go on as Python, compiled code takes over, and the process that compiles goes."""

import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from handlcp.lcp.compiler.compile_policy import compile_in_background, compile_now
from tests.support import kernels as k
from tests.support.processes import hears_ctrl_c

ROOT = pathlib.Path(__file__).parents[2]
PATIENCE = 60.0  # seconds, on a machine that does other things, too


def until(true):
    """Whether it becomes true within the patience."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if true():
            return True
        time.sleep(0.02)
    return False


def is_alive(pid):
    """Whether the process still computes: one that nobody has waited for yet does not."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="asks /proc which processes there are")


def test_calls_go_on_as_python_until_another_process_has_compiled(tmp_path):
    with k.cached_in(tmp_path), k.automatic(), k.compiler_beside() as beside, compile_in_background():
        kernel = k.anew(k.small())
        interpreted = k.run_small(kernel)
        assert not k.is_compiled(kernel)
        assert beside.process is not None, "somebody was asked"
        assert until(lambda: np.array_equal(k.run_small(kernel), interpreted) and k.is_compiled(kernel))
        assert k.loaded(kernel) == 1, "compiled there, not here"
        assert np.array_equal(k.run_small(kernel), interpreted)
        assert kernel.spent == 0.0, "nothing runs as Python any more"


def test_a_kernel_that_has_run_for_long_is_asked_for_without_a_word(tmp_path, capfd):
    with k.cached_in(tmp_path), k.automatic(), k.compiler_beside() as beside:
        kernel = k.anew(k.small())
        kernel.spent = 0.9
        k.run_small(kernel)
        assert beside.process is None
        kernel.spent = 1.5
        k.run_small(kernel)
        assert beside.process is not None
        assert not k.is_compiled(kernel)
    assert capfd.readouterr() == ("", "")


def test_whoever_cannot_go_on_as_python_waits(tmp_path):
    with k.cached_in(tmp_path), k.automatic(), k.compiler_beside() as beside, compile_in_background(), compile_now():
        kernel = k.anew(k.small())
        k.run_small(kernel)
        assert k.is_compiled(kernel)
        assert k.loaded(kernel) == 0
        assert beside.process is None


@pytest.mark.parametrize(("variable", "cores", "file"), [("0", 2, None), ("", 1, None), ("", 2, "no folder")])
def test_where_no_process_may_be_started_the_call_waits(tmp_path, monkeypatch, variable, cores, file):
    monkeypatch.setenv("HANDLCP_COMPILE_BESIDE", variable)
    folder = tmp_path
    if file is not None:
        k.said_afresh(monkeypatch, 60.0)
        (tmp_path / "file").write_text(file, encoding="utf-8")
        folder = tmp_path / "file" / "below"
    with k.cached_in(folder), k.automatic(), k.compiler_beside(cores) as beside, compile_in_background():
        kernel = k.anew(k.small())
        k.run_small(kernel)
        assert k.is_compiled(kernel)
        assert beside.process is None


def test_a_kernel_that_nobody_else_can_import_is_compiled_here(tmp_path):
    @k.decorated
    def double(x):
        return 2.0 * x

    with k.cached_in(tmp_path), k.automatic(), k.compiler_beside() as beside, compile_in_background():
        assert double(4.0) == 8.0
        assert k.is_compiled(double)
        assert beside.process is None


def test_where_the_other_process_fails_the_call_waits(tmp_path, monkeypatch):
    monkeypatch.setattr(k.background_compile, "_SERVER_PROGRAM", "raise SystemExit(1)")
    with k.cached_in(tmp_path), k.automatic(), k.compiler_beside() as beside, compile_in_background():
        kernel = k.anew(k.small())
        k.run_small(kernel)
        assert not k.is_compiled(kernel)
        beside.process.wait(PATIENCE)
        assert until(lambda: k.run_small(kernel).any() and k.is_compiled(kernel))
        assert k.loaded(kernel) == 0


# ---------------------------------------------------------------- one at a time
def test_one_process_compiles_for_a_folder_at_a_time(tmp_path):
    with k.cached_in(tmp_path), k.automatic(), k.compiler_beside() as beside, compile_in_background():
        k.run_small(k.anew(k.small()))
        assert until(k.is_locked)
        with k.compiler_beside() as second:
            kernel = k.anew(k.small())
            k.run_small(kernel)
            assert second.process is None
            assert not k.is_compiled(kernel)
        beside.process.kill()  # an owner that dies leaves the file, and no lock
        assert until(lambda: not k.is_locked())
        with k.compiler_beside() as third:
            kernel = k.anew(k.small())
            k.run_small(kernel)
            assert third.process is not None
            assert until(lambda: k.run_small(kernel).any() and k.is_compiled(kernel))


# ---------------------------------------------------------------- how it ends
PARENT = """
import os, time
import numpy as np
from handlcp.lcp.compiler import background_compile
from handlcp.lcp.compiler.compile_policy import compile_in_background
from tests.support.kernels import large
with compile_in_background():
    large()(np.array([[0.0, 2.0], [4.0, 0.0]]), np.array([2.0, 4.0]), np.zeros(2), np.zeros(2, dtype=np.int64), 1e-12)
print(background_compile._PROCESS.process.pid, flush=True)
{then}
"""


def parent(folder, then):
    """A process that has asked for compiled code, and the id of the one that compiles."""
    environment = os.environ | {"HANDLCP_CACHE_DIR": str(folder), "HANDLCP_KERNELS": "auto"}
    code = "import os\nos.sched_getaffinity = lambda pid: {0, 1}\n" + PARENT.format(then=then)
    started = subprocess.Popen(
        [sys.executable, "-c", code], cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True, **hears_ctrl_c(),
    )  # fmt: skip
    return started, int(started.stdout.readline())


@linux
def test_it_ends_with_a_process_that_is_killed(tmp_path):
    started, compiler = parent(tmp_path, "time.sleep(600)")
    assert is_alive(compiler)
    started.kill()
    started.communicate()
    assert until(lambda: not is_alive(compiler))


@linux
def test_it_ends_with_a_process_that_ends_and_says_nothing(tmp_path):
    started, compiler = parent(tmp_path, "")
    assert (started.communicate()[1], started.returncode) == ("", 0)
    assert not is_alive(compiler)
    assert not [f for f in tmp_path.rglob(".*")], "no file is left half written"


@linux
def test_ctrl_c_reaches_the_work_and_not_the_compiler(tmp_path):
    started, compiler = parent(tmp_path, "time.sleep(600)")
    os.killpg(started.pid, signal.SIGINT)
    said = started.communicate()[1]
    assert said.count("Traceback") == 1
    assert said.rstrip().endswith("KeyboardInterrupt")
    assert not is_alive(compiler)


@linux
def test_a_fork_has_no_hold_on_it(tmp_path):
    started, compiler = parent(tmp_path, "pid = os.fork()\ntime.sleep(600 if pid == 0 else 0)\nprint(pid, flush=True)")
    fork = int(started.stdout.readline())
    try:
        started.wait(PATIENCE)
        assert is_alive(fork)
        assert until(lambda: not is_alive(compiler))
    finally:
        os.kill(fork, signal.SIGKILL)
        started.communicate()
