"""Whether a grasp has the same answer however it is asked.

Words of `follow` and `check` at 0.95 and 1.05 of the load limit are those of the limit. A loading ends the same,
whatever number of steps is asked for. The limit is the same with its fingers in another order, in other units, in a
turned world, with noise of 1e-9, after other questions, and with compiled and interpreted kernels.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

import handlcp as hl
from tests.paths.contradictions import BELOW, BEYOND, FAR, ends_of_steps, words_at
from tests.paths.corpus import Case, case_of, cases, grasp_of, held
from tests.paths.recipes import FreeRecipe, HandRecipe, spun, turn
from tests.paths.time_limit import TookTooLong, at_most
from tests.paths.words import limit_of, pressed

ENOUGH = 1e-6
STEPS = (2, 3, 5, 8, 40, 160)
NEAR = 2e-3  # two ends whose relative error is 1e-3 each, which is the tolerance of a loading unless another is asked
NOISE = 1e-9  # of the load sideways, of friction and of the squeeze
FORCE, LENGTH = 4.4482216, 0.0254  # pounds and inches
ASKED = ("words", "steps", "variants")
SPREAD = 5  # of 12 directions: numbers that follow each other are forces, mixed loads and moments


@dataclass(frozen=True)
class Variant:
    """The same question, put otherwise. name : what differs. way (6,) : the load. length : of a metre, in its units."""

    name: str
    case: Case
    way: np.ndarray
    length: float = 1.0


@dataclass(frozen=True)
class Comparison:
    """Two answers to one question. question : the property that they share. off : relative difference of the two; inf:
    of another kind; NaN: there was no answer. enough : what it may be. said : both, in words.
    """

    question: str
    case: Case
    direction: int
    off: float
    enough: float
    said: str

    @property
    def agrees(self) -> bool:
        """Whether the answers are the same. Where one is missing they are not."""
        return self.off <= self.enough

    def __str__(self) -> str:
        asked = f"{self.case.rebuilt}, direction {self.direction} ({self.case.name})"
        return f"{self.question}: {self.said}\n    {asked}"


def variants(case: Case, direction: int) -> Iterator[Variant]:
    """The question of a case and a direction, put in all ways that must not matter in one process. Fingertips with
    pyramids have them along the world's axes, unless friction says which way: a turned world is another grasp there.
    """
    rng, way = np.random.default_rng([case.seed, case.number, direction, 7]), case.directions[direction]
    recipe = case.recipe
    across = np.cross(way.reshape(2, 3), rng.normal(size=3))
    across *= NOISE * np.linalg.norm(way) / np.linalg.norm(across)
    yield Variant("1e-9 of the load sideways", case, way + across.ravel())
    noisy = recipe.rubbed(1.0 + NOISE * rng.uniform(-1, 1)).squeezed(1.0 + NOISE * rng.uniform(-1, 1))
    yield Variant("1e-9 of friction and squeeze", case.changed(noisy), way)
    if (permuted := recipe.permuted(rng)) is not None:
        yield Variant("fingers permuted", case.changed(permuted), way)
    if (other := recipe.in_units(FORCE, LENGTH)) is not None:
        length = 1.0 / LENGTH if isinstance(recipe, FreeRecipe) else 1.0
        in_units = np.append(way[:3], way[3:] * length) / FORCE
        yield Variant("other units", case.changed(other), in_units, length)
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


# ---------------------------------------------------------------- one grasp and direction
def compare_words(case: Case, direction: int, factor: float) -> Iterator[Comparison]:
    """What `follow` and `check` say of loads below and beyond a limit, beside the limit."""
    way = case.directions[direction]
    if factor == 0.0:
        return
    shares = (BELOW, BEYOND) if np.isfinite(factor) else (FAR,)
    size = factor if np.isfinite(factor) else pressed(case)
    for share in shares:
        for question, word in words_at(case, share * size * way):
            expected = share < 1.0 or not np.isfinite(factor)
            off = np.nan if word.yes is None else 0.0 if word.yes is expected else np.inf
            name = f"{question} at {share:g} of the limit"
            yield Comparison(name, case, direction, off, 0.0, f"{word.said}; limit {factor:.5g}")


def compare_steps(case: Case, direction: int, factor: float, counts: tuple[int, ...] = STEPS) -> Iterator[Comparison]:
    """How loadings to 0.95 and 1.05 of a limit end by their steps, beside the one with the most."""
    if factor == 0.0 or not np.isfinite(factor):
        return
    for share in (BELOW, BEYOND):
        ends = ends_of_steps(case, share * factor * case.directions[direction], counts)
        words = {n: end.word for n, end in ends.items()}
        same = len(set(words.values())) == 1
        said = ", ".join(f"{n}: {word}" for n, word in words.items())
        yield Comparison(f"2 to 160 steps, word at {share:g}", case, direction, 0.0 if same else np.inf, 0.0, said)
        best = ends[max(ends)]
        off = {n: end.apart(best) for n, end in ends.items() if end.word == best.word}
        said = ", ".join(f"{n}: {x:.1e}" for n, x in off.items())
        what = "forces" if best.word == "HELD" else "load that is lost"
        yield Comparison(f"2 to 160 steps, {what} at {share:g}", case, direction, max(off.values()), NEAR, said)


def compare_variants(case: Case, direction: int, factor: float) -> Iterator[Comparison]:
    """The limit beside those of all variants."""
    for variant in variants(case, direction):
        other = factor_of(variant.case, variant.way, variant.length)
        said = f"{factor:.9g}, then {other:.9g}"
        yield Comparison(variant.name, case, direction, apart(factor, other), ENOUGH, said)


COMPARE: dict[str, Callable[[Case, int, float], Iterator[Comparison]]] = {
    "words": compare_words, "steps": compare_steps, "variants": compare_variants
}  # fmt: skip


def comparisons(case: Case, direction: int, asked: Iterable[str] = ASKED, seconds: float = np.inf) -> list[Comparison]:
    """All of them along one direction, in the case's geometry. What takes longer than so many seconds, or raises, is
    one comparison without an answer.
    """
    found = list[Comparison]()
    try:
        with at_most(seconds):
            factor = factor_of(case, case.directions[direction])
        if np.isnan(factor):
            return [Comparison("a limit is found", case, direction, np.nan, 0.0, "refused")]
    except TookTooLong as why:
        return [Comparison("a limit is found", case, direction, np.nan, 0.0, str(why))]
    for name in asked:
        try:
            with at_most(seconds):
                for comparison in COMPARE[name](case, direction, factor):
                    found.append(comparison)
        except (TookTooLong, hl.HandLCPError) as why:
            found.append(Comparison(f"{name}: an answer", case, direction, np.nan, 0.0, f"{type(why).__name__}: {why}"))
    return found


# ---------------------------------------------------------------- many
def geometries(case: Case) -> tuple[Case, ...]:
    """The case in its geometry and, of a hand, in that of its posture, too."""
    return (case,) if case.geometry == "fixed" else (case, case.in_posture())


def directions_of(case: Case, count: int) -> list[int]:
    """So many of its directions, others from case to case."""
    return [(case.number + SPREAD * k) % len(case.directions) for k in range(count)]


def print_summary(found: list[Comparison], worst: int) -> int:
    """Print how many agree by property and geometry, and the worst that do not; the number of those."""
    rows: dict[tuple[str, str], list[Comparison]] = {}
    for x in found:
        rows.setdefault((x.case.geometry, x.question), []).append(x)
    width = max((len(question) for _, question in rows), default=0)
    print(f"\n{'':{width}}  geometry  asked  agree  no answer      worst  where")
    for (geometry, question), each in sorted(rows.items(), key=lambda row: (row[0][1], row[0][0])):
        agree, open_ = sum(x.agrees for x in each), sum(np.isnan(x.off) for x in each)
        last = max(each, key=lambda x: (not x.agrees, -1.0 if np.isnan(x.off) else x.off))
        where = "" if last.agrees else f"{last.case.rebuilt}, direction {last.direction}"
        print(f"{question:{width}}  {geometry:8}  {len(each):5}  {agree:5}  {open_:9}  {last.off:9.1e}  {where}")
    differ = [x for x in found if not x.agrees]
    differ.sort(key=lambda x: -np.inf if np.isnan(x.off) else -x.off / max(x.enough, 1e-300))
    if differ:
        print(f"\n{len(differ)} of {len(found)} differ; of each property the worst {worst}:")
    told: dict[str, int] = {}
    for x in differ:
        told[x.question] = told.get(x.question, 0) + 1
        if told[x.question] <= worst:
            print(x)
    return len(differ)


def measure(
    count: int, directions: int, kernels: int, seconds: float, minutes: float, worst: int, ask: str, seed: int = 0,
    start: int = 0,
) -> int:  # fmt: skip
    """Ask `count` grasps of `corpus.grasp_of`, from index `start` on, and print what differs; the number of that.
    kernels : of how many limits compiled and interpreted code are compared, which takes long. minutes : of the
    processor, after which no other grasp is begun.
    """
    found, left_out, end = list[Comparison](), 0, start + count
    for index in range(start, start + count):
        if time.process_time() > 60.0 * minutes:
            end = index
            break
        case = grasp_of(seed, index)
        known = seed == 0 and case.source == "case_of"
        if not (known or _holds_in(case, seconds)):
            left_out += 1
            continue
        each = [
            x
            for asked in geometries(case)
            for k in directions_of(case, directions)
            for x in comparisons(asked, k, ask.split(","), seconds)
        ]
        differ = sum(not x.agrees for x in each)
        print(f"{index}: {case.rebuilt} {case.name}: {differ} of {len(each)} differ", flush=True)
        found += each
    found += _beside_interpreted(kernels, seed, start)
    differ = print_summary(found, worst)
    print(f"grasps {start} to {end - 1}; {left_out} of them do not hold their squeeze and weight and are left out")
    return differ


def _holds_in(case: Case, seconds: float) -> bool:
    try:
        with at_most(seconds):
            return held(case)
    except TookTooLong:
        return False


def _beside_interpreted(count: int, seed: int, start: int) -> list[Comparison]:
    every = list(cases(count, seed, start))
    numbers = [(case.seed, case.number, 0) for case in every]
    if not numbers:
        return []
    pair = [elsewhere(numbers, kind) for kind in ("compiled", "interpreted")]
    return [
        Comparison("interpreted beside compiled", case, 0, apart(a, b), ENOUGH, f"{a:.9g}, then {b:.9g}")
        for case, a, b in zip(every, *pair, strict=True)
    ]
