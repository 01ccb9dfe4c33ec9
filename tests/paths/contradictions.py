"""Whether `follow` and `check` say of 0.95 and 1.05 of a load limit what the limit says."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

import handlcp as hl
from tests.paths.corpus import Case, cases
from tests.paths.recipes import FreeRecipe
from tests.paths.words import ORDERS, Word, checked, followed, limit_of, pressed

BELOW, BEYOND, FAR = 0.95, 1.05, 3.0
COUNTS = (10, 20, 40, 80, 160)
NEAR = 0.01
MOST_EVENTS = 30


@dataclass(frozen=True)
class Finding:
    """One contradiction. question : "follow", "check", "load_limit" or "events". share : of the limit's load."""

    case: Case
    direction: int
    question: str
    share: float
    said: str

    def __str__(self) -> str:
        where = f"({self.case.seed}, {self.case.number}, {self.direction})"
        return f"{where} {self.case.name}: {self.question} at {self.share:g} of the limit: {self.said}"


def contradictions(
    case: Case, direction: int, order: str = "staged", tally: Counter[str] | None = None
) -> list[Finding]:
    """What `follow` and `check` say otherwise than `load_limit` along one direction of a case. tally : is added to."""
    tally = Counter() if tally is None else tally
    way = case.directions[direction]
    try:
        limit = limit_of(case, way)
    except hl.HandLCPError as why:
        return [Finding(case, direction, "load_limit", 1.0, f"{type(why).__name__}: {why}")]
    found, binds = [], ", ".join(sorted({b.kind for b in limit.binds})) or "nothing"
    if len(limit.events) > MOST_EVENTS:
        found.append(Finding(case, direction, "events", 1.0, f"{len(limit.events)} events in load_limit"))
    if limit.factor == 0.0:
        tally["factor 0"] += 1
        return found
    if np.isinf(limit.factor):
        tally["no limit"] += 1
        asked = [(FAR, True, FAR * pressed(case) * way)]
    else:
        tally["a limit"] += 1
        asked = [(share, share < 1.0, share * limit.factor * way) for share in (BELOW, BEYOND)]
    for share, expected, load in asked:
        for question, word, events in _words(case, load, order):
            tally[question] += 1
            if events > MOST_EVENTS:
                found.append(Finding(case, direction, "events", share, f"{events} events in {question}"))
            if word.yes is None:
                tally["no word"] += 1
            elif word.yes is not expected:
                said = f"{word.said}; factor {limit.factor:.5g}, binds {binds}"
                found.append(Finding(case, direction, question, share, said))
    return found


def _words(case: Case, load: np.ndarray, order: str) -> Iterator[tuple[str, Word, int]]:
    """What each question says, and the number of events; where it is refused it has no word. A check follows a hand
    whose contacts move, and is not asked of one posture.
    """
    in_posture = case.geometry == "fixed" and not isinstance(case.recipe, FreeRecipe)
    for question, ask in (("follow", followed), ("check", checked)):
        if in_posture and question == "check":
            continue
        try:
            answer = ask(case, load, order)
            yield (question, answer, 0) if isinstance(answer, Word) else (question, answer[0], len(answer[1].events))
        except hl.HandLCPError as why:
            yield question, Word(None, f"{type(why).__name__}: {why}"), 0


def words_at(case: Case, load: np.ndarray) -> Iterator[tuple[str, Word]]:
    """What `follow` and `check` say of a load (6,)."""
    for question, word, _ in _words(case, load, ORDERS[0]):
        yield question, word


@dataclass(frozen=True)
class End:
    """How a loading ends. word : of the loading. at : share of its last stage up to which it is held. forces (n, 3):
    of its last step [N].
    """

    word: str
    stage: str
    at: float
    forces: np.ndarray

    def apart(self, other: End) -> float:
        """Relative difference to another one with the same word: of the forces where the load is held, else of the
        share at which it is lost; inf in another stage.
        """
        if self.word != "NOT HELD":
            return float(abs(self.forces - other.forces).max() / max(abs(other.forces).max(), 1e-300))
        return abs(self.at - other.at) / max(other.at, 1e-9) if self.stage == other.stage else np.inf


