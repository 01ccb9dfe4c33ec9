"""Output that closes, fills up or knows no UTF-8; libraries that print; Ctrl-C. Each is a process of its own."""

import json
import os
import pathlib
import signal
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from handlcp.cli import app
from tests.support.command import CUBE, ROOT
from tests.support.processes import hears_ctrl_c

FULL = pathlib.Path("/dev/full")
HANDLCP = [sys.executable, "-m", "handlcp"]
posix = pytest.mark.skipif(os.name != "posix", reason="signals and devices of POSIX")


def run(*arguments, **more):
    """(exit status, stdout, stderr)."""
    env = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "PYTHONIOENCODING")} | more.pop("env", {})
    words = [*HANDLCP, *arguments] if arguments[0] != "-c" else [sys.executable, *arguments]
    usual = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "cwd": ROOT, "timeout": 120, **hears_ctrl_c()}
    done = subprocess.run(words, **usual | more, env=env)
    return done.returncode, done.stdout, done.stderr


@posix
def test_a_terminal_without_utf8_gets_readable_ascii():
    status, out, err = run("effects", env={"PYTHONIOENCODING": "ascii"})
    assert (status, err) == (0, b"")
    text = out.decode("ascii")
    assert "deltaq" in text
    assert "?" not in text
    assert "\\u" not in text


@posix
def test_json_is_the_same_without_utf8():
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    status, out, err = run("effects", "--json", env=plain)
    assert (status, err) == (0, b"")
    assert json.loads(out.decode("ascii")) == json.loads(CliRunner().invoke(app, ["effects", "--json"]).stdout)


@posix
@pytest.mark.skipif(not FULL.exists(), reason="no such device")
def test_a_full_device_is_refused_before_the_work():
    with FULL.open("wb") as full:
        status, _, err = run("accuracy", CUBE, "--seconds", "1000", stdout=full)
    assert status == 2
    assert err.decode().splitlines() == ["Error: output: expected a stream that takes it, got No space left on device"]


LATE = """
import os, sys
from handlcp import cli, scene
keys = scene.keys
scene.keys = lambda: (os.dup2(os.open("/dev/full", os.O_WRONLY), sys.stdout.fileno()), keys())[1]
sys.argv[1:] = ["keys", *sys.argv[1:]]
cli.main()
"""


@posix
@pytest.mark.skipif(not FULL.exists(), reason="no such device")
@pytest.mark.parametrize("options", [(), ("--json",)])
def test_a_disk_that_fills_up_during_the_work_is_one_sentence(options):
    status, _, err = run("-c", LATE, *options)
    assert status == 2
    assert err.decode().splitlines() == ["Error: output: No space left on device"]


@posix
def test_a_reader_that_closes_the_pipe_ends_the_program_without_a_word():
    there, here = os.pipe()
    os.close(there)
    status, _, err = run("keys", stdout=here)
    os.close(here)
    assert (status, err) == (-signal.SIGPIPE, b""), "141 in a shell"


@posix
def test_closed_streams_are_no_crash():
    script = (
        f"'{sys.executable}' -m handlcp hands >&-; echo $?; '{sys.executable}' -m handlcp hands --json 2>&- | wc -l"
    )
    done = subprocess.run(["sh", "-c", script], capture_output=True, text=True, cwd=ROOT)
    status, lines = done.stdout.split()
    assert (status, done.stderr) == ("0", "")
    assert int(lines) > 50


USED = """
import handlcp as hl
hand, ball = hl.example_hand("two_finger"), hl.Sphere(0.03, (0, 0, 0.08), mass=0.1)
grasp = hand.at(hand.close_on(ball)).grasp(ball, 0.8, grip_force=5.0)
grasp.solve().to_json("solution.json")
print("lost")
"""


