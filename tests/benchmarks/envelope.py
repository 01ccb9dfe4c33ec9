"""What an envelope costs: beside the limits of its directions alone, and its bound without compliance.

    python -m tests.benchmarks.envelope [--rounds 5] [--followed]

Times by the processor's clock, on one core; the least of the rounds. "all": `hl.envelope` with 1002 directions and
`adaptive=0`, its causes and shares included. "own": what it takes beyond `limits_of`. "bound": when it is first asked
for. "followed": milliseconds a direction of `geometry="followed"`, over 12 directions.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["HANDLCP_KERNELS"] = "compiled"

from functools import partial
from pathlib import Path
from typing import Any

import handlcp as hl
from handlcp import scene as scenes
from tests.benchmarks.report import conditions, opened, plain_table
from tests.support.study import limits_of_directions

__all__ = ["main"]

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENES = {"cube, three fingers": "cube_three_fingers", "ball, five fingers": "ball_five_fingers",
          "ball, Allegro": "allegro_pinch"}  # fmt: skip
MOST, OWN, FOLLOWED = 0.3, 0.05, 20.0  # seconds, seconds, milliseconds a direction


def timed(run: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of this process, and what came of it."""
    begun = time.process_time()
    found = run()
    return time.process_time() - begun, found


def whole(grasp: hl.Grasp, faces: Any) -> hl.Envelope:
    """All around, with what is read off it first."""
    env = hl.envelope(grasp, 1000, faces=faces, adaptive=0)
    assert env.causes
    return env


def row(name: str, faces: Any, rounds: int, followed: bool) -> list[str]:
    """One grasp, one kind of friction cones."""
    grasp = scenes.load(EXAMPLES / f"{SCENES[name]}.toml").build()
    hl.envelope(grasp, 12, faces=faces)
    every, alone = [], []
    for _ in range(rounds):
        took, env = timed(lambda: whole(grasp, faces))
        every.append(took)
        loads = env.wrenches
        alone.append(timed(partial(limits_of_directions, grasp, loads, faces))[0])
    bound, moving = timed(lambda: env.bound)[0], "–"
    if followed:
        hl.envelope(grasp, 12, faces=faces, adaptive=0, geometry="followed")
        took, few = timed(lambda: hl.envelope(grasp, 12, faces=faces, adaptive=0, geometry="followed"))
        moving = f"{1e3 * took / len(few.factors):.1f}"
    own = min(every) - min(alone)
    return [name, str(faces), f"{min(every):.3f}", f"{1e3 * max(own, 0.0):.0f}", f"{bound:.3f}", moving]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--followed", action="store_true")
    asked = parser.parse_args()
    console = opened(100)
    console.print(conditions(), highlight=False)
    title = f"envelopes (all ≤ {MOST} s on pyramids, own ≤ {1e3 * OWN:.0f} ms, followed ≤ {FOLLOWED:.0f} ms)"
    table = plain_table(title, "grasp", "faces", "all s", "own ms", "bound s", "followed ms")
    for name in SCENES:
        for faces in (8, "cone"):
            table.add_row(*row(name, faces, asked.rounds, asked.followed))
    console.print(table)


if __name__ == "__main__":
    main()
