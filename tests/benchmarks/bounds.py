"""How long the bound without compliance takes: directions of random loads on five fingers.

python -m tests.benchmarks.bounds
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time

import numpy as np

import handlcp as hl
from tests.support.margins import bounds

__all__ = ["main"]

_COUNT = 1000


def main() -> None:
    """Prints seconds of the processor for 1,000 directions, and the worst gap."""
    rng = np.random.default_rng(1)
    contacts = []
    for a in 2 * np.pi * np.arange(5) / 5:
        out = np.array([np.cos(a), np.sin(a), 0.2 * np.sin(3 * a)])
        normal = -out / np.linalg.norm(out) + 0.1 * rng.normal(size=3)
        contacts.append(hl.Contact(0.03 * out, normal / np.linalg.norm(normal), hl.Coulomb(0.5)))
    grasp = hl.Grasp(contacts, flexibility=1e-4, effects=[hl.FingerForceBound(5.0)])
    wrenches = rng.normal(size=(_COUNT, 6)) * ([1.0] * 3 + [0.03] * 3)
    for faces in (8, "cone"):
        start = time.process_time()
        found = bounds(grasp, wrenches, faces, (0, 0, -2.0, 0, 0, 0))
        spent = time.process_time() - start
        told = f"{_COUNT} directions in {spent:.2f} s of one core, worst gap {found.gaps.max():.1e}"
        print(f"faces {faces}: {told}")


if __name__ == "__main__":
    main()
