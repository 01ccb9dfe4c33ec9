"""Do the tests see it when a line of mechanics is wrong? Sixty lines, each broken in one way, one after the other.

    python -m tests.mutants [--only 0 5 9] [--minutes 10]   break each, run the tests of its room, print what was caught
    python -m tests.mutants pick [--seed 0]                 pick others of the same room where lines are gone

A mutant is a file, a line as it is, and the line with another sign, factor or comparison: `tests/mutants.json`. Old
lines are found by their text, which is there once: in their file or, once that has moved, in the package. Each is
tried in a copy of the checkout by the test folders of its room, tests that name its module first, until one fails; a
line of a file with kernels is tried with nothing compiled.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

__all__ = ["main"]

ROOT = Path(__file__).parents[1]
FILE = Path(__file__).with_suffix(".json")
COUNT = 60
# Rooms of mechanics, deeper ones first, and the folders of tests that have to see what is wrong there
ROOMS = {
    "grasp/limits": ("limits", "loading", "paths"),
    "grasp/path": ("loading", "limits", "paths"),
    "grasp": ("grasp", "sensitivity", "margins", "properties", "hard_cases"),
    "lcp": ("lcp", "grasp", "hard_cases"),
    "kinematics": ("hand", "loading"),
    "contact": ("lcp", "grasp", "hard_cases", "hand", "loading"),
    "actuation": ("hand",),
    "robot": ("hand",),
    "geometry": ("hand", "loading"),
    "hand": ("hand", "grasp"),
    "studies": ("study",),
    "simulator": ("mujoco",),
}
SWAPS: dict[type[ast.AST], tuple[str, str]] = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Lt: ("<", ">"),
    ast.Gt: (">", "<"), ast.LtE: ("<=", ">"), ast.GtE: (">=", "<"),
}  # fmt: skip
PLAIN = ast.Raise | ast.Assert | ast.Import | ast.ImportFrom


class Mutant(NamedTuple):
    """A line of a file, and what it is broken into. room : whose tests have to see it."""

    room: str
    file: str
    old: str
    new: str


# ---------------------------------------------------------------- picking
def room_of(file: str) -> str | None:
    """The room of a file of the package, "handlcp/grasp/path/step.py" → "grasp/path"."""
    return next((room for room in ROOMS if file.startswith(f"handlcp/{room}/") or file == f"handlcp/{room}.py"), None)


def files_of(root: Path) -> list[str]:
    """Those of the package's mechanics, by name."""
    every = sorted(p.relative_to(root).as_posix() for p in (root / "handlcp").rglob("*.py"))
    return [file for file in every if room_of(file)]


def is_text(node: ast.AST) -> bool:
    """Whether it makes words, which are no mechanics."""
    words = (ast.JoinedStr,)
    return any(
        isinstance(n, words) or (isinstance(n, ast.Constant) and isinstance(n.value, str)) for n in ast.walk(node)
    )


def broken(line: str, node: ast.BinOp | ast.Compare | ast.UnaryOp) -> str | None:
    """The line with another operator in the place of the node's; None where that is no such line."""
    if isinstance(node, ast.UnaryOp):
        column = len(line.encode()[: node.col_offset].decode())
        return line[:column] + line[column + 1 :] if line[column : column + 1] == "-" else None
    left, right = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.left, node.comparators[0])
    op = node.op if isinstance(node, ast.BinOp) else node.ops[0]
    if type(op) not in SWAPS or left.end_lineno != right.lineno:
        return None
    raw = line.encode()
    start, end = left.end_col_offset or 0, right.col_offset
    between = raw[start:end].decode()
    was, becomes = SWAPS[type(op)]
    if between.count(was) != 1 or between.strip(" ()") != was:
        return None
    return raw[:start].decode() + between.replace(was, becomes) + raw[end:].decode()


def possible(root: Path, file: str) -> Iterator[Mutant]:
    """Every mutant of a file whose line is there once in the package."""
    text = (root / file).read_text(encoding="utf-8")
    lines, tree = text.splitlines(), ast.parse(text)
    inside = {id(n) for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for s in f.body for n in ast.walk(s)}
    plain = {id(n) for s in ast.walk(tree) if isinstance(s, PLAIN) for n in ast.walk(s)}
    hints = [n.annotation for n in ast.walk(tree) if isinstance(n, ast.arg | ast.AnnAssign) and n.annotation]
    plain |= {id(n) for hint in hints for n in ast.walk(hint)}
    words = [n for n in ast.walk(tree) if isinstance(n, ast.JoinedStr)]  # and places of arrays, which crash at once
    places = [n.slice for n in ast.walk(tree) if isinstance(n, ast.Subscript)]
    plain |= {id(n) for part in (*words, *places) for n in ast.walk(part)}
    for node in ast.walk(tree):
        kind = isinstance(node, ast.BinOp | ast.Compare) or (
            isinstance(node, ast.UnaryOp)
            and isinstance(node.op, ast.USub)
            and not isinstance(node.operand, ast.Constant)
        )
        if not kind or id(node) not in inside or id(node) in plain or is_text(node):
            continue
        place = node.left.end_lineno if isinstance(node, ast.BinOp | ast.Compare) else node.lineno
        old = lines[place - 1]
        new = broken(old, node)
        if new is not None and "#" not in old and len(old.strip()) > 12 and text.count(old) == 1:
            yield Mutant(room_of(file) or "", file, old, new)


