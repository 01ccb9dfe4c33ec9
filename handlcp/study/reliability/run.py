"""All samples of a run, slice by slice: placed, solved, counted and kept."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.batch.solve_many import Progress, told
from handlcp.grasp.friction import Pyramid
from handlcp.lcp.compiler.when import at_once
from handlcp.study.reliability.kept import Kept
from handlcp.study.reliability.outcome import SOLVE, Outcomes, among, checked, joined, solved
from handlcp.study.reliability.place import Placer
from handlcp.study.reliability.points import Blocks
from handlcp.study.reliability.spread import Dimension

_SLICE = {SOLVE: 512, "check": 8}  # samples between two looks at the clock: long beside what a batch costs
_OFTEN = 2.0  # seconds between two writings of what is done
_STEP = 0.01  # of the standard deviation, on either side, for a derivative


@dataclass(frozen=True, slots=True)
class Method:
    """How a sample is judged. by : "solve" or "check". decide : how many samples in all are solved in full where the
    first stage leaves them.
    """

    by: str
    faces: int | str | Pyramid
    workers: int | None
    decide: int


def run(placer: Placer, blocks: Blocks, method: Method, kept: Kept, progress: Progress) -> Outcomes:
    """The outcomes of all samples, with those that were kept. Whatever ends it early, what is done is kept."""
    before = kept.read()
    parts = [] if before is None else [before]
    begin = 0 if before is None else len(before.codes)
    size = _SLICE[method.by]
    quota = -(-method.decide * size // blocks.samples)
    written = time.monotonic()
    with told(progress, blocks.samples) as say, at_once(blocks.samples):
        say(begin)
        try:
            for at in range(begin, blocks.samples, size):
                end = min(at + size, blocks.samples)
                parts.append(_slice(placer, blocks.points(at, end), method, quota))
                say(end - at)
                if time.monotonic() - written > _OFTEN:
                    parts = [joined(parts)]
                    kept.write(parts[0])
                    written = time.monotonic()
        finally:
            if parts:
                parts = [joined(parts)]
                kept.write(parts[0])
    return parts[0]


def _slice(placer: Placer, points: Array, method: Method, quota: int) -> Outcomes:
    return _judged(placer, values_at(placer.dimensions, points), method, quota)


def _judged(placer: Placer, rows: Array, method: Method, quota: int, by: str | None = None) -> Outcomes:
    """Of samples with values (m, d). by : another way to judge them."""
    every = placer.placed(rows)
    placed = np.array([one.why_not is None for one in every])
    grasps = [one.grasp for one in every if one.why_not is None]
    if (method.by if by is None else by) == SOLVE:
        return among(solved(grasps, method.faces, method.workers, quota), placed)
    return among(checked(grasps, method.faces), placed)


def values_at(dimensions: Sequence[Dimension], points: Array) -> Array:
    """(m, d) values at points (m, d) of the unit cube."""
    return np.stack([d.law.at(u) for d, u in zip(dimensions, points.T, strict=True)], axis=1)


def slopes_of(placer: Placer, method: Method) -> Array:
    """(d,) change of the margin with one standard deviation of each value, from central differences at the means;
    one-sided where only one side holds, NaN where none does. Where `solution.sensitivity()` has the same derivative it
    is the same number: this one is of whatever varies.
    """
    laws = [d.law for d in placer.dimensions]
    d, middle = len(laws), np.array([law.mean for law in laws])
    steps = np.diag([_STEP * law.sd for law in laws])
    rows = np.concatenate([middle + steps, middle - steps, middle[None]])
    margin = _judged(placer, rows, method, 0, SOLVE).margin
    up, down, here = margin[:d], margin[d : 2 * d], margin[-1]
    central = (up - down) / (2.0 * _STEP)
    one_sided = np.where(np.isnan(down), up - here, here - down) / _STEP
    return np.where(np.isnan(central), one_sided, central)
