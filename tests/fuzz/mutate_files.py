"""Files of all kinds that went through the wars, read in processes of their own: `python -m tests.fuzz.mutate_files`.

Prints how many were read, refused with a typed error, and, which has to be 0: ended untyped (crashes among them), took
more than 10 s, more than 2 GB, or wrote a file that nobody named.
"""

from __future__ import annotations

import argparse
import ast
import os
import queue
import random
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tests.fuzz.mutations import line_moved, line_twice, mutated, no_line, truncated
from tests.fuzz.seed_files import bombs, write_seeds

CHECKOUT = Path(__file__).parents[2]
LIMIT = 10.0  # s of computing; six times as long by the clock, on a machine that does other things
STARTS = 120.0  # s that a child may take to import and compile
VALUES = [b"nan", b"inf", b"-inf", b"1e400", b"-1e300", b"1e300", b"0", b"-1", b"", b"x", b"1 2", b"0x10", b"1e-320",
          b"9" * 400, b"100000000", b"99999999999", b"true", b"null", b"[]", b"{}", b"''", b'"', b"2001-01-01",
          b"\xff\xfe", b"\x00", b"../../x", b"/dev/zero", b"[[[[[[[["]  # fmt: skip
MARKS = [*[bytes([c]) for c in b"<>&[]{},:*'\"\n\0"], b"*a", b"&a ", b"\xef\xbb\xbf"]
NUMBER = re.compile(rb"-?\d+\.?\d*(?:e-?\d+)?")
WORD = re.compile(rb"[A-Za-z_]\w*")
VICTIM = b"somebody's\n"


def one_number(rng, data):
    m = rng.choice(list(NUMBER.finditer(data)))
    return data[: m.start()] + rng.choice(VALUES) + data[m.end() :]


def one_word(rng, data):
    """A word of the file takes the place of another, or an absurd one does."""
    words = list(WORD.finditer(data))
    m, other = rng.choice(words), rng.choice(words)
    return data[: m.start()] + rng.choice([other[0], *VALUES]) + data[m.end() :]


def one_byte(rng, data):
    i = rng.randrange(len(data))
    return data[:i] + bytes([rng.randrange(256)]) + data[i + 1 :]


def one_bit(rng, data):
    i = rng.randrange(len(data))
    return data[:i] + bytes([data[i] ^ (1 << rng.randrange(8))]) + data[i + 1 :]


def without(rng, data):
    i = rng.randrange(len(data))
    return data[:i] + data[i + rng.choice([1, 2, 8, 64, 512]) :]


def twice(rng, data):
    i, n = rng.randrange(len(data)), rng.choice([1, 4, 64, 512])
    return data[: i + n] + data[i : i + n] * rng.choice([1, 2, 50]) + data[i + n :]


def noise(rng, data):
    i = rng.randrange(len(data))
    return data[:i] + rng.choice(MARKS) * rng.choice([1, 1, 1, 2000]) + data[i:]


MUTATIONS = (one_number, one_number, one_number, one_word, one_word, one_byte, one_bit, one_bit, truncated, without,
             twice, line_moved, line_twice, no_line, noise)  # fmt: skip


@dataclass
class Counts:
    """What became of the files, and those that went wrong with the reason, by name."""

    found: Counter[str] = field(default_factory=Counter)
    wrong: dict[str, str] = field(default_factory=dict)

    def __str__(self):
        heads = ["files", "read", "refused", "untyped", "hangs over 10 s", "over 2 GB", "written"]
        return "\n".join([*[f"{self.found[head]:6d}  {head}" for head in heads],
                          *[f"{name}: {why}" for name, why in self.wrong.items()]])  # fmt: skip


