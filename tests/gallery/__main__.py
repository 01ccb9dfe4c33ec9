"""Every hand there is with a ball, a box and a cylinder: found, held, how fast. A minute; exit status 1 for a miss."""

from __future__ import annotations

import sys
import time

import handlcp as hl
from handlcp.study.gallery import GALLERY_HANDS
from tests.hand.test_commercial import OBJECTS


def main() -> int:
    """A line for each grasp."""
    missed = 0
    print(f"{'hand':13}{'object':10}{'verdict':10}{'margin':>7}{'found':>7}{'seconds':>9}")
    for name in GALLERY_HANDS:
        try:
            hand = hl.example_hand(name, joint_stiffness=5.0)
        except hl.HandLCPError as why:
            print(f"{name:13}{why}")
            continue
        for thing, obj in OBJECTS.items():
            start = time.process_time()
            found = hl.find_grasp(hand, obj, friction=hl.SoftFinger(0.6, mu_torsion=0.005), throw=False)
            seconds = time.process_time() - start
            word, margin = (found[0].verdict.word, found[0].margin) if found else ("none", float("nan"))
            missed += word != "HELD"
            print(f"{name:13}{thing:10}{word:10}{margin:7.2f}{len(found):7}{seconds:9.1f}", flush=True)
    print(f"{missed} missed")
    return min(missed, 1)


if __name__ == "__main__":
    sys.exit(main())
