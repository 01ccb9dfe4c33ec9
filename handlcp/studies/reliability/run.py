"""`run_samples`: all samples of a run, slice by slice: placed, solved, counted and kept."""

from __future__ import annotations

import hashlib
import io
import json
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.stats import qmc

from handlcp.check import Array
from handlcp.contact.friction import Pyramid
from handlcp.errors import InputError, as_path, shorten_text
from handlcp.grasp.model.request import GraspSpec
from handlcp.hand.mechanism import HandMechanism
from handlcp.lcp.compiler.compile_policy import compile_in_background
from handlcp.progress import Progress, track_progress
from handlcp.read_file import MAX_ARRAY_BYTES, parse_json, read_arrays
from handlcp.studies.reliability.outcome import OUTCOME_WORDS, SOLVE, SampleOutcomes, check_samples, solve_samples
from handlcp.studies.reliability.sample_placer import SamplePlacer
from handlcp.studies.reliability.spread import MAX_RELATIVE_SPREAD, Dimension
from handlcp.version import VERSION
from handlcp.write_file import write_file

# ----------------------------------------------------------------
# A file that keeps what is done, so that an interrupted run goes on where it was.

_FIELDS = tuple([one.name for one in fields(SampleOutcomes)])
_FIELD_KINDS = {"codes": ("i", "integers"), "margin": ("f", "numbers")}


def make_question(spec: GraspSpec, dimensions: Sequence[Dimension], **more: Any) -> dict[str, Any]:
    """What a run answers, in words and digests that differ where the answer may."""
    spread = [[d.name, d.parameter, d.index, d.distribution.fingerprint] for d in dimensions]
    grasp: list[Any] = [spec.positions, spec.frames, spec.wrench, spec.reference, spec.flexibility, spec.offset]
    grasp += [[c.friction for c in spec.contacts], spec.plane, spec.fingers, spec.names]
    for e in spec.effects:
        grasp += [type(e).__name__, *[x for pair in sorted(vars(e).items()) for x in pair]]
    if (mechanism := spec.mechanism) is not None:
        grasp += [mechanism.jacobian, mechanism.compliance_factor, mechanism.limits]
    if isinstance(mechanism, HandMechanism):
        posture = mechanism.posture
        grasp += [posture.q, posture.hand.pads.blocks, mechanism.gravity, mechanism.stand_off, mechanism.target]
    return {"handlcp": VERSION, "grasp": _digest(*grasp), "spread": _digest(spread), **more}


def _digest(*parts: Any) -> str:
    made = hashlib.sha256()
    for part in parts:
        is_array = isinstance(part, np.ndarray)
        made.update(np.ascontiguousarray(part, dtype=float).tobytes() if is_array else f"{part!r}\n".encode())
    return made.hexdigest()[:16]


class ResumeFile:
    """The file of one run; None: nothing is kept.

    Raises InputError for a file of another question, or of no run at all.
    """

    def __init__(self, path: Any, question: dict[str, Any]) -> None:
        self.path, self.question = None if path is None else as_path("resume", path), question

    def load(self) -> SampleOutcomes | None:
        """What was done before; None where there is no such file yet."""
        if self.path is None or not self.path.exists():
            return None
        expected = "a file that an earlier run with resume= wrote, or a new one"
        found = read_arrays("resume", self.path, expected, MAX_ARRAY_BYTES)
        try:
            question = dict(parse_json(str(found["question"])))
            arrays = [found[name] for name in _FIELDS]
        except (ValueError, TypeError, KeyError) as error:
            raise InputError("resume", expected, f"{str(self.path)!r}: {shorten_text(error)}") from None
        names = dict.fromkeys((*self.question, *question))
        if other := next((name for name in names if self.question.get(name) != question.get(name)), None):
            raise InputError("resume", "a file of the same question", f"{str(self.path)!r} of another {other}")
        for name, array in zip(_FIELDS, arrays, strict=True):
            if why := _why_not_outcomes(name, array, arrays[0].shape[:1], self.question["samples"]):
                raise InputError("resume", expected, f"{str(self.path)!r} whose array {name!r} {why}")
        return SampleOutcomes(*arrays)

    def save(self, done: SampleOutcomes) -> None:
        """All that is done, at once: whoever reads the file sees the old one or the new one. Raises InputError."""
        if self.path is not None:
            out, arrays = io.BytesIO(), {name: getattr(done, name) for name in _FIELDS}
            np.savez(out, question=np.array(json.dumps(self.question)), **arrays)
            write_file("resume", self.path, out.getvalue())


def _why_not_outcomes(name: str, array: Any, shape: tuple[int, ...], most: int) -> str:
    """Why an array is not one of `SampleOutcomes` of this shape, of `most` samples in all; "": it is."""
    kind, what = _FIELD_KINDS.get(name, ("b", "truth values"))
    if array.dtype.kind != kind:
        return f"holds {array.dtype} in place of {what}"
    count = shape[0] if shape else 0
    if array.shape != (count,) or not 0 < count <= most:
        return f"has the shape {array.shape}, for {count} samples that are done of {most}"
    if name == "codes" and not ((array >= 0) & (array < len(OUTCOME_WORDS))).all():
        return f"has codes other than 0 to {len(OUTCOME_WORDS) - 1}"
    return ""


