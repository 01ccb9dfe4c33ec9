"""What each verdict costs, beside a grasp that is held: medians over scenes of the peers' families, one thread.

    python -m tests.benchmarks.verdicts FOLDER [--families ring sphere] [--fingers 3 5] [--count 60]

FOLDER holds the peers' scenes (`tests.benchmarks.corpus`). Best of some rounds, timed by the processor's clock, so that
a busy machine counts for little. A time is that of `grasp.solve(throw=False)` on a grasp made before.
"""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import json
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.clock import best_times
from tests.benchmarks.corpus import Faces, PeersFolder, as_case, family_options
from tests.benchmarks.report import conditions, opened, plain_table

__all__ = ["main"]

LIMITS = {("NOT_HOLDABLE", 3): 10.0, ("NOT_HOLDABLE", 5): 10.0, ("NO_EQUILIBRIUM", 3): 50.0, ("NO_EQUILIBRIUM", 5): 1e3}
NAMES = ("SOLVED", "NOT_HOLDABLE", "NO_EQUILIBRIUM", "UNDECIDED")


def measured(scenes: list[Any], faces: Faces, rounds: int) -> dict[str, list[float]]:
    """Seconds of each scene's solve by the status that it ends with."""
    found: dict[str, list[float]] = defaultdict(list)
    for scene in scenes:
        make = as_case(scene, faces).grasp
        status = make().solve(faces, throw=False).status.name

        def call(make: Any = make) -> Any:
            grasp = make()
            return lambda: grasp.solve(faces, throw=False)

        found[status].append(best_times({"solve": call}, rounds, burst=1, clock=time.process_time)["solve"])
    return found


def main() -> None:
    """Measure, print, write."""
    o = family_options(__doc__).parse_args()
    console, folder = opened(120), PeersFolder(o.folder)
    console.print(conditions(), highlight=False)
    table = plain_table(
        "grasp.solve by its verdict: median, and its multiple of a held one", "fingers", "section", "held µs",
        "not holdable", "no equilibrium", "undecided",
        caption="In brackets how many scenes there are, then the multiple that is allowed.",
    )  # fmt: skip
    out: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as directory:
        for fingers in o.fingers:
            scenes = []
            for family in o.families:
                scenes += folder.family(Path(directory), family, fingers, o.count)
            for faces in (8, "cone"):
                times = measured(scenes, faces, o.rounds)
                held = float(np.median(times["SOLVED"]))
                cells = []
                for name in NAMES[1:]:
                    limit = LIMITS.get((name, fingers))
                    ratio = f"{np.median(times[name]) / held:.1f} ×" if times[name] else "–"
                    cells.append(f"{ratio} ({len(times[name])})" + (f" ≤ {limit:g}" if limit else ""))
                table.add_row(str(fingers), str(faces), f"{1e6 * held:.0f} ({len(times['SOLVED'])})", *cells)
                out[f"{fingers} fingers, {faces}"] = {name: times[name] for name in NAMES}
    console.print(table)
    if o.json:
        o.json.write_text(json.dumps({"conditions": conditions(), "seconds": out}, indent=1))


if __name__ == "__main__":
    main()
