"""Load limits beside MuJoCo: a load that grows slowly until the object is lost, or a joint is at its torque limit
or at an end of its range.

`python -m tests.mujoco limits [word ...]` runs every case, or those whose hand or name holds a word; exit 1 for a miss.
`python -m tests.mujoco limits --truth [word ...]` asks whether MuJoCo says the same twice as slowly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

import handlcp as hl
from handlcp.simulator import SimulatedLimit, simulate_limit
from tests.mujoco.case import SLIDES
from tests.mujoco.cases import CAN, five, scene, three

NEAR = 0.03  # of the factor
BEYOND = 1.25  # times what is expected: how far MuJoCo's load grows
OPEN = {"slips", "opens"}
HEAD = f"{'hand':14s} {'load':16s} {'handlcp':>9s} {'MuJoCo':>9s} {'apart':>7s} {'took':>16s}  gives out first"


@dataclass(frozen=True)
class LimitCase:
    """make : the grasp. direction (6,) : of the load that grows. short : whether the default suite runs it."""

    hand: str
    name: str
    make: Callable[[], Any]
    direction: tuple[float, ...]
    short: bool = False

    def ours(self) -> Any:
        """The load limit, with the hand followed."""
        return self.make().load_limit(self.direction, geometry="followed")

    def theirs(self, expected: float, seconds: float = 8.0) -> SimulatedLimit:
        """The same in MuJoCo, which goes somewhat beyond what is expected."""
        return simulate_limit(self.make(), self.direction, BEYOND * expected, seconds=seconds, settings=SLIDES)


def apart(ours: Any, theirs: SimulatedLimit) -> float:
    """Of the factors, as a share of MuJoCo's."""
    return float(ours.factor / theirs.factor - 1.0) if theirs.factor > 0.0 else float("inf")


def misses(ours: Any, theirs: SimulatedLimit) -> list[str]:
    """What does not agree, in words: the factor, the joint at its limit, the fingers that let the object go."""
    wrong = []
    if not abs(apart(ours, theirs)) <= NEAR:
        wrong.append(f"factor {100 * apart(ours, theirs):+.1f} %")
    joints = {b.who for b in ours.binds if b.kind in ("torque", "range")}
    if joints != ({theirs.joint} if theirs.joint else set()):
        wrong.append(f"joints at their limits: {sorted(joints)} here, {theirs.joint or 'none'} in MuJoCo")
    fingers = {b.who for b in ours.binds if b.kind in OPEN}
    if more := fingers - {*theirs.slides, *theirs.gone}:
        wrong.append(f"{', '.join(sorted(more))} hold in MuJoCo")
    return wrong


def row(case: LimitCase, ours: Any, theirs: SimulatedLimit, seconds: float) -> str:
    """One line of the table."""
    cause = theirs.joint or ", ".join([*theirs.slides, *(f"{name} (open)" for name in theirs.gone)])
    numbers = f"{ours.factor:9.4f} {theirs.factor:9.4f} {100 * apart(ours, theirs):+6.2f}%"
    return f"{case.hand:14s} {case.name:16s} {numbers} {1e3 * seconds:5.0f} ms {theirs.seconds:5.1f} s  {cause}"


def main(words: list[str]) -> int:
    """Print the table and what it comes to; how many cases miss."""
    if words[:1] == ["--truth"]:
        return truth(words[1:])
    missed, errors = 0, list[float]()
    print(HEAD, flush=True)
    for case in chosen(words):
        began = perf_counter()
        ours = case.ours()
        took = perf_counter() - began
        theirs = case.theirs(ours.factor)
        wrong = misses(ours, theirs)
        missed += bool(wrong)
        errors.append(abs(apart(ours, theirs)))
        print(row(case, ours, theirs, took) + (f"  MISS: {'; '.join(wrong)}" if wrong else ""), flush=True)
    if errors:
        hands = len({case.hand for case in chosen(words)})
        print(f"{len(errors)} loads of {hands} hands: {100 * np.median(errors):.2f} % in the median,", end=" ")
        print(f"{100 * max(errors):.2f} % at most; {missed} miss")
    return missed


def truth(words: list[str]) -> int:
    """Print by how much MuJoCo's limits change when the load grows half as fast; 0."""
    print(f"{'hand':14s} {'load':16s} {'8 s':>9s} {'16 s':>9s} {'change':>8s}", flush=True)
    for case in chosen(words):
        expected = case.ours().factor
        one, other = (case.theirs(expected, seconds).factor for seconds in (8.0, 16.0))
        print(f"{case.hand:14s} {case.name:16s} {one:9.4f} {other:9.4f} {100 * (other / one - 1):+7.2f}%", flush=True)
    return 0


def chosen(words: list[str]) -> list[LimitCase]:
    """Cases whose hands or names hold one of the words; all without words."""
    return [c for c in CASES if not words or any(word in f"{c.hand} {c.name}" for word in words)]


def ball() -> Any:
    """Three fingers around a ball of 50 g."""
    return three(hl.Sphere(0.03, [0, 0, 0.08], mass=0.05))


def can() -> Any:
    """Three stiffer fingers around a can of 50 g; their joints bear 0.8 N·m."""
    return three(CAN, K=20.0)


def closed_five() -> Any:
    """Five fingers around a ball of 300 g, closed 3 mm."""
    return five(6.0, 0.003)


WAYS = {
    "+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0), "+z": (0, 0, 1), "-z": (0, 0, -1),
    "oblique, up": (0.6, 0.5, 0.62), "oblique, down": (-0.6, 0.5, -0.62),
}  # fmt: skip
SHORT = {("three_finger", "ball -z"), ("allegro", "ball +x"), ("three_finger", "can +x")}


def along(hand: str, what: str, make: Callable[[], Any], *left_out: str) -> list[LimitCase]:
    """A case for each way but those left out."""
    return [
        LimitCase(hand, f"{what} {way}", make, (*force, 0.0, 0.0, 0.0), (hand, f"{what} {way}") in SHORT)
        for way, force in WAYS.items()
        if way not in left_out
    ]


CASES = (
    # Along -x symmetry breaks: which of two fingers slips is chance
    *along("three_finger", "ball", ball, "-x"),
    *along("three_finger", "can", can, "-x"),
    *along("five_finger", "ball", closed_five),
    *along("allegro", "ball", lambda: scene("allegro_pinch", 0.003)),
    *along("psyonic", "can", lambda: scene("psyonic_grasp", 0.003), "oblique, down"),  # it snaps on its way
)
