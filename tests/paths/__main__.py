"""Measures of load limits and loadings over random grasps; each prints what it finds.

    python -m tests.paths contradictions --grasps 400 [--directions 12] [--jobs 1] [--steps] [--order staged | plain]
    python -m tests.paths monotone --grasps 200
    python -m tests.paths scans --count 20 [--ask squeeze,friction,stiffness,direction]
    python -m tests.paths same --count 40 [--start 0] [--directions 2] [--ask words,steps,variants]
    python -m tests.paths freeze --cases 2000 --out frozen.json.gz
    python -m tests.paths compare [--scenes 2000]    where the package says otherwise than that file
    python -m tests.paths walk --grasps 60           limits in one posture beside a walk that tries every choice
    python -m tests.paths accept --numbers 3000      tries the cases of seed 0 and notes which hold

Exit status 1 where something was found.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.paths import contradictions, corpus, freeze, monotone, same, scans, walk
from tests.paths.words import ORDERS

HELP = {
    "start": "number of the first case, or its index", "kernels": "limits that are asked compiled and interpreted",
    "cases": "scenes", "seconds": "longest for a scene or a question", "count": "grasps", "ask": "what is compared",
    "minutes": "of the processor, after which no other grasp is begun", "points": "of a scan",
    "worst": "told of each property", "within": "share that limits may differ by",
}  # fmt: skip


def main() -> int:
    """Run one measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = parser.add_subparsers(required=True)

    def add(name: str, measure: Callable[..., int], **options: Any) -> argparse.ArgumentParser:
        kind = kinds.add_parser(name)
        kind.set_defaults(measure=measure)
        for option, value in options.items():
            kind.add_argument(f"--{option}", type=type(value), default=value, help=HELP.get(option))
        return kind

    cases = {"seed": 0, "start": 0}
    one = add("contradictions", contradictions.measure, grasps=400, directions=12, jobs=1, **cases)
    one.add_argument("--steps", action="store_true", help="10 to 160 steps end the same, instead")
    one.add_argument("--order", choices=ORDERS, default=ORDERS[0])
    add("monotone", monotone.measure, grasps=200, directions=1, **cases)
    more = {"seconds": 20.0, "minutes": np.inf, "worst": 3, "ask": ",".join(same.ASKED)}
    add("same", same.measure, count=40, directions=2, kernels=0, **more, **cases)
    add("scans", scans.measure, count=20, points=40, seconds=20.0, ask=",".join(scans.SCANS), **cases)
    add("freeze", freeze.freeze, cases=2000, directions=2, seconds=20.0, out=freeze.FROZEN)
    add("compare", freeze.compare, scenes=2000, seconds=20.0, file=freeze.FROZEN)
    add("walk", walk.measure, grasps=60, directions=12, within=1e-6, **cases)
    add("accept", freeze.accept, numbers=3000, out=corpus.ACCEPTED)
    asked = vars(parser.parse_args())
    os.environ.setdefault("HANDLCP_KERNELS", "compiled")
    return min(int(asked.pop("measure")(**asked) or 0), 1)


if __name__ == "__main__":
    sys.exit(main())
