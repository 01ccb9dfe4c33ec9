"""`GraspBatch`: a batch as it was asked, and its first stage: grasps and answers of one kind are rows of a matrix."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple, TypeVar

import numpy as np

from handlcp.check import Array, Bools, Ints, check_flag, check_sequence, read_only
from handlcp.contact.friction import Pyramid, Section, as_section
from handlcp.errors import InputError
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.contact import SceneKind
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.solve.compiled_answer import NO_START, CompiledKind, get_compiled_kind
from handlcp.grasp.solve.compiled_solve import (
    HEADER_SIZE,
    MAYBE_FREE,
    NONE_HOLDS,
    OUTCOME,
    UNIQUE,
    ScenePattern,
    solve_scenes,
    write_rows,
)
from handlcp.lcp import Status, as_chain
from handlcp.lcp.compiler.compile_policy import compile_in_background
from handlcp.lcp.solve import AnySolver

# ----------------------------------------------------------------
# What a batch asks: its grasps, and how each of them is solved.


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


# ----------------------------------------------------------------
# Many scenes of one kind as one matrix, and the same matrix in fewer numbers where it travels to another process.


_READ_FIELDS = attrgetter("positions", "frames", "flexibility", "offset", "prescribed", "force", "moment", "mu")
_SPATIAL_FREEDOM = np.eye(6)


def scene_rows(scenes: Sequence[Scene], kind: CompiledKind, section: Section) -> Array:
    """The rows (m, width) of scenes of one kind, written field by field for all at once, in a third of the time.
    Read-only.
    """
    m, soft = len(scenes), kind.scene_kind.soft
    positions, frames, E, offset, known, force, moment, mu = zip(*map(_READ_FIELDS, scenes), strict=True)
    none = np.zeros(kind.scene_kind.components)
    return write_rows(
        m,
        kind.scene_width,
        positions=positions,
        frames=frames,
        flexibility=E,
        offset=offset,
        prescribed=[none if a is None else a for a in known],
        spin=[s.arrays.spin for s in scenes] if soft else np.zeros((m, 0)),
        force=force,
        moment=moment,
        freedom=[s.freedom for s in scenes] if kind.scene_kind.planar else [_SPATIAL_FREEDOM] * m,
        limits=[s.friction_coefficients(section) for s in scenes] if soft else np.array(mu) * section.share,
    )


def solve_scene_rows(numbers: Array, pattern: ScenePattern, width: int, seed: int) -> Array:
    """(m, width) the first stage's answers to scenes (m, …) of one kind, without a start."""
    rows = np.empty((len(numbers), width))
    solve_scenes(numbers, pattern, NO_START, seed, rows)
    return rows


@dataclass(frozen=True, slots=True)
class SceneParcel:
    """Scenes of one kind as they travel: what all have in common once, which columns differ, and these alone.

    Grasps made by `replace(wrench=...)` differ in six numbers of some hundreds. pattern, width, seed : as in
    `solve_scene_rows`. common (w,). varying (v,). values (m, v).
    """

    pattern: ScenePattern
    width: int
    seed: int
    common: Array
    varying: Ints
    values: Array

    @property
    def size(self) -> int:
        """The size of the parcel as it is sent [bytes], about."""
        return self.values.nbytes + self.common.nbytes + 4096


def pack_scenes(numbers: Array, pattern: ScenePattern, width: int, seed: int) -> SceneParcel:
    """The scenes (m, w) as they travel; the same bits come out of it."""
    bits = numbers.view(np.int64)  # -0.0 is not 0.0
    varying = np.flatnonzero((bits != bits[0]).any(axis=0))
    return SceneParcel(pattern, width, seed, numbers[0].copy(), varying, numbers[:, varying])


@compile_in_background()
def solve_parcel(parcel: SceneParcel) -> Array:
    """The answers to the scenes of a parcel, wherever it was opened."""
    numbers = np.tile(parcel.common, (len(parcel.values), 1))
    numbers[:, parcel.varying] = parcel.values
    p = parcel.pattern  # kernels are compiled for arrays that may be written to, or not, and on its way that is lost
    pattern = p._replace(
        contacts=p.contacts.copy(),
        unknown=p.unknown.copy(),
        role=p.role.copy(),
        order=p.order.copy(),
        blocks=p.blocks.copy(),
        normals=read_only(p.normals.copy()),
    )
    return solve_scene_rows(read_only(numbers), pattern, parcel.width, parcel.seed)


# ----------------------------------------------------------------
# The first stage of a batch: grasps of one kind are the rows of a matrix, and so are their answers.

STATUSES = tuple(Status)

P = TypeVar("P")
R = TypeVar("R")
_GRASPS_PER_TASK = 256  # grasps that a thread takes at a time: long beside the handing over, short beside the whole


class BatchMembers(NamedTuple):
    """Grasps of one kind by their places in the batch."""

    kind: CompiledKind
    at: Ints