def pick(root: Path, seed: int, kept: list[Mutant]) -> list[Mutant]:
    """Sixty in all, as many of each room as of the others: those kept whose line is still there, others at random."""
    rng = random.Random(seed)
    by_room: dict[str, list[Mutant]] = {room: [] for room in ROOMS}
    for file in files_of(root):
        by_room[room_of(file) or ""].extend(possible(root, file))
    for every in by_room.values():
        rng.shuffle(every)
    found = [kept[k] if k < len(kept) and place_of(root, kept[k]) else None for k in range(COUNT)]
    taken = {one.old for one in found if one}
    for k, one in enumerate(found):
        others = by_room[list(ROOMS)[k % len(ROOMS)]]
        while one is None and others:
            other = others.pop()
            one = found[k] = None if other.old in taken else other
        taken |= {one.old} if one else set()
    return [one for one in found if one]


# ---------------------------------------------------------------- running
def place_of(root: Path, mutant: Mutant) -> Path | None:
    """The one file of the package that has the line: its own, or where it has moved; None where the line is gone."""
    own = root / mutant.file
    if own.is_file() and own.read_text(encoding="utf-8").count(mutant.old) == 1:
        return own
    where = [p for p in (root / "handlcp").rglob("*.py") if mutant.old in p.read_text(encoding="utf-8")]
    return where[0] if len(where) == 1 and where[0].read_text(encoding="utf-8").count(mutant.old) == 1 else None


def copied(folder: Path) -> None:
    """Write the files of the checkout, as git knows them, to a folder."""
    told = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in told.split("\0"):
        if name and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, folder / name)


def tests_of(folder: Path, mutant: Mutant) -> list[str]:
    """Files of tests of the mutant's room, those first whose text or name has the name of its module."""
    name = Path(mutant.file).stem
    files = [p for room in ROOMS[mutant.room] for p in sorted((folder / "tests" / room).rglob("test_*.py"))]
    near = [p for p in files if name in p.stem or name in p.read_text(encoding="utf-8")]
    return [str(p.relative_to(folder)) for p in dict.fromkeys([*near, *files])]


def tried(folder: Path, mutant: Mutant, seconds: float) -> str:
    """What became of it: "caught", "MISSED", "MISSED, out of time" or "GONE"."""
    place = place_of(folder, mutant)
    if place is None:
        return "GONE"
    kept = place.read_text(encoding="utf-8")
    place.write_text(kept.replace(mutant.old, mutant.new), encoding="utf-8")
    kernels = "interpreted" if "\n@kernel" in kept else "compiled"
    own = {"PYTHONPATH": str(folder), "HANDLCP_KERNELS": kernels, "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider"]
    try:
        done = subprocess.run(
            [*command, *tests_of(folder, mutant)], cwd=folder, env=os.environ | own, timeout=seconds,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "MISSED, out of time"
    finally:
        place.write_text(kept, encoding="utf-8")
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return f"caught by {failed[0].split()[1]}" if failed else f"MISSED ({done.stdout.strip().splitlines()[-1][:60]})"


def main() -> int:
    """Pick, or run: 1 where a mutant was missed or is gone."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="?", choices=("run", "pick"), default="run")
    parser.add_argument("--seed", type=int, default=0, help="of the lines that are picked")
    parser.add_argument("--only", nargs="+", type=int, help="numbers of mutants")
    parser.add_argument("--minutes", type=float, default=10.0, help="for each at most")
    asked = parser.parse_args()
    mutants = [Mutant(**row) for row in json.loads(FILE.read_text(encoding="utf-8"))]
    if asked.what == "pick":
        rows = [dict(room=m.room, file=m.file, old=m.old, new=m.new) for m in pick(ROOT, asked.seed, mutants)]
        FILE.write_text(json.dumps(rows, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        return 0
    numbers = asked.only or list(range(len(mutants)))
    said = list[str]()
    with tempfile.TemporaryDirectory() as name:
        copied(Path(name))
        for k in numbers:
            begun, mutant = time.monotonic(), mutants[k]
            said.append(tried(Path(name), mutant, 60.0 * asked.minutes))
            print(f"{k:2d} {mutant.room:12s} {time.monotonic() - begun:5.0f} s  {said[-1]}", flush=True)
            print(f"   {mutant.file}\n   - {mutant.old.strip()}\n   + {mutant.new.strip()}", flush=True)
    caught = sum(word.startswith("caught") for word in said)
    print(f"{caught} of {len(said)} caught; {said.count('GONE')} gone: `pick` makes a new list")
    return int(caught < len(said))


if __name__ == "__main__":
    raise SystemExit(main())
