"""What a new user waits for: a page's blocks of Python in a fresh process, with nothing compiled before and otherwise.

    python -m tests.benchmarks.cold_start [--page README.md] [--ways cold again interpreted warm] [--blocks 2]

cold: an empty cache. again: another process with what the first one left there. interpreted: nothing is ever compiled.
warm: after `handlcp warm`. Seconds of the wall and, in brackets, of the processor that the process itself computed;
each block once, in the order of the page.
"""

from __future__ import annotations

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence

from tests.benchmarks.measure import options, print_table
from tests.docs.blocks import blocks_of
from tests.docs.files import write_all

__all__ = ["main"]

ROOT = pathlib.Path(__file__).parents[2]
WAYS = {"cold": "auto", "again": "auto", "interpreted": "interpreted", "warm": "auto"}
MOST = 15.0  # seconds that a block may take

# What the fresh process runs: it imports nothing of the tests, so that the first block begins with importing handlcp.
PROGRAM = """
import contextlib, io, json, sys, time
blocks, names = json.load(sys.stdin), {"__name__": "__main__"}
for block in blocks:
    wall, cpu = time.perf_counter(), time.process_time()
    with contextlib.redirect_stdout(io.StringIO()):
        exec(block, names)
    print(json.dumps([time.perf_counter() - wall, time.process_time() - cpu]), flush=True)
"""


def run(blocks: list[str], kernels: str, cache: pathlib.Path) -> tuple[list[list[float]], float]:
    """Wall and processor seconds of each block in a fresh process, and the wall seconds of all of it."""
    environment = os.environ | {"HANDLCP_KERNELS": kernels, "HANDLCP_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)}
    with tempfile.TemporaryDirectory() as folder:
        write_all(pathlib.Path(folder))
        begun = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM], input=json.dumps(blocks), stdout=subprocess.PIPE, text=True, check=True,
            cwd=folder, env=environment,
        )  # fmt: skip
        return [json.loads(line) for line in done.stdout.splitlines()], time.perf_counter() - begun


def warmed(cache: pathlib.Path) -> None:
    """Fill a cache as the command does."""
    environment = os.environ | {"HANDLCP_KERNELS": "compiled", "HANDLCP_CACHE_DIR": str(cache)}
    subprocess.run([sys.executable, "-m", "handlcp", "warm"], check=True, cwd=ROOT, env=environment)


def main(arguments: Sequence[str] | None = None) -> dict[str, list[list[float]]]:
    """Measure, print, and return (wall, processor) seconds of each block and of all, by way."""
    parser = options(__doc__)
    parser.add_argument("--page", type=pathlib.Path, default=ROOT / "README.md")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    parser.add_argument("--blocks", type=int, help="the first few of the blocks")
    asked = parser.parse_args(arguments)
    found = [b for b in blocks_of(asked.page.read_text(encoding="utf-8")) if b.language == "python"][: asked.blocks]
    took: dict[str, list[list[float]]] = {}
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        for way in sorted(asked.ways, key=list(WAYS).index):
            cache = pathlib.Path(second if way == "warm" else first)
            if way == "warm":
                warmed(cache)
            each, whole = run([b.text for b in found], WAYS[way], cache)
            took[way] = [*each, [whole, sum(cpu for _, cpu in each)]]
    names = [*(f"line {b.line}: {_last(b.text)}" for b in found), "all, with start and end"]
    rows = [(n, *(f"{t[k][0]:.1f} ({t[k][1]:.1f})" for t in took.values())) for k, n in enumerate(names)]
    print_table(f"{asked.page.name}, block by block [s]; asked: no block over {MOST} s", ("block", *took), rows)
    return took


def _last(text: str) -> str:
    """The last line of a block, shortened, to know it by."""
    line = text.strip().splitlines()[-1].partition("  #")[0]
    return line if len(line) <= 40 else f"{line[:39]}…"


if __name__ == "__main__":
    main()