class FirstStageAnswers(NamedTuple):
    """Answers of the first stage to grasps of one kind: places in the batch (k,), and rows (k, width), certified or
    not, as `CompiledAnswer` reads them.
    """

    kind: CompiledKind
    at: Ints
    rows: Array

    @property
    def is_certified(self) -> Bools:
        """(k,) whether the certifier calls it an answer, as `CompiledAnswer.passes`."""
        return np.asarray(self.rows[:, OUTCOME] >= MAYBE_FREE)

    @property
    def is_unique(self) -> Bools:
        """(k,) whether it is an answer that leaves nothing free."""
        return np.asarray(self.rows[:, OUTCOME] == UNIQUE)

    @property
    def status(self) -> Ints:
        """(k,) the number of each status among all, where the first stage settles it, or nothing more is asked."""
        none = self.rows[:, OUTCOME] == NONE_HOLDS
        other = np.where(none, STATUSES.index(Status.NOT_HOLDABLE), STATUSES.index(Status.UNDECIDED))
        return np.where(self.is_certified, STATUSES.index(Status.SOLVED), other)

    def forces_and_twists(self, some: Ints) -> tuple[Array, Array, Array]:
        """(components (s, c), twist (s, 6), centre (s, 3)) of some of the rows."""
        c, rows = self.kind.scene_kind.components, self.rows[some]
        return (
            rows[:, HEADER_SIZE : HEADER_SIZE + c],
            rows[:, HEADER_SIZE + c : HEADER_SIZE + c + 6],
            rows[:, HEADER_SIZE + c + 6 : HEADER_SIZE + c + 9],
        )

    @property
    def motions_and_states(self) -> tuple[Array, Ints]:
        """(object minus fingertip (k, c) [m], contact states (k, n) by their numbers)."""
        c, n = self.kind.scene_kind.components, self.kind.scene_kind.n
        at = HEADER_SIZE + c + 9
        return self.rows[:, at : at + c], self.rows[:, at + c : at + c + n].astype(np.int64)


def group_by_kind(batch: GraspBatch) -> tuple[list[BatchMembers], list[int]]:
    """The grasps kind by kind; and those that have no compiled first stage, of effects with rows of their own or with
    any other solver than the chain.
    """
    if as_chain(batch.solver) is None:
        return [], list(range(len(batch)))
    found: dict[int, list[int]] = {}
    kinds: dict[
        int, SceneKind
    ] = {}  # by identity: `cached_kind` makes few, and their hashes take longer than all the rest
    others = []
    for k, g in enumerate(batch.grasps):
        if g.spec.effects and any([e.stamps or e.depends_on_forces for e in g.spec.effects]):
            others.append(k)
            continue
        key = id(g.scene.kind)
        if key not in found:
            found[key], kinds[key] = [], g.scene.kind
        found[key].append(k)
    members = []
    for own in found.values():
        kind = get_compiled_kind(batch.grasps[own[0]].scene, batch.section(own[0]))
        members.append(BatchMembers(kind, np.array(own, dtype=np.int64)))
    return members, others


def split_members(kinds: list[BatchMembers], size: int) -> Iterator[BatchMembers]:
    """The same in pieces of so many grasps at most."""
    for kind, at in kinds:
        for begin in range(0, len(at), size):
            yield BatchMembers(kind, at[begin : begin + size])


def answers_in_threads(batch: GraspBatch, kinds: list[BatchMembers], workers: int) -> Iterator[FirstStageAnswers]:
    """The answers, shard by shard, in so many threads: most of the time is spent in compiled code."""
    chain = as_chain(batch.solver)
    assert chain is not None or not kinds  # `kinds_of` saw to it

    def solve_shard(shard: BatchMembers) -> FirstStageAnswers:
        assert chain is not None
        kind = shard.kind
        return FirstStageAnswers(
            *shard, solve_scene_rows(_numbers(batch, shard), kind.pattern, kind.answer_width, chain.seed)
        )

    yield from _in_threads(list(split_members(kinds, _GRASPS_PER_TASK)), solve_shard, workers)


def solve_rows(numbers: Array, kind: CompiledKind, workers: int) -> Array:
    """(m, width) the first stage's answers to the rows of scenes of one kind, as `solve_many` has them."""
    chain = as_chain(None)
    assert chain is not None

    def solve_part(part: Array) -> Array:
        return solve_scene_rows(part, kind.pattern, kind.answer_width, chain.seed)

    parts = [numbers[at : at + _GRASPS_PER_TASK] for at in range(0, len(numbers), _GRASPS_PER_TASK)]
    return np.concatenate(list(_in_threads(parts, solve_part, workers)))


def _in_threads(parts: Sequence[P], solved: Callable[[P], R], workers: int) -> Iterator[R]:
    if workers == 1 or len(parts) <= 1:
        yield from map(solved, parts)
        return
    with ThreadPoolExecutor(min(workers, len(parts))) as pool:
        yield from pool.map(solved, parts)


def pack_shard(batch: GraspBatch, shard: BatchMembers) -> SceneParcel:
    """The shard as it travels."""
    chain = as_chain(batch.solver)
    assert chain is not None
    kind = shard.kind
    return pack_scenes(_numbers(batch, shard), kind.pattern, kind.answer_width, chain.seed)


def _numbers(batch: GraspBatch, shard: BatchMembers) -> Array:
    scenes = [batch.grasps[k].scene for k in shard.at.tolist()]
    return scene_rows(scenes, shard.kind, batch.section(int(shard.at[0])))


def split_settled(found: FirstStageAnswers, proof: bool) -> tuple[FirstStageAnswers, dict[int, Array]]:
    """What the first stage settles, everything where no further proof is asked for; and the rows of the others by their
    places, where later stages go on.
    """
    good = found.status != STATUSES.index(Status.UNDECIDED) if proof else np.ones(len(found.at), bool)
    if good.all():
        return found, {}
    lost = dict(zip(found.at[~good].tolist(), found.rows[~good], strict=True))
    return FirstStageAnswers(found.kind, found.at[good], found.rows[good]), lost