# ----------------------------------------------------------------
# Sobol points in blocks, each scrambled on its own.

MIN_BLOCKS = 16  # at least: their spread tells how far the estimate may be off


@dataclass(frozen=True, slots=True)
class SobolBlocks:
    """`count` blocks of `size` points each, a power of two, in so many dimensions."""

    seed: int
    dimensions: int
    size: int
    count: int

    @property
    def samples(self) -> int:
        """The number of samples in all blocks."""
        return self.size * self.count

    def points(self, begin: int, end: int) -> Array:
        """(end - begin, d) points of [0, 1), of samples in a row; the same on every call."""
        first, last = begin // self.size, -(-end // self.size)
        every = np.concatenate([_block_points(self, k) for k in range(first, last)])
        return every[begin - first * self.size : end - first * self.size]


@lru_cache(maxsize=1)  # of a large block many slices ask one after the other
def _block_points(blocks: SobolBlocks, k: int) -> Array:
    """(size, d) the points of block k."""
    rng = np.random.default_rng(np.random.SeedSequence(blocks.seed, spawn_key=(k,)))
    return np.asarray(qmc.Sobol(blocks.dimensions, scramble=True, seed=rng).random(blocks.size))


def make_blocks(seed: int, dimensions: int, samples: int) -> SobolBlocks:
    """With 16 to 32 blocks, and at least so many samples."""
    size = 2 ** int(math.log2(samples / MIN_BLOCKS))
    return SobolBlocks(seed, dimensions, size, -(-samples // size))


def sample_values(dimensions: Sequence[Dimension], points: Array) -> Array:
    """(m, d) values at points (m, d) of the unit cube."""
    return np.stack([d.distribution.values_at(u) for d, u in zip(dimensions, points.T, strict=True)], axis=1)


# ----------------------------------------------------------------

_SAMPLES_PER_SLICE = {SOLVE: 512, "check": 8}  # samples between two looks at the clock: long beside what a batch costs
_WRITE_INTERVAL = 2.0  # seconds between two writings of what is done
_DERIVATIVE_STEP = 1.0 / MAX_RELATIVE_SPREAD  # of the standard deviation, on either side, for a derivative


@dataclass(frozen=True, slots=True)
class JudgingMethod:
    """How a sample is judged. by : "solve" or "check". decide : about how many samples in all are solved in full where
    the first stage leaves them open. Each slice of samples has its share of these, rounded up.
    """

    by: str
    faces: int | str | Pyramid
    workers: int
    decide: int


def run_samples(
    placer: SamplePlacer, blocks: SobolBlocks, method: JudgingMethod, kept: ResumeFile, progress: Progress
) -> SampleOutcomes:
    """The outcomes of all samples, with those that were kept. Whatever ends it early, what is done is kept."""
    before = kept.load()
    parts, begin = ([], 0) if before is None else ([before], len(before.codes))
    size = _SAMPLES_PER_SLICE[method.by]
    quota = -(-method.decide * size // blocks.samples)

    def keep() -> float:
        """Write all that is done, and say when."""
        whole = [np.concatenate([getattr(part, name) for part in parts]) for name in _FIELDS]
        parts[:] = [SampleOutcomes(*whole)]
        kept.save(parts[0])
        return time.monotonic()

    written = time.monotonic()
    with track_progress("samples", blocks.samples, progress) as say, compile_in_background(blocks.samples):
        say(begin)
        try:
            for at in range(begin, blocks.samples, size):
                end = min(at + size, blocks.samples)
                values = sample_values(placer.dimensions, blocks.points(at, end))
                if method.by == SOLVE:
                    parts.append(solve_samples(placer, values, method.faces, method.workers, quota))
                else:
                    parts.append(check_samples(placer.place_samples(values), method.faces))
                say(end - at)
                if time.monotonic() - written > _WRITE_INTERVAL:
                    written = keep()
        finally:
            if parts:
                keep()
    return parts[0]


def margin_slopes(placer: SamplePlacer, method: JudgingMethod) -> Array:
    """(d,) change of the margin with one standard deviation of each value, from central differences at the means;
    one-sided where only one side holds, NaN where none does. Each is of single solves, whatever `method.by` is.
    Where `solution.sensitivity()` has the same derivative it is the same number: this one is of whatever varies.
    """
    laws = [d.distribution for d in placer.dimensions]
    middle, steps = np.array([law.mean for law in laws]), np.diag([_DERIVATIVE_STEP * law.sd for law in laws])
    rows = np.concatenate([middle + steps, middle - steps, middle[None]])
    margin = solve_samples(placer, rows, method.faces, method.workers, 0).margin
    up, down, here = *margin[:-1].reshape(2, -1), margin[-1]
    central = (up - down) / (2.0 * _DERIVATIVE_STEP)
    one_sided = np.where(np.isnan(down), up - here, here - down) / _DERIVATIVE_STEP
    return np.where(np.isnan(central), one_sided, central)
