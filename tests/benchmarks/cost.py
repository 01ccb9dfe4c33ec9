"""The measures of accuracy and time in one command, everything on one thread unless said.

    python -m tests.benchmarks.cost [--updates 1000000] [--grasps 100000] [--seconds 60] [--json FILE]

NSNGRK against the algorithm as printed; a stream's updates beside bare Pinocchio, and its memory; many grasps on all
cores. What accuracy itself costs in a scene is `examples/accuracy_cost.py`; whether claimed errors hold on the corpus,
`python -m tests.benchmarks.accuracy_claims FOLDER`.
"""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import json
from pathlib import Path
from typing import Any

from tests.benchmarks import as_printed, many, real_time
from tests.benchmarks.report import conditions, opened, plain_table

__all__ = ["main"]


def limits(
    printed: Any, times: dict[str, float], bytes_: float, sweeps: dict[str, Any]
) -> list[tuple[str, float, str, float]]:
    """(what, measured, "≥" or "≤", limit)."""
    names = list(times)
    out = []
    for number, runs in printed.items():
        for name in ("NSNGRK()", "NSNGRK on friction as a set (default)"):
            ratio = runs["as printed"].seconds / runs[name].seconds
            out.append((f"as printed / {name}, Example {number}, 16 faces", ratio, "≥", 100.0))
    for what, name in (("all fingers stick", names[1]), ("some slide", names[2])):
        out.append(
            (f"warm stream, posture → torques / bare Pinocchio, {what}", times[name] / times[names[0]], "≤", 40.0)
        )
    out.append(("bytes an update, by which the process grows", bytes_, "≤", 0.1))
    counts = [v for v in sweeps.values() if isinstance(v, list)][:-1]
    one, all_ = counts[-1]
    out.append((f"solve_many, 1 core / {sweeps['cores']} cores, largest sweep", one / all_, "≥", 1.7))
    single = [c[0] for c in counts]
    out.append(("… cost a grasp, dearest / cheapest count, 1 core", max(single) / min(single), "≤", 1.2))
    return out


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--updates", type=int, default=1_000_000, help="of the stream, for its memory")
    parser.add_argument("--grasps", type=int, default=100_000, help="most at once")
    parser.add_argument("--seconds", type=float, default=60.0, help="a run of the algorithm as printed at most")
    parser.add_argument("--json", type=Path, help="write everything measured to this file")
    o = parser.parse_args()
    console = opened(120)
    console.print(conditions(), highlight=False)
    printed = as_printed.main(console, o.seconds)
    times = real_time.measure(console)
    bytes_ = real_time.growth(console, o.updates)
    sweeps = many.measure(console, o.grasps)
    found = limits(printed, times, bytes_, sweeps)
    table = plain_table("Limits", "", "measured", "", "limit", "")
    for what, value, sign, limit in found:
        met = value <= limit if sign == "≤" else value >= limit
        table.add_row(what, f"{value:,.3g}", sign, f"{limit:g}", "met" if met else "missed")
    console.print(table)
    if o.json:
        result = {"conditions": conditions(), "stream_us": times, "stream_bytes": bytes_, "many_us": sweeps}
        o.json.write_text(json.dumps(result | {"limits": found}, indent=1, default=float))


if __name__ == "__main__":
    main()
