"""The first stage of a batch: grasps of one kind are the rows of a matrix, and so are their answers."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.batch.batch import Batch
from handlcp.grasp.batch.packing import Parcel, answer_rows, pack_all, parcel_of
from handlcp.grasp.model.kind import Kind
from handlcp.grasp.solve.compiled_answer import CompiledKind, compiled_kind
from handlcp.grasp.solve.compiled_solve import HEAD, NONE_HOLDS, UNIQUE
from handlcp.lcp import Status, as_chain
from handlcp.tolerances import CERTIFY

STATUSES = tuple(Status)

_CHUNK = 256  # grasps that a thread takes at a time: long beside the handing over, short beside the whole


class Members(NamedTuple):
    """Grasps of one kind by their places in the batch."""

    kind: CompiledKind
    at: Ints


class Answers(NamedTuple):
    """Answers of the first stage to grasps of one kind: places in the batch (k,), and rows (k, width), certified or
    not, as `CompiledAnswer` reads them.
    """

    kind: CompiledKind
    at: Ints
    rows: Array

    @property
    def passing(self) -> Bools:
        """(k,) whether the certifier calls it an answer; NaN never is."""
        return np.asarray((self.rows[:, 5:9] <= CERTIFY).all(axis=1))

    @property
    def unique(self) -> Bools:
        """(k,) whether it is an answer that leaves nothing free."""
        return np.asarray(self.rows[:, 11] == UNIQUE)

    @property
    def status(self) -> Ints:
        """(k,) the number of each status among all, where the first stage settles it, or nothing more is asked."""
        none = self.rows[:, 11] == NONE_HOLDS
        other = np.where(none, STATUSES.index(Status.NOT_HOLDABLE), STATUSES.index(Status.UNDECIDED))
        return np.where(self.passing, STATUSES.index(Status.SOLVED), other)

    def moves(self, some: Ints) -> tuple[Array, Array, Array]:
        """(components (s, c), twist (s, 6), centre (s, 3)) of some of the rows."""
        c, rows = self.kind.kind.components, self.rows[some]
        return rows[:, HEAD : HEAD + c], rows[:, HEAD + c : HEAD + c + 6], rows[:, HEAD + c + 6 : HEAD + c + 9]


def kinds_of(batch: Batch) -> tuple[list[Members], list[int]]:
    """The grasps kind by kind; and those that have no compiled first stage, of effects with rows of their own or with
    any other solver than the chain.
    """
    if as_chain(batch.solver) is None:
        return [], list(range(len(batch)))
    found: dict[int, list[int]] = {}
    kinds: dict[int, Kind] = {}  # by identity: `kind_of` makes few, and their hashes take longer than all the rest
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
        kind = compiled_kind(batch.grasps[own[0]].scene, batch.section(own[0]))
        members.append(Members(kind, np.array(own, dtype=np.int64)))
    return members, others


def shards(kinds: list[Members], size: int) -> Iterator[Members]:
    """The same in pieces of so many grasps at most."""
    for kind, at in kinds:
        for begin in range(0, len(at), size):
            yield Members(kind, at[begin : begin + size])


def answers_in_threads(batch: Batch, kinds: list[Members], workers: int) -> Iterator[Answers]:
    """The answers, shard by shard, in so many threads: most of the time is spent in compiled code."""
    chain = as_chain(batch.solver)
    assert chain is not None or not kinds  # `kinds_of` saw to it

    def solved(shard: Members) -> Answers:
        assert chain is not None
        kind = shard.kind
        return Answers(*shard, answer_rows(_numbers(batch, shard), kind.pattern, kind.answer_width, chain.seed))

    parts = list(shards(kinds, _CHUNK))
    if workers == 1 or len(parts) <= 1:
        yield from map(solved, parts)
        return
    with ThreadPoolExecutor(min(workers, len(parts))) as pool:
        yield from pool.map(solved, parts)


def parcel(batch: Batch, shard: Members) -> Parcel:
    """The shard as it travels."""
    chain = as_chain(batch.solver)
    assert chain is not None
    kind = shard.kind
    return parcel_of(_numbers(batch, shard), kind.pattern, kind.answer_width, chain.seed)


def _numbers(batch: Batch, shard: Members) -> Array:
    scenes = [batch.grasps[k].scene for k in shard.at.tolist()]
    return pack_all(scenes, shard.kind, batch.section(int(shard.at[0])))


def settled(found: Answers, proof: bool) -> tuple[Answers, dict[int, Array]]:
    """What the first stage settles, everything where no further proof is asked for; and the rows of the others by their
    places, where later stages go on.
    """
    good = found.status != STATUSES.index(Status.UNDECIDED) if proof else np.ones(len(found.at), bool)
    if good.all():
        return found, {}
    lost = dict(zip(found.at[~good].tolist(), found.rows[~good], strict=True))
    return Answers(found.kind, found.at[good], found.rows[good]), lost