def ends_of_steps(case: Case, load: np.ndarray, counts: Iterable[int]) -> dict[int, End]:
    """The ends of one loading with so many steps a stage, by their number."""
    found = dict[int, End]()
    for n in counts:
        h = followed(case, load, steps=n)[1]
        last = h.stages[int(h.steps.stage[-1])]
        found[n] = End(h.word, last, float(h.held_to), np.asarray(h.steps.forces[-1]))
    return found


def steps_agree(case: Case, direction: int) -> list[Finding]:
    """Whether 10 to 160 steps a stage end the same, at 0.9 and at 1.2 of the limit: held, or lost at the same place,
    with the same forces.
    """
    way, found = case.directions[direction], list[Finding]()
    try:
        factor = limit_of(case, way).factor
        if factor == 0.0:
            return []
        shares = (FAR,) if np.isinf(factor) else (0.9, 1.2)
        size = pressed(case) if np.isinf(factor) else factor
        for share in shares:
            if said := ends_differ(ends_of_steps(case, share * size * way, COUNTS)):
                found.append(Finding(case, direction, "follow", share, said))
    except hl.HandLCPError as why:
        found.append(Finding(case, direction, "follow", 1.0, f"{type(why).__name__}: {why}"))
    return found


def ends_differ(ends: dict[int, End]) -> str:
    """How ends by their number of steps differ from the one with most; "": they do not."""
    if len({end.word for end in ends.values()}) > 1:
        return "; ".join(f"{n} steps: {end.word} to {end.at:.4f} of {end.stage}" for n, end in ends.items())
    best = ends[max(ends)]
    off = {n: end.apart(best) for n, end in ends.items()}
    if max(off.values()) <= NEAR:
        return ""
    what = "load that is lost off by" if best.word == "NOT HELD" else "forces at the end off by"
    return f"{what} " + ", ".join(f"{100 * x:.2f} % ({n} steps)" for n, x in off.items() if x > NEAR)


def measure(grasps: int, directions: int, steps: bool, order: str, jobs: int, seed: int = 0, start: int = 0) -> int:
    """Print every contradiction and a summary; the number of contradictions."""
    begun, found, tally, asked = time.perf_counter(), list[Finding](), Counter[str](), 0
    for told, counted in _each(cases(grasps, seed, start), directions, steps, order, jobs):
        asked, tally, found = asked + 1, tally + counted, found + told
        for finding in told:
            print(finding, flush=True)
    by = Counter(f.question + f" at {f.share:g}" for f in found)
    grasps_with = len({(f.case.seed, f.case.number) for f in found})
    loads_with = len({(f.case.seed, f.case.number, f.direction) for f in found})
    print(f"{asked} grasps, {dict(tally)}, {time.perf_counter() - begun:.0f} s")
    print(f"{len(found)} contradictions in {loads_with} limits of {grasps_with} grasps: {dict(by)}")
    return len(found)


def _each(
    every: Iterator[Case], directions: int, steps: bool, order: str, jobs: int
) -> Iterator[tuple[list[Finding], Counter[str]]]:
    """Findings and tallies of each grasp."""
    if jobs == 1:
        yield from (_one(case, directions, steps, order) for case in every)
        return
    from joblib import Parallel, delayed

    work = Parallel(n_jobs=jobs, return_as="generator")
    yield from work(delayed(_one)(case, directions, steps, order) for case in every)


def _one(case: Case, directions: int, steps: bool, order: str) -> tuple[list[Finding], Counter[str]]:
    tally, found = Counter[str](), list[Finding]()
    for k in range(min(directions, len(case.directions))):
        found += steps_agree(case, k) if steps else contradictions(case, k, order, tally)
    return found, tally
