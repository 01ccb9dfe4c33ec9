"""Whether the same question has the same answer: the load limit, whatever must not matter."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import handlcp as hl
from tests.paths.corpus import Case, case_of, cases
from tests.paths.recipes import HandRecipe, spun, turn
from tests.paths.words import limit_of

ENOUGH = 1e-6
SIDEWAYS = 1e-9  # of the load
FORCE, LENGTH = 4.4482216, 0.0254  # pounds and inches


@dataclass(frozen=True)
class Variant:
    """The same question, put otherwise. name : what differs. way (6,) : the load. length : of a metre, in its units."""

    name: str
    case: Case
    way: np.ndarray
    length: float = 1.0


def variants(case: Case, direction: int) -> Iterator[Variant]:
    """The question of a case and a direction, put in all ways that must not matter in one process. Fingertips with
    pyramids have them along the world's axes, unless friction says which way: a turned world is another grasp there.
    """
    rng, way = np.random.default_rng([case.seed, case.number, direction, 7]), case.directions[direction]
    recipe = case.recipe
    across = np.cross(way.reshape(2, 3), rng.normal(size=3))
    across *= SIDEWAYS * np.linalg.norm(way) / np.linalg.norm(across)
    yield Variant("1e-9 of the load sideways", case, way + across.ravel())
    yield Variant("fingers permuted", case.changed(recipe.permuted(rng)), way)
    length = 1.0 if isinstance(recipe, HandRecipe) else 1.0 / LENGTH
    in_units = np.append(way[:3], way[3:] * length) / FORCE
    yield Variant("other units", case.changed(recipe.in_units(FORCE, LENGTH)), in_units, length)
    Q = turn(rng)
    turned = recipe.turned(Q)
    axes = isinstance(recipe, HandRecipe) and case.faces != "cone" and recipe.law.kind != "anisotropic"
    if turned is not None and not axes:
        yield Variant("world turned", case.changed(turned), spun(Q, way))
    yield Variant("asked again after others", case.changed(recipe), way)


def factor_of(case: Case, way: np.ndarray, length: float = 1.0) -> float:
    """The load limit; NaN where the question is refused. length : of a metre, in the units of the case."""
    try:
        return float(limit_of(case, way, length).factor)
    except hl.HandLCPError:
        return float("nan")


def apart(a: float, b: float) -> float:
    """Relative difference of two factors; 0 where both are infinite or zero or refused."""
    if a == b or (np.isnan(a) and np.isnan(b)):
        return 0.0
    if not (np.isfinite(a) and np.isfinite(b)):
        return float("inf")
    return abs(a - b) / max(abs(a), abs(b))


def factors(numbers: list[tuple[int, int, int]]) -> list[float]:
    """The limits of (seed, number, direction), one after the other."""
    return [factor_of(case_of(s, k), case_of(s, k).directions[d]) for s, k, d in numbers]


def elsewhere(numbers: list[tuple[int, int, int]], kernels: str) -> list[float]:
    """The same in a process of its own, with kernels "compiled" or "interpreted"."""
    command = [sys.executable, "-c", "import sys, json; from tests.paths.same import factors; "
               "print(json.dumps(factors(json.loads(sys.argv[1]))))", json.dumps(numbers)]  # fmt: skip
    environment = os.environ | {"HANDLCP_KERNELS": kernels}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    return [float(x) for x in json.loads(done.stdout)]


def measure(grasps: int, directions: int, kernels: int, seed: int = 0, start: int = 0) -> int:
    """Print what differs, and the worst of each kind; the number of differences. kernels : of how many limits compiled
    and interpreted code are compared, which takes long.
    """
    worst: dict[str, tuple[float, str]] = {}
    found, asked = 0, 0

    def note(name: str, case: Case, direction: int, first: float, other: float) -> None:
        nonlocal found, asked
        off, where = apart(first, other), f"({case.seed}, {case.number}, {direction}) {case.name}"
        asked += 1
        if off > ENOUGH:
            found += 1
            print(f"{where}: {name}: {first:.9g}, then {other:.9g}, {off:.1e} apart", flush=True)
        worst[name] = max(worst.get(name, (0.0, "-")), (off, where))

    every = list(cases(grasps, seed, start))
    for case in every:
        for k in range(directions):
            first = factor_of(case, case.directions[k])
            for variant in variants(case, k):
                note(variant.name, case, k, first, factor_of(variant.case, variant.way, variant.length))
    numbers = [(case.seed, case.number, 0) for case in every[:kernels]]
    if numbers:
        pair = [elsewhere(numbers, kind) for kind in ("compiled", "interpreted")]
        for case, first, other in zip(every, *pair, strict=False):
            note("interpreted beside compiled", case, 0, first, other)
    for name, (off, where) in worst.items():
        print(f"worst of {name}: {off:.1e} at {where}")
    print(f"{found} of {asked} differ by more than {ENOUGH:g}")
    return found