def write_mutants(folder, count, seed):
    """(kind, file) of the bombs and of so many mutants in all, with one to three mutations each; and a file of
    somebody, which has to stay what it is.
    """
    rng, seeds = random.Random(seed), write_seeds(folder)
    victim = folder / "victim.txt"
    victim.write_bytes(VICTIM)
    made = list[tuple[str, Path]]()
    for kind, ending, data in bombs(victim):
        made.append((kind, _put(folder / f"bomb_{ending}", data, seeds[kind][0])))
    kinds = list(seeds)
    for i in range(max(0, count - len(made))):
        kind = kinds[i % len(kinds)]
        original = rng.choice(seeds[kind])
        data, _ = mutated(rng, original.read_bytes(), MUTATIONS)
        made.append((kind, _put(folder / f"{i:05d}_{original.name}", data, original)))
    return made, victim


def _put(file, data, original):
    """Written, with what has to stand beside it: the description of a table, or the table of a description."""
    file.write_bytes(data)
    table = original.with_name(original.name.removesuffix(".json"))
    if original.suffix == ".csv":
        shutil.copy(original.with_name(f"{original.name}.json"), file.with_name(f"{file.name}.json"))
    elif original.name.endswith(".csv.json"):
        shutil.copy(table, file.with_name(file.name.removesuffix(".json")))
    return file


def run(folder, count, seed):
    """Mutates and reads. folder : an empty one."""
    files, own = folder / "files", folder / "own"
    files.mkdir()
    own.mkdir()
    made, victim = write_mutants(files, count, seed)
    listing = folder / "listing"
    listing.write_text("".join(f"{kind}\t{path}\n" for kind, path in made), encoding="utf-8")
    before, counts, first = _state(files), Counts(), 0
    while first < len(made):
        first = _read(listing, first, own, made, counts)
    counts.found["files"] = len(made)
    changed = {path.name for path, said in _state(files).items() if before.get(path) != said}
    if changed or victim.read_bytes() != VICTIM or (folder / "outside.csv").exists():
        counts.found["written"] += 1
        counts.wrong["files"] = f"changed: {sorted(changed)[:5]}"
    return counts


def _state(folder):
    return {path: (path.stat().st_size, path.stat().st_mtime_ns) for path in folder.rglob("*")}


def _read(listing, first, own, made, counts):
    """Reads from a number on until the child ends; returns the number to go on with."""
    command = [sys.executable, "-m", "tests.fuzz.read_files", str(listing), str(first), str(own), str(LIMIT)]
    told, lines, at, patience = own / "stderr", queue.Queue[str | None](), first, STARTS
    env, pipe = os.environ | {"TMPDIR": str(own)}, subprocess.PIPE
    with (
        told.open("wb") as errors,
        subprocess.Popen(command, cwd=CHECKOUT, env=env, stdin=pipe, stdout=pipe, stderr=errors, text=True) as child,
    ):
        pump = threading.Thread(target=_pump, args=(child.stdout, lines), daemon=True)
        pump.start()
        try:
            while (line := lines.get(timeout=patience)) is not None:
                number, what, *_ = line.rstrip("\n").split("\t")
                at, patience = int(number), 6.0 * LIMIT
                if what != "begins":
                    _note(counts, made[at], ast.literal_eval(what))
                    at += 1
            status = child.wait()
        except queue.Empty:
            child.kill()
            status = None
        pump.join()
    if status is None:
        _note(counts, made[at], "hang")
    elif status and at < len(made):
        _note(counts, made[at], f"untyped: the process ended with {status}: {told.read_text(errors='replace')[-300:]}")
    else:
        return at
    return at + 1


def _pump(stream, lines):
    for line in stream:
        lines.put(line)
    lines.put(None)


def _note(counts, file, outcome):
    heads = {"hang": "hangs over 10 s", "memory": "over 2 GB"}
    word = outcome.split(" ")[0].rstrip(":")
    counts.found[heads.get(word, word)] += 1
    if word not in ("read", "refused"):
        counts.wrong[file[1].name] = outcome


def main():
    """Prints the counts; 1 where any that has to be 0 is not."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="an empty folder to keep the files in")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as other:
        counts = run(asked.keep or Path(other), asked.count, asked.seed)
    print(counts)
    return int(bool(counts.wrong))


if __name__ == "__main__":
    raise SystemExit(main())
