"""`run_samples`: all samples of a run, slice by slice: placed, solved, counted and kept."""

from __future__ import annotations

import hashlib
import io
import json
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
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
from handlcp.studies.reliability.outcome import (
    OUTCOME_WORDS,
    SOLVE,
    SampleOutcomes,
    check_samples,
    fill_unplaced,
    join_outcomes,
    solve_samples,
)
from handlcp.studies.reliability.sample_placer import SamplePlacer
from handlcp.studies.reliability.spread import MAX_RELATIVE_SPREAD, Dimension
from handlcp.version import VERSION
from handlcp.write_file import write_file

# ----------------------------------------------------------------
# A file that keeps what is done, so that an interrupted run goes on where it was.

_STORED_FIELDS = ("codes", "margin", "again", "unplaced", "far")


def make_question(spec: GraspSpec, dimensions: Sequence[Dimension], **more: Any) -> dict[str, Any]:
    """What a run answers, in words and digests that differ where the answer may."""
    spread = [[d.name, d.parameter, d.index, d.distribution.fingerprint] for d in dimensions]
    return {"handlcp": VERSION, "grasp": _digest_spec(spec), "spread": _digest_data(json.dumps(spread)), **more}


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
            arrays = [found[name] for name in _STORED_FIELDS]
        except (ValueError, TypeError, KeyError) as error:
            raise InputError("resume", expected, f"{str(self.path)!r}: {shorten_text(error)}") from None
        names = [name for name in (*self.question, *question) if self.question.get(name) != question.get(name)]
        if others := list(dict.fromkeys(names)):
            raise InputError("resume", "a file of the same question", f"{str(self.path)!r} of another {others[0]}")
        for name, array in zip(_STORED_FIELDS, arrays, strict=True):
            if why := _why_not_outcomes(name, array, len(arrays[0]) if arrays[0].ndim else 0, self.question["samples"]):
                raise InputError("resume", expected, f"{str(self.path)!r} whose array {name!r} {why}")
        return SampleOutcomes(*arrays)

    def save(self, done: SampleOutcomes) -> None:
        """All that is done, at once: whoever reads the file sees the old one or the new one. Raises InputError."""
        if self.path is None:
            return
        out, arrays = io.BytesIO(), {name: getattr(done, name) for name in _STORED_FIELDS}
        np.savez(out, question=np.array(json.dumps(self.question)), **arrays)
        write_file("resume", self.path, out.getvalue())


def _why_not_outcomes(name: str, array: Any, count: int, most: int) -> str:
    """Why an array is not one of `SampleOutcomes` of `count` samples, of `most` in all; "": it is."""
    kind = {"codes": "i", "margin": "f"}.get(name, "b")
    if array.dtype.kind != kind:
        return f"holds {array.dtype} in place of {dict(i='integers', f='numbers', b='truth values')[kind]}"
    if array.shape != (count,) or not 0 < count <= most:
        return f"has the shape {array.shape}, for {count} samples that are done of {most}"
    if name == "codes" and not ((array >= 0) & (array < len(OUTCOME_WORDS))).all():
        return f"has codes other than 0 to {len(OUTCOME_WORDS) - 1}"
    return ""


def _digest_spec(spec: GraspSpec) -> str:
    """A digest of everything in a grasp that its answer depends on."""
    arrays = [spec.positions, spec.frames, spec.wrench, spec.reference, spec.flexibility, spec.offset]
    said = [repr([c.friction for c in spec.contacts]), repr(spec.plane), repr(spec.fingers), repr(spec.names)]
    for e in spec.effects:
        said.append(type(e).__name__)
        for name, value in sorted(vars(e).items()):
            arrays += [value] if isinstance(value, np.ndarray) else []
            said.append(f"{name}={value!r}" if not isinstance(value, np.ndarray) else name)
    mechanism = spec.mechanism
    if mechanism is not None:
        arrays += [mechanism.jacobian, mechanism.compliance_factor, mechanism.limits]
    if isinstance(mechanism, HandMechanism):
        arrays += [mechanism.posture.q, mechanism.posture.hand.pads.blocks, mechanism.gravity, mechanism.stand_off]
        said.append(repr(mechanism.target))
    return _digest_data("\n".join(said), *arrays)


def _digest_data(text: str, *arrays: Any) -> str:
    made = hashlib.sha256(text.encode())
    for a in arrays:
        made.update(np.ascontiguousarray(a, dtype=float).tobytes())
    return made.hexdigest()[:16]


# ----------------------------------------------------------------
# Sobol points in blocks, each scrambled on its own.

MIN_BLOCKS = 16  # at least: their spread tells how far the estimate may be off


