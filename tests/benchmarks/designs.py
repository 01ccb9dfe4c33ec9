"""What a sweep costs, and how well its rows rank designs beside searches of their own.

`python -m tests.benchmarks.designs [designs]`: three-finger hands of other lengths, palms and springs, three objects,
each under its weight in six directions and nine other loads, on all cores; 4,096 designs, or as many as asked for. Then
the best 20 by payload once more, each alone, with two seeds. Every row is searched, so none may hold less than its own
search with the same seed. Asked: that, and Spearman's rank correlation of the 20 at least 0.95.

`python -m tests.benchmarks.designs 256 part`: of one of the 16 cells that 4,096 designs fall into, so that neighbours
are as near to each other as among all of them.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from scipy.stats import spearmanr

import handlcp as hl

ALIKE = 0.95
BEST = 20
SEEDS = 0, 1
SPACE = {
    "proximal": (0.04, 0.06), "distal": (0.03, 0.05), "palm_radius": (0.03, 0.045),
    "joint_stiffness": (2.0, 8.0, "log"),
}  # fmt: skip
PART = {  # the lower half of each
    "proximal": (0.04, 0.05), "distal": (0.03, 0.04), "palm_radius": (0.03, 0.0375),
    "joint_stiffness": (2.0, 4.0, "log"),
}  # fmt: skip
LOADS = {
    "x": (1, 0, 0, 0, 0, 0), "-x": (-1, 0, 0, 0, 0, 0), "y": (0, 1, 0, 0, 0, 0), "-y": (0, -1, 0, 0, 0, 0),
    "up": (0, 0, 1, 0, 0, 0), "down": (0, 0, -1, 0, 0, 0), "roll": (0, 0, 0, 0.02, 0, 0),
    "pitch": (0, 0, 0, 0, 0.02, 0), "yaw": (0, 0, 0, 0, 0, 0.02),
}  # fmt: skip
BRIEF = hl.Brief(
    objects={
        "ball": hl.Sphere(0.03, mass=0.1), "box": hl.Box((0.04, 0.05, 0.08), mass=0.15),
        "can": hl.Cylinder(0.03, 0.1, mass=0.15),
    },
    loads=LOADS, friction=0.7, safety=1.2, grip_force=6.0,
)  # fmt: skip


def make(proximal: float, distal: float, palm_radius: float, joint_stiffness: float) -> hl.Hand:
    """A hand of these numbers."""
    return hl.finger_hand(
        link_lengths=(proximal, distal), palm_radius=palm_radius, joint_stiffness=joint_stiffness, torque_limits=1.5
    )


def payload(values: dict[str, float], seed: int) -> float:
    """What a design holds [kg], searched anew."""
    return hl.evaluate(make(**values), replace(BRIEF, seed=seed)).payload


def main(designs: int = 4096, space: dict[str, Any] = SPACE) -> int:
    """Print what was measured; 1 where a measure is missed."""
    began = time.perf_counter()
    study = hl.sweep(make, space, BRIEF, samples=designs)
    took = time.perf_counter() - began
    print(f"{designs} designs, {len(study.failed)} failed: {took:.0f} s, {designs / took:.2f} a second")
    print(study)
    for name in BRIEF.objects:
        along = np.mean([value is True for value in study.columns[f"objects.{name}.continued"]])
        held = np.mean([value == "HELD" for value in study.columns[f"objects.{name}.word"]])
        print(f"{name}: grasp brought along in {100 * along:.0f} % of the designs, held in {100 * held:.0f} %")
    best, payloads, begin = study.best(BEST), dict[str, list[float]](), time.perf_counter()
    payloads["swept"] = [row["payload_kg"] for row in best]
    anew = [delayed(payload)({k: row[k] for k in SPACE}, seed) for seed in SEEDS for row in best]
    found = Parallel(n_jobs=-1, batch_size=1, backend="multiprocessing")(anew)  # loky's pool is the sweep's
    for k, seed in enumerate(SEEDS):
        payloads[f"seed {seed}"] = found[k * len(best) : (k + 1) * len(best)]
    print(f"searched anew: {(time.perf_counter() - begin) / len(anew):.2f} s a design, on all cores")
    for name, values in payloads.items():
        print(f"payloads [kg], {name}: {np.round(values, 3).tolist()}")
    rank = float(spearmanr(payloads["swept"], payloads["seed 0"]).statistic)
    other = float(spearmanr(payloads["seed 0"], payloads["seed 1"]).statistic)
    print(f"rank correlation of the best {BEST}: {rank:.3f}; of two searches with each other: {other:.3f}")
    lower = sum(row < own * (1.0 - 1e-9) for row, own in zip(payloads["swept"], payloads["seed 0"], strict=True))
    print(f"rows that hold less than a search of their own: {lower}")
    return int(lower > 0 or rank < ALIKE)


if __name__ == "__main__":
    count, *part = sys.argv[1:] or ["4096"]
    sys.exit(main(int(count), PART if part == ["part"] else SPACE))
