"""How far long calls are: one line on a terminal, after two seconds, gone at the end, and nowhere else."""

import io
import os
import pty
import re
import subprocess
import sys
import threading

import numpy as np
import pytest

import handlcp as hl
from handlcp import scene as scenes
from handlcp.progress import (
    REDRAW_SECONDS,
    SILENT_SECONDS,
    TimeBudgetError,
    exclude_from_budget,
    report_progress,
    time_budget,
    track_progress,
)
from tests.design.hands import pinch as levers
from tests.support.command import CUBE, run
from tests.support.progress import NINE_SECONDS, Clock, Terminal, terminal_with
from tests.support.squeezed import cube


def count_to(number, clock, each, total=None):
    with track_progress("parts", total) as say:
        for _ in range(number):
            clock.now += each
            say(1)


def test_a_call_that_takes_long_has_a_line_that_is_gone_when_it_ends(monkeypatch):
    clock = Clock()
    terminal = terminal_with(monkeypatch, clock)
    count_to(10, clock, 0.3, 10)
    assert list(dict.fromkeys(re.findall(r"parts (\d+)/10", terminal.text))) == ["7", "8", "9", "10"]
    assert terminal.left.strip() == ""


def test_a_short_call_draws_nothing(monkeypatch):
    clock = Clock()
    terminal = terminal_with(monkeypatch, clock)
    count_to(10, clock, 0.99 * SILENT_SECONDS / 10)
    assert terminal.getvalue() == ""


def test_it_is_drawn_ten_times_a_second_at_most(monkeypatch):
    clock = Clock()
    terminal = terminal_with(monkeypatch, clock)
    count_to(1000, clock, 0.01)  # ten seconds, eight of them with a line
    drawn = len(re.findall(r"parts \d+", terminal.text))
    assert 0.8 * 8 / REDRAW_SECONDS <= drawn <= 1.01 * 8 / REDRAW_SECONDS + 2  # once more as it ends


class Pipe(io.StringIO):
    """Stderr that is none."""


@pytest.mark.parametrize("why", ["pipe", "off", "False", "function", "thread", "none"])
def test_nothing_is_drawn_where_nobody_looks_or_nobody_wants_it(why, monkeypatch):
    clock, seen = Clock(), []
    terminal = terminal_with(monkeypatch, clock, Pipe if why == "pipe" else Terminal)
    if why == "off":
        monkeypatch.setenv("HANDLCP_PROGRESS", "off")
    if why == "none":
        monkeypatch.setattr("sys.stderr", None)
    asked = {"False": False, "function": lambda done, total: seen.append((done, total))}.get(why)

    def call():
        with track_progress("parts", 3, asked) as say:
            for _ in range(3):
                clock.now += 5.0
                count_to(2, clock, 5.0)  # nor is a call inside it
                say(1)

    if why == "thread":
        worker = threading.Thread(target=call)
        worker.start()
        worker.join()
    else:
        call()
    assert terminal.getvalue() == ""
    assert seen == ([(1, 3), (2, 3), (3, 3)] if why == "function" else [])
    assert clock.now == 100.0 + 45.0


def test_what_ends_a_call_early_ends_its_line_and_the_next_call_has_its_own(monkeypatch):
    clock = Clock()
    terminal = terminal_with(monkeypatch, clock)

    def stopped():
        with track_progress("parts") as say:
            clock.now += 3.0
            say(1)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert "parts 1" in terminal.text
    assert terminal.left.strip() == ""
    assert terminal.getvalue().count("\x1b[?25l") == terminal.getvalue().count("\x1b[?25h") == 1  # the cursor is back
    before = len(terminal.getvalue())
    count_to(1, clock, 1.0)
    assert len(terminal.getvalue()) == before
    report_progress("of nothing")
    assert len(terminal.getvalue()) == before


def test_a_variable_that_says_nothing_is_refused(monkeypatch):
    terminal_with(monkeypatch, Clock())
    monkeypatch.setenv("HANDLCP_PROGRESS", "no")
    with pytest.raises(hl.InputError, match='HANDLCP_PROGRESS: expected "auto" or "off"'):
        count_to(1, Clock(), 0.0)


