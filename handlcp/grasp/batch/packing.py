"""Many scenes of one kind as one matrix, and the same matrix in fewer numbers where it travels to another process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.solve.compiled_answer import NOWHERE, CompiledKind
from handlcp.grasp.solve.compiled_solve import ScenePattern, solve_scenes
from handlcp.lcp.compiler.when import at_once

_READ = attrgetter("positions", "frames", "flexibility", "offset", "prescribed", "force", "moment", "mu")
_SPATIAL = np.eye(6)


def pack_all(scenes: Sequence[Scene], kind: CompiledKind, section: Section) -> Array:
    """(m, width) read-only: the row of each scene as `compiled_answer.pack` writes it, field by field for all at once,
    in a third of the time.
    """
    positions, frames, E, offset, known, force, moment, mu = zip(*map(_READ, scenes), strict=True)
    none, soft = np.zeros(kind.kind.components), kind.kind.soft
    fields = [positions, frames, E, offset, [none if a is None else a for a in known]]
    if soft:
        fields.append([s.given.spin for s in scenes])
    fields += [force, moment, [s.freedom for s in scenes] if kind.kind.planar else [_SPATIAL] * len(scenes)]
    fields.append([s.limits(section) for s in scenes] if soft else mu)
    out, at = np.empty((len(scenes), kind.scene_width)), 0
    for own in fields:
        first, end = own[0], at + own[0].size
        shared = all([a is first for a in own])  # as after `replace`
        out[:, at:end] = first.reshape(-1) if shared else np.concatenate(own).reshape(len(own), -1)
        at = end
    if not soft:
        out[:, -kind.kind.n :] *= section.share
    return read_only(out)


def answer_rows(numbers: Array, pattern: ScenePattern, width: int, seed: int) -> Array:
    """(m, width) the first stage's answers to scenes (m, …) of one kind, without a start."""
    rows = np.empty((len(numbers), width))
    solve_scenes(numbers, pattern, NOWHERE, seed, rows)
    return rows


@dataclass(frozen=True, slots=True)
class Parcel:
    """Scenes of one kind as they travel: what all have in common once, which columns differ, and these alone.

    Grasps made by `replace(wrench=...)` differ in six numbers of some hundreds. pattern, width, seed : as in
    `answer_rows`. common (w,). varying (v,). values (m, v).
    """

    pattern: ScenePattern
    width: int
    seed: int
    common: Array
    varying: Ints
    values: Array

    @property
    def size(self) -> int:
        """Bytes, about."""
        return self.values.nbytes + self.common.nbytes + 4096


def parcel_of(numbers: Array, pattern: ScenePattern, width: int, seed: int) -> Parcel:
    """The scenes (m, w) as they travel; the same bits come out of it."""
    bits = numbers.view(np.int64)  # -0.0 is not 0.0
    varying = np.flatnonzero((bits != bits[0]).any(axis=0))
    return Parcel(pattern, width, seed, numbers[0].copy(), varying, numbers[:, varying])


@at_once()
def solve_parcel(parcel: Parcel) -> Array:
    """The answers to the scenes of a parcel, wherever it was opened."""
    numbers = np.tile(parcel.common, (len(parcel.values), 1))
    numbers[:, parcel.varying] = parcel.values
    p = parcel.pattern  # kernels are compiled for arrays that may be written to, or not, and on its way that is lost
    pattern = p._replace(
        contacts=p.contacts.copy(), unknown=p.unknown.copy(), role=p.role.copy(), order=p.order.copy(),
        blocks=p.blocks.copy(), normals=read_only(p.normals.copy()),
    )  # fmt: skip
    return answer_rows(read_only(numbers), pattern, parcel.width, parcel.seed)
