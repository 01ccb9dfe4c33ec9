"""`solve_lcp` on grasps of five fingers beside QuantEcon's Lemke: pyramids of 8, 16 and 32 faces, and the cone.

    python -m tests.benchmarks.five_fingers
    python -m tests.benchmarks.five_fingers --scenes 60 --rounds 12 --peers PEERS_FOLDER

Both get the same problem: QuantEcon the standard LCP that is left of it, ready made and the same in every call,
`solve_lcp` a new one in every call, certificate included. Times are the best of some rounds, in turns; ratios are
medians of those of each grasp. Without a folder the grasps are random rings of the tests, in half of which a joint
couples all fingers.
"""

from __future__ import annotations

import argparse
import functools
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import handlcp as hl
from tests.benchmarks.calls import assembled, call_solve_lcp
from tests.benchmarks.clock import Task, best_times
from tests.benchmarks.corpus import Faces, PeersFolder, as_case
from tests.benchmarks.report import conditions, opened, plain_table
from tests.grasp.scenes import ring

SECTIONS: tuple[Faces, ...] = (8, 16, 32, "cone")
BESIDE = {8: 8, 16: 16, 32: 32, "cone": 8}  # faces of the pyramid that QuantEcon solves
LIMITS = {8: 3.0, 16: 1.3, 32: 0.4, "cone": 3.0}
OURS, THEIRS = "solve_lcp", "QuantEcon"

Make = Callable[[], hl.Grasp]


def rings(count: int) -> list[Make]:
    """Random ones of the tests."""
    rng = np.random.default_rng(0)
    made = [ring(rng, 5, rng.uniform(0.3, 1.0), rng.uniform(0.002, 0.03), shared=k % 2 == 0) for k in range(count)]
    return [functools.partial(hl.Grasp, contacts, **more) for contacts, more in made]


def peers_rings(folder: Path, count: int) -> list[Make]:
    """Those of the folder's families."""
    with tempfile.TemporaryDirectory() as directory:
        scenes = PeersFolder(folder).family(Path(directory), "ring", 5, count)
    return [as_case(s, "cone").grasp for s in scenes]


def lemke(grasp: Make, faces: int) -> Task | None:
    """QuantEcon's call; None where it has no answer."""
    from quantecon.optimize import lcp_lemke

    problem = assembled(grasp, faces)
    if not problem.eliminated:
        return None
    M, q = np.array(problem.scaled.M), np.array(problem.scaled.q)
    z = lcp_lemke(M, q, max_iter=10000).z
    if not (abs(np.minimum(z, M @ z + q)).max() < 1e-6):
        return None
    return lambda: lambda: lcp_lemke(M, q, max_iter=10000)


def measured(grasp: Make, faces: Faces, rounds: int) -> dict[str, float] | None:
    """Seconds of both, in turns; None where one of them has no answer."""
    make = functools.partial(assembled, grasp, faces)
    theirs = lemke(grasp, BESIDE[faces])
    if theirs is None or hl.solve_lcp(make(), throw=False).status is not hl.Status.SOLVED:
        return None
    return best_times({THEIRS: theirs, OURS: call_solve_lcp(make)}, rounds)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--peers", type=Path, help="a folder with scenes.py, problems.py and run_peers.py: its rings")
    o = parser.parse_args()
    console = opened(120)
    console.print(conditions(), highlight=False)
    grasps = rings(o.scenes) if o.peers is None else peers_rings(o.peers, o.scenes)
    headings = ("solved by both", f"{OURS} [µs]", f"{THEIRS} [µs]", "ratio", "at most")
    table: Any = plain_table(f"{len(grasps)} rings of five fingers", "", *headings)
    for faces in SECTIONS:
        found = [t for grasp in grasps if (t := measured(grasp, faces, o.rounds)) is not None]
        ours, theirs = ([1e6 * t[name] for t in found] for name in (OURS, THEIRS))
        ratio = median([a / b for a, b in zip(ours, theirs, strict=True)])
        name = f"{faces} faces" if faces != "cone" else f"cone, beside {BESIDE[faces]} faces"
        table.add_row(
            name, str(len(found)), f"{median(ours):.1f}", f"{median(theirs):.1f}", f"{ratio:.2f}", f"{LIMITS[faces]:g}"
        )
    console.print(table)


if __name__ == "__main__":
    main()
