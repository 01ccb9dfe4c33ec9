"""`GraspBatch`: many grasps and how they are solved; those of one kind are the rows of a matrix, solved in threads."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from handlcp.check import Array, Ints, check_flag, check_sequence
from handlcp.contact.friction import Pyramid, Section, as_section
from handlcp.errors import InputError
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.solve.compiled_answer import (
    NO_START,
    CompiledAnswer,
    CompiledKind,
    factor_to_eliminate,
    flexibility_shape,
    get_compiled_kind,
    scene_rows,
)
from handlcp.grasp.solve.compiled_solve import ScenePattern, solve_scenes
from handlcp.lcp import Status, as_chain
from handlcp.lcp.compiler.compile_policy import compile_in_background
from handlcp.lcp.solve import AnySolver

STATUSES = tuple(Status)

P = TypeVar("P")
R = TypeVar("R")
_GRASPS_PER_TASK = 256  # grasps that a thread takes at a time: long beside the handing over, short beside the whole


@dataclass(frozen=True, slots=True)
class GraspBatch:
    """m grasps and the arguments of their solves.

    spatial, planar : the friction sets of spatial and of planar grasps. solver, proof : as in `Grasp.solve`.
    """

    grasps: tuple[Grasp, ...]
    spatial: Section
    planar: Section
    solver: AnySolver
    proof: bool

    def __len__(self) -> int:
        return len(self.grasps)

    def section(self, k: int) -> Section:
        """The friction sets of grasp k."""
        return self.planar if self.grasps[k].scene.kind.planar else self.spatial


def batch_of(grasps: Iterable[Grasp], faces: int | str | Pyramid, solver: AnySolver, proof: bool) -> GraspBatch:
    """The batch with everything checked. Raises InputError."""
    every = check_sequence("grasps", grasps, "several Grasps, such as a list")
    for k, g in enumerate(every):
        if not isinstance(g, Grasp):
            raise InputError(f"grasps[{k}]", "a Grasp", repr(g)[:80])
    return GraspBatch(every, as_section(faces), as_section(faces, planar=True), solver, check_flag("proof", proof))


class Shard(NamedTuple):
    """Grasps of one kind by their places (k,) in a batch; seed : of their solver."""

    kind: CompiledKind
    at: Ints
    seed: int

    def make_rows(self, batch: GraspBatch) -> Array:
        """The numbers (k, width) of their scenes."""
        scenes = [batch.grasps[k].scene for k in self.at.tolist()]
        return scene_rows(scenes, self.kind, batch.section(int(self.at[0])))

    def split(self, size: int) -> Iterator[Shard]:
        """The same in pieces of so many grasps at most."""
        return (self._replace(at=self.at[k : k + size]) for k in range(0, len(self.at), size))


class ShardAnswers(NamedTuple):
    """What the first solve of the grasps at these places (k,) of a batch came to, certified or not."""

    at: Ints
    found: CompiledAnswer

    @property
    def status(self) -> Ints:
        """(k,) the number of each status among all, where the first solve settles it, or nothing more is asked."""
        solved, none, other = map(STATUSES.index, (Status.SOLVED, Status.NOT_HOLDABLE, Status.UNDECIDED))
        return np.where(self.found.passes, solved, np.where(self.found.escapes, none, other))

    def split_settled(self, proof: bool) -> tuple[ShardAnswers, list[int]]:
        """What the first solve settles, everything where no further proof is asked for; and the places of the others,
        which later stages solve.
        """
        good = self.found.passes | self.found.escapes | (not proof)
        return (self, []) if good.all() else (ShardAnswers(self.at[good], self.found[good]), self.at[~good].tolist())


def group_by_kind(batch: GraspBatch) -> tuple[list[Shard], list[int]]:
    """The grasps kind by kind; and those that have no compiled first solve, of effects with rows of their own or with
    any other solver than the chain.
    """
    if (chain := as_chain(batch.solver)) is None:
        return [], list(range(len(batch)))
    found, others = dict[tuple[object, ...], tuple[CompiledKind, list[int]]](), []
    for k, g in enumerate(batch.grasps):
        if g.spec.effects and any([e.stamps or e.depends_on_forces for e in g.spec.effects]):
            others.append(k)
            continue
        factor = factor_to_eliminate(g.scene)
        # By identity: `cached_kind` makes few, and their hashes take longer than all the rest
        key = (id(g.scene.kind), None if factor is None else flexibility_shape(g.scene, factor))
        if (own := found.get(key)) is None:
            own = found[key] = get_compiled_kind(g.scene, batch.section(k), factor), []
        own[1].append(k)
    return [Shard(kind, np.array(at, dtype=np.int64), chain.seed) for kind, at in found.values()], others


def answers_in_threads(batch: GraspBatch, shards: list[Shard], workers: int) -> Iterator[ShardAnswers]:
    """The answers, shard by shard, in so many threads: most of the time is spent in compiled code."""

    def solve_shard(shard: Shard) -> ShardAnswers:
        rows = solve_scenes(shard.make_rows(batch), shard.kind.pattern, NO_START, shard.seed)
        return ShardAnswers(shard.at, CompiledAnswer(shard.kind, rows))

    return _in_threads([some for own in shards for some in own.split(_GRASPS_PER_TASK)], solve_shard, workers)


def solve_rows(numbers: Array, kind: CompiledKind, workers: int) -> CompiledAnswer:
    """The first solves of the scenes of one kind in rows (m, width), as `solve_many` has them."""
    chain = as_chain(None)
    assert chain is not None
    seed = chain.seed

    def solve_part(part: Array) -> Array:
        return solve_scenes(part, kind.pattern, NO_START, seed)

    parts = [numbers[at : at + _GRASPS_PER_TASK] for at in range(0, len(numbers), _GRASPS_PER_TASK)]
    return CompiledAnswer(kind, np.concatenate(list(_in_threads(parts, solve_part, workers))))


def _in_threads(parts: Sequence[P], run: Callable[[P], R], workers: int) -> Iterator[R]:
    if workers == 1 or len(parts) <= 1:
        yield from map(run, parts)
        return
    with ThreadPoolExecutor(min(workers, len(parts))) as pool:
        yield from pool.map(run, parts)


# ----------------------------------------------------------------
# Scenes of one kind in fewer numbers, where they travel to another process.


@dataclass(frozen=True, slots=True)
class SceneParcel:
    """Scenes of one kind as they travel: the first one's numbers (w,), which columns differ (v,), and these (m, v).

    Grasps made by `replace(wrench=...)` differ in six numbers of some hundreds. pattern, seed : as `solve_scenes` takes
    them.
    """

    pattern: ScenePattern
    seed: int
    first: Array
    varying: Ints
    values: Array

    @property
    def size(self) -> int:
        """The size of the parcel as it is sent [bytes], about."""
        return self.values.nbytes + self.first.nbytes + 4096


def pack_shard(batch: GraspBatch, shard: Shard) -> SceneParcel:
    """The shard as it travels; the same bits come out of it."""
    numbers = shard.make_rows(batch)
    bits = numbers.view(np.int64)  # -0.0 is not 0.0
    varying = np.flatnonzero((bits != bits[0]).any(axis=0))
    return SceneParcel(shard.kind.pattern, shard.seed, numbers[0].copy(), varying, numbers[:, varying])


@compile_in_background()
def solve_parcel(parcel: SceneParcel) -> Array:
    """The answers to the scenes of a parcel, wherever it was opened."""
    numbers = np.tile(parcel.first, (len(parcel.values), 1))
    numbers[:, parcel.varying] = parcel.values
    # Kernels are compiled for arrays that are aligned, which on its way is lost
    p = ScenePattern._make([a.copy() if isinstance(a, np.ndarray) else a for a in parcel.pattern])
    return solve_scenes(numbers, p, NO_START, parcel.seed)
