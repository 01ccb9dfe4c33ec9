"""Run every case, or those whose names hold a word: `python -m tests.mujoco [word ...]`. Minutes; exit 1 for a miss.

`python -m tests.mujoco limits [word ...]` compares load limits: see `tests.mujoco.limits`; `power [word ...]` power
grasps: see `tests.mujoco.power`; `power pads` their forces with other pads: see `tests.mujoco.power_pads`; `closing`
the order in which links touch: see `tests.mujoco.closing`.

HANDLCP_KERNELS=compiled is set, as in the tests: the times are those of compiled kernels.
"""

import os
import sys
from statistics import median

os.environ.setdefault("HANDLCP_KERNELS", "compiled")

from tests.mujoco import closing, limits as load_limits, power
from tests.mujoco.case import chosen, limit_error, misses
from tests.mujoco.cases import CASES

HEAD = (
    f"{'case':44s} {'hand':13s} {'both':6s} {'forces':>8s} {'torques':>8s} {'motion':>8s} {'moves':>9s}"
    f" {'lost at':>16s} {'handlcp':>8s} {'MuJoCo':>8s} {'ratio':>6s}"
)


def row(case, found):
    """One line of the table."""
    ours, theirs = found.loading, found.simulation
    both = "held" if found.both_hold else "lost" if found.agree else "differ"
    errors = "".join(f" {100 * e:7.3f}%" if found.both_hold else " " * 9 for e in
                     (found.force_error, found.torque_error, found.motion_error))  # fmt: skip
    moves = f" {1e3 * sum(x * x for x in theirs.displacement[:3]) ** 0.5:6.2f} mm" if found.both_hold else " " * 10
    limit = "".join(f" {'' if x is None else f'{x:.1%}':>8s}" for x in (ours.lost_at, theirs.lost_at))
    ratio = theirs.seconds / found.seconds
    times = f" {1e3 * found.seconds:5.0f} ms {theirs.seconds:6.2f} s {ratio:6.0f}"
    return f"{case.name:44s} {case.hand:13s} {both:6s}{errors}{moves}{limit}{times}"


def main(words):
    """Print the table and what it comes to; how many cases miss."""
    missed, forces, ratios, limits = 0, [], [], []
    print(HEAD, flush=True)
    for case in chosen(CASES, words):
        found = case.run()
        wrong = misses(case, found)
        missed += bool(wrong)
        ratios.append(found.simulation.seconds / found.seconds)
        if found.both_hold and case.kind == "sticks":
            forces.append(found.force_error)
        if case.kind == "limit":
            limits.append(abs(limit_error(found)))
        print(row(case, found) + (f"  MISS: {'; '.join(wrong)}" if wrong else ""), flush=True)
    if forces:
        most = f"{100 * max(forces):.3f} % at most"
        print(f"forces where contacts stick: {100 * median(forces):.3f} % in the median, {most}")
    if limits:
        print(f"load limits: {100 * max(limits):.2g} % at most")
    if ratios:
        print(f"MuJoCo takes {min(ratios):.0f} to {max(ratios):.0f} × the time, {median(ratios):.0f} × in the median")
        print(f"{missed} of {len(ratios)} cases miss")
    return missed


if __name__ == "__main__":
    if sys.argv[1:2] == ["limits"]:
        sys.exit(1 if load_limits.main(sys.argv[2:]) else 0)
    if sys.argv[1:2] == ["power"]:
        sys.exit(power.main(sys.argv[2:]))
    if sys.argv[1:2] == ["closing"]:
        sys.exit(closing.main())
    sys.exit(1 if main(sys.argv[1:]) else 0)