# ---------------------------------------------------------------- the calls and commands that take long
def points():
    sides = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), 0.5, name=n) for s, n in ((-1, "left"), (1, "right"))]
    return hl.Grasp(sides, (0, 0, -0.5, 0, 0, 0), flexibility=1e-3, preload=2e-3)


CALLS = {
    "directions": lambda _: hl.envelope(points(), ("yz", 200)),
    "samples": lambda _: hl.reliability(points(), {"friction": 0.1}, 512),
    "grasps": lambda _: hl.solve_many([points()] * 40, workers=1),
    "grips tried": lambda folder: levers(folder).required_torque(tolerance=0.5),
    "looking for a grasp": lambda _: hl.find_grasp(
        hl.example_hand("three_finger", joint_stiffness=6.0), hl.Sphere(0.0005, mass=0.001), tries=1, throw=False
    ),
    "following the loading": lambda _: cube().follow(steps=8),
    "checking": lambda _: cube().replace(friction=0.28).check(),
    "load limit": lambda _: cube().load_limit((0, 1, 0, 0, 0, 0)),
}  # fmt: skip


@pytest.mark.parametrize("what", CALLS)
def test_each_long_call_says_how_far_it_is(what, monkeypatch, tmp_path):
    terminal = terminal_with(monkeypatch, Clock(each=1.1 * SILENT_SECONDS))
    CALLS[what](tmp_path)
    assert what in terminal.text
    assert terminal.left.strip() == ""


def test_progress_false_silences_a_call(monkeypatch, tmp_path):
    terminal = terminal_with(monkeypatch, Clock(each=0.3))
    hl.envelope(cube(), np.eye(3), progress=False)
    levers(tmp_path).required_torque(tolerance=0.5, progress=False)
    assert terminal.getvalue() == ""
    with pytest.raises(hl.InputError, match="progress"):
        levers(tmp_path).required_torque(progress=3)


def test_a_command_leaves_the_line_to_the_call_that_it_makes(monkeypatch):
    """The runner's stderr is no terminal; that of the process is, where the call is made alone."""
    done = run("envelope", CUBE, "--directions", "xz,24", "--adaptive", "0", "--faces", "8", "--fixed", width=None)
    terminal = terminal_with(monkeypatch, Clock(each=1.1 * SILENT_SECONDS))
    env = hl.envelope(scenes.load(CUBE).build(), ("xz", 24), faces=8, adaptive=0, geometry="fixed")
    assert "directions 24/24" in terminal.text
    assert str(env) in done.stdout
    assert "directions" not in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
def test_on_a_pseudo_terminal_the_line_comes_and_goes():
    """Another process, whose stderr is one, with a clock that runs ahead."""
    ours, theirs = pty.openpty()
    env = {**os.environ, "TERM": "xterm", "COLUMNS": "80", "HANDLCP_PROGRESS": "auto"}
    program = [sys.executable, "-c", NINE_SECONDS]
    done = subprocess.run(program, stderr=theirs, stdout=subprocess.PIPE, env=env, check=True)
    os.close(theirs)
    screen = Terminal()
    while chunk := _read(ours):
        screen.write(chunk)
    os.close(ours)
    assert "parts 9/9" in screen.text
    assert screen.left.strip() == ""
    assert done.stdout == b""


def _read(descriptor):
    """What is there to read; "" at the end, which Linux reports as an error."""
    try:
        return os.read(descriptor, 65536).decode()
    except OSError:
        return ""


def test_what_is_compiled_on_the_way_counts_for_no_limit_of_computing_time(monkeypatch):
    clock = Clock()
    monkeypatch.setattr("time.thread_time", clock)
    monkeypatch.setattr("time.perf_counter", clock)
    with time_budget(9.0):
        with time_budget(5.0):
            with exclude_from_budget():
                clock.now += 100.0
            report_progress("far in")
            clock.now += 6.0
            with pytest.raises(TimeBudgetError):
                report_progress("too far in")
        report_progress("beyond it")
        clock.now += 4.0
        with pytest.raises(TimeBudgetError):
            report_progress("too far beyond")
    report_progress("without a limit")
