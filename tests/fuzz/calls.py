"""Calls of every public function, constructor and method with one wrong value each:

    python -m tests.fuzz.calls [calls] [seed]

Allowed is an answer, or a `HandLCPError`. It prints how many calls were accepted, refused with a typed error, took too
long, ended otherwise (untyped), or took what is no number for one (silent), and the last two one by one.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from contextlib import contextmanager
from typing import Any, NamedTuple

import handlcp as hl
from tests.fuzz.public_calls import Call, calls
from tests.fuzz.wrong_values import SILENT, VALUES, kind_of, shown

SECONDS = 10.0  # for one call


class TooLong(BaseException):
    """A call has had its time."""


class Trial(NamedTuple):
    """One call with one wrong value. kind : of the parameter, or "unknown", "missing", "many"."""

    call: Call
    parameter: str
    kind: str
    value: Any

    def __str__(self):
        return f"{self.call.name}({self.parameter}={shown(self.value)})"


class Outcome(NamedTuple):
    """word : accepted, typed, untyped, silent, slow. why : the error, where there was one."""

    trial: Trial
    word: str
    why: str
    seconds: float


def trials():
    """All of them."""
    return [trial for call in calls() for trial in _of(call)]


def _of(call):
    yield Trial(call, "no_such_keyword", "unknown", 1)
    yield Trial(call, "", "many", [object()] * 40)
    for p in call.parameters:
        if p.kind is p.VAR_KEYWORD:
            continue
        if p.default is p.empty and p.kind is not p.VAR_POSITIONAL:
            yield Trial(call, p.name, "missing", None)
        kind = kind_of(p.name, str(p.annotation).strip("'"))
        for value in VALUES[kind]:
            if not (value is None and p.default is None):
                yield Trial(call, p.name, "rest" if p.kind is p.VAR_POSITIONAL else kind, value)


def run(trial, seconds=SECONDS):
    """What comes of it."""
    call, name, kind, value = trial
    given = call.given()
    args: tuple[Any, ...] = ()
    if kind == "missing":
        given.pop(name, None)
    elif kind == "many":
        args, given = tuple(value), {}
    elif kind == "rest":
        args = (value,)
    else:
        given[name] = value
    call.prepare()
    began = time.monotonic()
    word, why = "accepted", ""
    try:
        with limited(seconds), warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", "Glyph .* missing")  # in a title that no font has letters for
            str(call.function(*args, **given))
    except hl.HandLCPError as error:
        word, why = "typed", str(error)
    except TooLong:
        word = "slow"
    except Exception as error:
        word, why = "untyped", f"{type(error).__name__}: {error}"
    if word == "accepted" and (kind in ("unknown", "missing", "many") or any(value is v for v in SILENT.get(kind, ()))):
        word = "silent"
    return Outcome(trial, word, why, time.monotonic() - began)


@contextmanager
def limited(seconds):
    """The block ends with TooLong after so long."""

    def end(*_):
        raise TooLong

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def fuzz(many, seed, seconds=SECONDS, among=None):
    """So many of the trials, drawn without putting them back, in a folder that is thrown away. among : these trials;
    None: all.
    """
    every = trials() if among is None else among
    drawn = random.Random(seed).sample(every, min(many, len(every)))
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            return [run(trial, seconds) for trial in drawn]
        finally:
            os.chdir(here)


def main():
    """Run and print."""
    numbers = [int(word) for word in sys.argv[1:3]]
    many, seed = [*numbers, *(2500, 0)[len(numbers) :]]
    found = fuzz(many, seed)
    for word in ("untyped", "silent", "slow"):
        for one in sorted((o for o in found if o.word == word), key=lambda o: o.trial.call.name):
            print(f"{word:8} {one.trial}  {one.why[:160]!r}")
    counts = Counter(o.word for o in found)
    print(f"{len(found)} of {len(trials())} calls, seed {seed}: " + ", ".join(
        f"{counts[word]} {word}" for word in ("accepted", "typed", "untyped", "silent", "slow")))  # fmt: skip
    worst = Counter(o.trial.call.name for o in found if o.word in ("untyped", "silent"))
    print("by callable:", ", ".join(f"{name} {n}" for name, n in worst.most_common(40)) or "none")
    return int(bool(worst))


if __name__ == "__main__":
    sys.exit(main())
