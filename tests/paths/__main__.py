"""Measures of load limits and loadings over random grasps; each prints what it finds.

    python -m tests.paths contradictions --grasps 400 [--directions 12] [--jobs 1] [--steps] [--order staged | plain]
    python -m tests.paths monotone --grasps 200
    python -m tests.paths scans [--boxes 20]
    python -m tests.paths same --grasps 40
    python -m tests.paths freeze --cases 2000 --out frozen.json.gz
    python -m tests.paths compare [--scenes 2000]    where the package says otherwise than that file
    python -m tests.paths accept --numbers 3000      tries the cases of seed 0 and notes which hold

Exit status 1 where something was found.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from tests.paths import accept, contradictions, freeze, monotone, same, scans
from tests.paths.words import ORDERS


def main() -> int:
    """Run one measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = parser.add_subparsers(dest="measure", required=True)

    one = kinds.add_parser("contradictions")
    one.add_argument("--jobs", type=int, default=1)
    one.add_argument("--steps", action="store_true", help="10 to 160 steps end the same, instead")
    one.add_argument("--order", choices=ORDERS, default=ORDERS[0])
    one.set_defaults(run=lambda a: contradictions.measure(
        a.grasps, a.directions, a.steps, a.order, a.jobs, a.seed, a.start
    ))  # fmt: skip
    two = kinds.add_parser("monotone")
    two.set_defaults(run=lambda a: monotone.measure(a.grasps, a.directions, a.seed, a.start))
    three = kinds.add_parser("same")
    three.add_argument("--kernels", type=int, default=6, help="limits that are asked compiled and interpreted")
    three.set_defaults(run=lambda a: same.measure(a.grasps, a.directions, a.kernels, a.seed, a.start))
    for of, count, ways in ((one, 400, 12), (two, 200, 1), (three, 40, 2)):
        of.add_argument("--grasps", type=int, default=count)
        of.add_argument("--directions", type=int, default=ways)
        of.add_argument("--seed", type=int, default=0)
        of.add_argument("--start", type=int, default=0, help="number of the first case")

    four = kinds.add_parser("scans")
    four.add_argument("--boxes", type=int, default=20)
    four.add_argument("--points", type=int, default=40)
    four.add_argument("--seed", type=int, default=0)
    four.set_defaults(run=lambda a: scans.measure(a.boxes, a.points, a.seed))
    five = kinds.add_parser("freeze")
    five.add_argument("--cases", type=int, default=2000, help="scenes")
    five.add_argument("--directions", type=int, default=2, help="scenes of one grasp")
    five.add_argument("--seconds", type=float, default=20.0, help="longest for a scene")
    five.add_argument("--out", type=Path, default=freeze.FROZEN)
    five.set_defaults(run=lambda a: freeze.freeze(a.cases, a.out, a.seconds, a.directions))
    seven = kinds.add_parser("compare")
    seven.add_argument("--scenes", type=int, default=2000)
    seven.add_argument("--seconds", type=float, default=20.0, help="longest for a scene")
    seven.add_argument("--file", type=Path, default=freeze.FROZEN)
    seven.set_defaults(run=lambda a: freeze.compare(a.file, a.scenes, a.seconds))
    six = kinds.add_parser("accept")
    six.add_argument("--numbers", type=int, default=3000)
    six.add_argument("--out", type=Path, default=accept.ACCEPTED)
    six.set_defaults(run=lambda a: accept.accept(a.numbers, a.out))
    asked = parser.parse_args()
    os.environ.setdefault("HANDLCP_KERNELS", "compiled")
    return min(int(asked.run(asked) or 0), 1)


if __name__ == "__main__":
    sys.exit(main())
