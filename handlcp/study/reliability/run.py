"""All samples of a run, slice by slice: placed, solved, counted and kept."""

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
from handlcp.errors import InputError, as_path, brief
from handlcp.grasp.model.request import GraspSpec
from handlcp.hand.mechanism import HandMechanism
from handlcp.lcp.compiler.compile_policy import compile_in_background
from handlcp.progress import Progress, told
from handlcp.read_file import MOST_ARRAYS, parse_json, read_arrays
from handlcp.study.reliability.outcome import SOLVE, WORDS, Outcomes, among, checked, joined, solved
from handlcp.study.reliability.place import Placer
from handlcp.study.reliability.spread import WIDEST, Dimension
from handlcp.version import VERSION
from handlcp.write_file import write_file

# ----------------------------------------------------------------
# A file that keeps what is done, so that an interrupted run goes on where it was.

_FIELDS = ("codes", "margin", "again", "unplaced", "far")


def question_of(spec: GraspSpec, dimensions: Sequence[Dimension], **more: Any) -> dict[str, Any]:
    """What a run answers, in words and digests that differ where the answer may."""
    spread = [[d.name, d.parameter, d.at, d.law.marks] for d in dimensions]
    return {"handlcp": VERSION, "grasp": _digest_of(spec), "spread": _digest(json.dumps(spread)), **more}


class Kept:
    """The file of one run; None: nothing is kept.

    Raises InputError for a file of another question, or of no run at all.
    """

    def __init__(self, path: Any, question: dict[str, Any]) -> None:
        self.path, self.question = None if path is None else as_path("resume", path), question

    def read(self) -> Outcomes | None:
        """What was done before; None where there is no such file yet."""
        if self.path is None or not self.path.exists():
            return None
        expected = "a file that an earlier run with resume= wrote, or a new one"
        found = read_arrays("resume", self.path, expected, MOST_ARRAYS)
        try:
            question = dict(parse_json(str(found["question"])))
            arrays = [found[name] for name in _FIELDS]
        except (ValueError, TypeError, KeyError) as error:
            raise InputError("resume", expected, f"{str(self.path)!r}: {brief(error)}") from None
        names = [name for name in (*self.question, *question) if self.question.get(name) != question.get(name)]
        if others := list(dict.fromkeys(names)):
            raise InputError("resume", "a file of the same question", f"{str(self.path)!r} of another {others[0]}")
        for name, array in zip(_FIELDS, arrays, strict=True):
            if why := _no_outcomes(name, array, len(arrays[0]) if arrays[0].ndim else 0, self.question["samples"]):
                raise InputError("resume", expected, f"{str(self.path)!r} whose array {name!r} {why}")
        return Outcomes(*arrays)

    def write(self, done: Outcomes) -> None:
        """All that is done, at once: whoever reads the file sees the old one or the new one. Raises InputError."""
        if self.path is None:
            return
        out, arrays = io.BytesIO(), {name: getattr(done, name) for name in _FIELDS}
        np.savez(out, question=np.array(json.dumps(self.question)), **arrays)
        write_file("resume", self.path, out.getvalue())


def _no_outcomes(name: str, array: Any, count: int, most: int) -> str:
    """Why an array is not one of `Outcomes` of `count` samples, of `most` in all; "": it is."""
    kind = {"codes": "i", "margin": "f"}.get(name, "b")
    if array.dtype.kind != kind:
        return f"holds {array.dtype} in place of {dict(i='integers', f='numbers', b='truth values')[kind]}"
    if array.shape != (count,) or not 0 < count <= most:
        return f"has the shape {array.shape}, for {count} samples that are done of {most}"
    if name == "codes" and not ((array >= 0) & (array < len(WORDS))).all():
        return f"has codes other than 0 to {len(WORDS) - 1}"
    return ""


def _digest_of(spec: GraspSpec) -> str:
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
        arrays += [mechanism.jacobian, mechanism.root, mechanism.limits]
    if isinstance(mechanism, HandMechanism):
        arrays += [mechanism.posture.q, mechanism.posture.hand.pads.blocks, mechanism.gravity, mechanism.stand_off]
        said.append(repr(mechanism.target))
    return _digest("\n".join(said), *arrays)


def _digest(text: str, *arrays: Any) -> str:
    made = hashlib.sha256(text.encode())
    for a in arrays:
        made.update(np.ascontiguousarray(a, dtype=float).tobytes())
    return made.hexdigest()[:16]


# ----------------------------------------------------------------
# Sobol points in blocks, each scrambled on its own.

BLOCKS = 16  # at least: their spread tells how far the estimate may be off


class Blocks:
    """`count` blocks of `size` points each, a power of two, in d dimensions."""

    def __init__(self, seed: int, dimensions: int, size: int, count: int) -> None:
        self.seed, self.dimensions, self.size, self.count = seed, dimensions, size, count
        self._last: tuple[int, Array] | None = None  # the block that was asked for last, which slices share

    @property
    def samples(self) -> int:
        """The number of samples in all blocks."""
        return self.size * self.count

    def block(self, k: int) -> Array:
        """(size, d) points of [0, 1), the same on every call."""
        if self._last is not None and self._last[0] == k:
            return self._last[1]
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(k,)))
        made = np.asarray(qmc.Sobol(self.dimensions, scramble=True, seed=rng).random(self.size))
        self._last = k, made
        return made

    def points(self, begin: int, end: int) -> Array:
        """(end - begin, d) of samples in a row."""
        first, last = begin // self.size, -(-end // self.size)
        every = np.concatenate([self.block(k) for k in range(first, last)])
        return every[begin - first * self.size : end - first * self.size]


def blocks_of(seed: int, dimensions: int, samples: int) -> Blocks:
    """With 16 to 32 blocks, and at least so many samples."""
    size = 2 ** int(math.log2(samples / BLOCKS))
    return Blocks(seed, dimensions, size, -(-samples // size))


# ----------------------------------------------------------------

_SLICE = {SOLVE: 512, "check": 8}  # samples between two looks at the clock: long beside what a batch costs
_OFTEN = 2.0  # seconds between two writings of what is done
_STEP = 1.0 / WIDEST  # of the standard deviation, on either side, for a derivative


@dataclass(frozen=True, slots=True)
class Method:
    """How a sample is judged. by : "solve" or "check". decide : how many samples in all are solved in full where the
    first stage leaves them.
    """

    by: str
    faces: int | str | Pyramid
    workers: int
    decide: int


def run(placer: Placer, blocks: Blocks, method: Method, kept: Kept, progress: Progress) -> Outcomes:
    """The outcomes of all samples, with those that were kept. Whatever ends it early, what is done is kept."""
    before = kept.read()
    parts = [] if before is None else [before]
    begin = 0 if before is None else len(before.codes)
    size = _SLICE[method.by]
    quota = -(-method.decide * size // blocks.samples)
    written = time.monotonic()
    with told("samples", blocks.samples, progress) as say, compile_in_background(blocks.samples):
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
    """Judge samples with values (m, d), SI units. quota : how many are solved in full. by : None: the method's."""
    if (method.by if by is None else by) == SOLVE:
        return solved(placer, rows, method.faces, method.workers, quota)
    every = placer.placed(rows)
    placed = np.array([one.why_not is None for one in every])
    return among(checked([one.grasp for one in every if one.why_not is None], method.faces), placed)


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