class SobolBlocks:
    """`count` blocks of `size` points each, a power of two, in d dimensions."""

    def __init__(self, seed: int, dimensions: int, size: int, count: int) -> None:
        self.seed, self.dimensions, self.size, self.count = seed, dimensions, size, count
        self._last_block: tuple[int, Array] | None = None  # the block that was asked for last, which slices share

    @property
    def samples(self) -> int:
        """The number of samples in all blocks."""
        return self.size * self.count

    def block_points(self, k: int) -> Array:
        """(size, d) points of [0, 1), the same on every call."""
        if self._last_block is not None and self._last_block[0] == k:
            return self._last_block[1]
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(k,)))
        made = np.asarray(qmc.Sobol(self.dimensions, scramble=True, seed=rng).random(self.size))
        self._last_block = k, made
        return made

    def points(self, begin: int, end: int) -> Array:
        """(end - begin, d) of samples in a row."""
        first, last = begin // self.size, -(-end // self.size)
        every = np.concatenate([self.block_points(k) for k in range(first, last)])
        return every[begin - first * self.size : end - first * self.size]


def make_blocks(seed: int, dimensions: int, samples: int) -> SobolBlocks:
    """With 16 to 32 blocks, and at least so many samples."""
    size = 2 ** int(math.log2(samples / MIN_BLOCKS))
    return SobolBlocks(seed, dimensions, size, -(-samples // size))


# ----------------------------------------------------------------

_SAMPLES_PER_SLICE = {SOLVE: 512, "check": 8}  # samples between two looks at the clock: long beside what a batch costs
_WRITE_INTERVAL = 2.0  # seconds between two writings of what is done
_DERIVATIVE_STEP = 1.0 / MAX_RELATIVE_SPREAD  # of the standard deviation, on either side, for a derivative


@dataclass(frozen=True, slots=True)
class JudgingMethod:
    """How a sample is judged. by : "solve" or "check". decide : how many samples in all are solved in full where the
    first stage leaves them.
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
    parts = [] if before is None else [before]
    begin = 0 if before is None else len(before.codes)
    size = _SAMPLES_PER_SLICE[method.by]
    quota = -(-method.decide * size // blocks.samples)
    written = time.monotonic()
    with track_progress("samples", blocks.samples, progress) as say, compile_in_background(blocks.samples):
        say(begin)
        try:
            for at in range(begin, blocks.samples, size):
                end = min(at + size, blocks.samples)
                parts.append(_judge_slice(placer, blocks.points(at, end), method, quota))
                say(end - at)
                if time.monotonic() - written > _WRITE_INTERVAL:
                    parts = [join_outcomes(parts)]
                    kept.save(parts[0])
                    written = time.monotonic()
        finally:
            if parts:
                parts = [join_outcomes(parts)]
                kept.save(parts[0])
    return parts[0]


def _judge_slice(placer: SamplePlacer, points: Array, method: JudgingMethod, quota: int) -> SampleOutcomes:
    return _judge_samples(placer, sample_values(placer.dimensions, points), method, quota)


def _judge_samples(
    placer: SamplePlacer, rows: Array, method: JudgingMethod, quota: int, by: str | None = None
) -> SampleOutcomes:
    """Judge samples with values (m, d), SI units. quota : how many are solved in full. by : None: the method's."""
    if (method.by if by is None else by) == SOLVE:
        return solve_samples(placer, rows, method.faces, method.workers, quota)
    every = placer.place_samples(rows)
    placed = np.array([one.why_not is None for one in every])
    return fill_unplaced(check_samples([one.grasp for one in every if one.why_not is None], method.faces), placed)


def sample_values(dimensions: Sequence[Dimension], points: Array) -> Array:
    """(m, d) values at points (m, d) of the unit cube."""
    return np.stack([d.distribution.values_at(u) for d, u in zip(dimensions, points.T, strict=True)], axis=1)


def margin_slopes(placer: SamplePlacer, method: JudgingMethod) -> Array:
    """(d,) change of the margin with one standard deviation of each value, from central differences at the means;
    one-sided where only one side holds, NaN where none does. Where `solution.sensitivity()` has the same derivative it
    is the same number: this one is of whatever varies.
    """
    laws = [d.distribution for d in placer.dimensions]
    d, middle = len(laws), np.array([law.mean for law in laws])
    steps = np.diag([_DERIVATIVE_STEP * law.sd for law in laws])
    rows = np.concatenate([middle + steps, middle - steps, middle[None]])
    margin = _judge_samples(placer, rows, method, 0, SOLVE).margin
    up, down, here = margin[:d], margin[d : 2 * d], margin[-1]
    central = (up - down) / (2.0 * _DERIVATIVE_STEP)
    one_sided = np.where(np.isnan(down), up - here, here - down) / _DERIVATIVE_STEP
    return np.where(np.isnan(central), one_sided, central)
