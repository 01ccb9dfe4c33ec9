"""Load limits that fall where friction or a torque limit grows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tests.paths.corpus import Case, cases
from tests.paths.same import factor_of

MORE = 1.1
FALL = 1e-3  # of the factor: what falls by less is not told


def falls(case: Case, direction: int) -> Iterator[tuple[str, float, float]]:
    """(what grew, factor before, factor after) where the limit falls along one direction."""
    way = case.directions[direction]
    more = {"friction": case.recipe.rubbed(MORE), "torque limits": case.recipe.stronger(MORE)}
    first = factor_of(case, way)
    if not first > 0.0:
        return
    for what, recipe in more.items():
        if recipe is None:
            continue
        then = factor_of(case.changed(recipe), way)
        if then < (1.0 - FALL) * first or np.isnan(then):
            yield what, first, then


def measure(grasps: int, directions: int, seed: int = 0, start: int = 0) -> int:
    """Print every limit that falls; their number."""
    found, asked = 0, 0
    for case in cases(grasps, seed, start):
        for k in range(directions):
            asked += 1
            for what, first, then in falls(case, k):
                found += 1
                where = f"({case.seed}, {case.number}, {k}) {case.name}"
                fall = 100 * (1.0 - then / first) if np.isfinite(first) else 100.0
                print(
                    f"{where}: {MORE:g} times the {what}: {first:.5g}, then {then:.5g}, {fall:.1f} % less", flush=True
                )
    print(f"{found} limits fall, of {asked} directions of {grasps} grasps")
    return found