@posix
def test_all_standard_descriptors_closed_are_no_crash_and_files_hold_what_is_theirs(tmp_path):
    (tmp_path / "used.py").write_text(USED, encoding="utf-8")
    script = (
        f"'{sys.executable}' -m handlcp demo <&- >&- 2>&-; demo=$?; '{sys.executable}' -m handlcp nosuch <&- >&- 2>&-; "
        f"nosuch=$?; '{sys.executable}' used.py <&- >&- 2>&-; echo $demo $nosuch $?"
    )
    where = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(["sh", "-c", script], capture_output=True, text=True, cwd=tmp_path, env=where)
    assert (done.stdout.split(), done.stderr) == (["0", "2", "0"], "")
    assert json.loads((tmp_path / "solution.json").read_text(encoding="utf-8"))["status"] == "SOLVED"
    assert (tmp_path / "handlcp_demo" / "cube.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert (tmp_path / "handlcp_demo" / "cube.png").read_bytes().startswith(b"\x89PNG")


NOISY = """
import ctypes, os, subprocess, sys
from handlcp import cli, scene
keys = scene.keys
def noisy():
    c = ctypes.CDLL(None)
    c.puts(b"noise of a C library")
    c.fflush(None)
    os.write(1, b"noise past all buffers")
    subprocess.run(["echo", "noise of a child"], check=True)
    return keys()
scene.keys = noisy
sys.argv[1:] = ["keys", "--json"]
cli.main()
"""


@posix
def test_nothing_but_json_reaches_stdout():
    status, out, err = run("-c", NOISY)
    assert (status, err) == (0, b"")
    assert json.loads(out)["keys"]


# Ctrl-C while a module is imported, told by a class that every import passes; and where an exception would be swallowed
IMPORT = """
import os, runpy, signal, sys
class Finder:
    def find_spec(self, name, *_):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder())
sys.argv[1:] = ["solve", {scene!r}]
runpy.run_module("handlcp", run_name="__main__")
"""
WORK = """
import os, runpy, signal, sys
from handlcp import scene
class Swallows:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000):
            pass
def load(file):
    Swallows()
scene.load = load
sys.argv[1:] = ["solve", "x"]
runpy.run_module("handlcp", run_name="__main__")
"""
WORKERS = """
import os, runpy, signal, sys, time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from handlcp import scene
def load(file):
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        print(pool.submit(os.getpid).result() > 0, flush=True)
        pool.submit(time.sleep, 1000)
        time.sleep(0.5)
        os.kill(os.getpid(), signal.SIGINT)
scene.load = load
sys.argv[1:] = ["solve", "x"]
runpy.run_module("handlcp", run_name="__main__")
"""


@posix
@pytest.mark.parametrize("module", ["typer", "pinocchio"])
def test_ctrl_c_during_imports_ends_quietly_with_130(module):
    assert run("-c", IMPORT.format(module=module, scene=CUBE)) == (130, b"", b"")


@posix
def test_ctrl_c_ends_quietly_where_python_swallows_exceptions():
    assert run("-c", WORK) == (130, b"", b"")


@posix
def test_ctrl_c_ends_the_processes_that_compute():
    """They have the same stdout, which ends with the last of them."""
    assert run("-c", WORKERS, timeout=30)[0] == 130


POOL = """
import os, runpy, signal, sys, time
from handlcp import scene
from handlcp.grasp.batch.worker_pool import worker_pool
def load(file):
    pool = worker_pool(2)
    assert pool.submit(os.getpid).result() != os.getpid()
    pool.submit(time.sleep, 1000)
    time.sleep(0.5)
    os.killpg(0, signal.SIGINT)
scene.load = load
sys.argv[1:] = ["solve", "x"]
runpy.run_module("handlcp", run_name="__main__")
"""


@posix
def test_ctrl_c_in_a_terminal_ends_a_pool_of_processes_and_nobody_says_a_word():
    """A terminal sends it to all of them. Semaphores that nobody unlinks are a warning on stderr."""
    assert run("-c", POOL, timeout=60, start_new_session=True) == (130, b"", b"")


COMPILES = """
import time
from handlcp.lcp.compiler.compile_policy import warn_not_kept as hint
from handlcp.grasp.batch.worker_pool import worker_pool
def slowly(k):
    hint(f"process {k}")
    time.sleep(0.3)
if __name__ == "__main__":
    before
    list(worker_pool(2).map(slowly, range(6)))
    hint("this process")
"""


@posix
@pytest.mark.parametrize("before", ["pass", "hint('first')"])
def test_of_a_program_and_its_processes_one_says_that_it_compiles(before):
    status, _, err = run("-c", COMPILES.replace("before", before), timeout=60)
    assert (status, err.count(b"compiled code is not kept")) == (0, 1)


@posix
@pytest.mark.parametrize("kernels", ["interpreted", "compiled"])
def test_ctrl_c_during_a_solve_ends_quietly_with_130(kernels, tmp_path):
    env = os.environ | {"HANDLCP_KERNELS": kernels, "HANDLCP_CACHE_DIR": str(tmp_path)}
    command = [*HANDLCP, "accuracy", CUBE, "--seconds", "100"]
    to = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **hears_ctrl_c()}
    with subprocess.Popen(command, cwd=ROOT, env=env, **to) as program:
        with pytest.raises(subprocess.TimeoutExpired):
            program.communicate(timeout=2.0)
        program.send_signal(signal.SIGINT)
        out, err = program.communicate(timeout=60)
    assert (program.returncode, out) == (130, b"")
    assert b"Traceback" not in err


def test_nothing_is_compiled_beforehand_where_nothing_can_be_kept(tmp_path):
    (tmp_path / "file").write_text("no folder")
    env = os.environ | {"HANDLCP_KERNELS": "auto", "HANDLCP_CACHE_DIR": str(tmp_path / "file")}
    done = subprocess.run([*HANDLCP, "warm"], capture_output=True, text=True, cwd=ROOT, env=env, timeout=60)
    assert done.returncode == 2
    assert "HANDLCP_CACHE_DIR: expected a folder that can be written" in done.stderr.replace("\n", " ")
