"""`ModeSearch`: all choices of contact modes at once, as a tree whose branches are cut off where none fits.

At each node some contacts have a mode, the others any. `fit_mode` asks whether anything fits; if not, a proof of that
is checked, and nothing below is visited. If so, the contact that misses its law by most is given each of its modes in
turn, or its patch is split. Where all laws hold, there is an answer.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.compiler.compile_policy import compile_in_background
from handlcp.lcp.contact_problem import ContactProblem
from handlcp.lcp.kernels.dense import kernel
from handlcp.lcp.kernels.projection import project_on_set
from handlcp.lcp.modes.mode_cones import (
    ANY,
    OPEN,
    SLIDES,
    STUCK,
    TOUCHES,
    FullEquations,
    ModeCones,
    count_parts,
    count_patches,
    reduce_equations,
    split_patch,
    write_first_patch,
    write_free,
)
from handlcp.lcp.modes.mode_fit import ActiveColumns, fit_mode, new_active_columns, proves_none, write_fit
from handlcp.progress import report_progress
from handlcp.tolerances import RANK_TOLERANCE

EXHAUSTED, CANDIDATE, SPENT = 0, 1, 2  # why `advance` returned
_MISS_TIE_FACTOR = 1.0 + 1e-6  # of two that miss it equally the first is taken, whatever rounding says
_LAW_TOLERANCE = 1e-9  # of the largest force and motion: a contact's law holds
_MAX_SPLITS = 14  # splits of an arc, after which it is 1e-4 rad wide; of a triangle half as many


class ModeTree(NamedTuple):
    """Nodes still to visit, the last one first. For each node: codes (k, n), corners (k, n, 3, 3) and splits (k, n) of
    the contacts; and generators to begin its fit with, warm (k, R + 1, 6): owner or -1, kind, components.

    counts (5,) : nodes still to visit, nodes visited, candidates that end their branch, fits without a proof,
    multiply-adds spent.
    """

    codes: Ints
    corners: Array
    splits: Ints
    warm: Array
    counts: Ints


class ModeNode(NamedTuple):
    """One node, as it is visited: codes (n,), corners (n, 3, 3) and splits (n,) of the contacts; forces and motions
    that fit it, x and y (n, 4), normal component first, and the free unknowns u (f,).
    """

    codes: Ints
    corners: Array
    splits: Ints
    x: Array
    y: Array
    u: Array


class NonexistenceClaim(NamedTuple):
    """Within which bounds "none" is claimed, as in `proves_none`: most (n, 2), and slack of the equations."""

    most: Array
    slack: float


@kernel
def new_mode_tree(w: FullEquations) -> ModeTree:
    """The tree with its root: every contact may do anything."""
    n, R = len(w.tangents), len(w.q)
    room = 2
    for i in range(n):
        room += 3 + count_patches(w.tangents[i]) + (4 * _MAX_SPLITS if w.tangents[i] > 1 else 0)
    tree = ModeTree(
        np.zeros((room, n), np.int64),
        np.zeros((room, n, 3, 3)),
        np.zeros((room, n), np.int64),
        np.full((room, R + 1, 6), -1.0),
        np.zeros(5, np.int64),
    )
    tree.counts[0] = 1
    return tree


@kernel
def new_mode_node(w: FullEquations) -> ModeNode:
    """Arrays for one node."""
    n = len(w.tangents)
    return ModeNode(
        np.zeros(n, np.int64),
        np.zeros((n, 3, 3)),
        np.zeros(n, np.int64),
        np.zeros((n, 4)),
        np.zeros((n, 4)),
        np.zeros(w.F.shape[1]),
    )


@kernel
def visit_nodes(
    t: ModeTree, w: FullEquations, normals: Array, claim: NonexistenceClaim, work: int, node: ModeNode
) -> int:
    """Visit nodes until `work` multiply-adds are spent, none is left, or the node's x, y, u are a candidate."""
    end = t.counts[4] + work
    codes, corners = node.codes, node.corners
    while t.counts[0] > 0:
        if t.counts[4] >= end:
            return SPENT
        at = t.counts[0] - 1
        codes[:], corners[:, :, :], node.splits[:] = t.codes[at], t.corners[at], t.splits[at]
        asked = reduce_equations(w, codes)
        c, a = asked.cones, new_active_columns(asked.b)
        _warm_start(t, at, a)
        t.counts[0], t.counts[1] = at, t.counts[1] + 1
        left, spent = fit_mode(c, codes, corners, a)
        t.counts[4] += spent + (2 * len(asked.taken) + 2) * (len(asked.b) + len(asked.taken)) * asked.top.shape[1]
        if left > 0.0 and proves_none(c, codes, corners, a.rest, asked.b, claim.most, claim.slack):
            continue
        write_fit(a, node.x, node.y)
        write_free(w, asked, codes, node.x, node.y, node.u)
        worst, decided = _worst_contact(c, node, normals), True
        if worst < 0:  # there may be another answer below
            worst = _undecided_contact(c, node)
        else:
            decided = node.splits[worst] % 4 == 0 and not bool(np.any((codes == ANY) | (codes == TOUCHES)))
        if worst >= 0:
            _branch(t, c, a, node, worst)
        else:
            t.counts[2] += 1
        if decided:
            return CANDIDATE
    return EXHAUSTED


@kernel
def _warm_start(t: ModeTree, at: int, a: ActiveColumns) -> None:
    """Begin with the generators of the node above, but those of the contact that was branched on."""
    k = 0
    for s in range(t.warm.shape[1]):
        if t.warm[at, s, 0] >= 0.0 and k < len(a.b):
            a.owner[k], a.kind[k] = int(t.warm[at, s, 0]), int(t.warm[at, s, 1])
            a.components[k, :] = t.warm[at, s, 2:]
            k += 1
    a.used[0] = k


@kernel
def _worst_contact(c: ModeCones, node: ModeNode, normals: Array) -> int:
    """The contact that misses its law by most among those that can be branched on; -1: none, or all laws hold."""
    codes, corners, splits, x, y, _ = node
    size = 1.0
    for i in range(len(codes)):
        for q in range(4):
            size = max(size, abs(x[i, q]), abs(y[i, q]))
    worst, most = -1, _LAW_TOLERANCE * size
    for i in range(len(codes)):
        d = c.tangents[i]
        finest = _MAX_SPLITS // 2 if d == 3 else _MAX_SPLITS
        if codes[i] == OPEN or codes[i] == STUCK:
            continue
        if codes[i] == SLIDES and (splits[i] >= finest or count_parts(corners[i], d, c.faces) == 0):
            continue
        miss = _law_miss(c, i, normals, x[i], y[i])
        if miss > most * _MISS_TIE_FACTOR:
            worst, most = i, miss
    return worst


@kernel
def _undecided_contact(c: ModeCones, node: ModeNode) -> int:
    """A contact whose mode is not decided, or not its face; -1: none. Arcs have no last one."""
    found = -1
    for i in range(len(node.codes)):
        sliding = node.codes[i] == SLIDES and c.faces > 0 and count_parts(node.corners[i], c.tangents[i], c.faces) > 0
        if node.codes[i] == ANY or node.codes[i] == TOUCHES or sliding:
            found = i
    return found


@kernel
def _law_miss(c: ModeCones, i: int, normals: Array, x: Array, y: Array) -> float:
    """By how much force x (4,) and motion y (4,) miss the law of contact i (the natural residual)."""
    d, s, P, D = c.tangents[i], np.zeros(3), np.zeros(3), np.zeros((3, 4))
    miss = abs(min(x[0], y[0]))
    if d > 0:
        for k in range(d):
            s[k] = x[1 + k] - y[1 + k]
        project_on_set(s, d, c.limits[i] * max(x[0], 0.0), 0.0, c.faces, normals, P, D)
        for k in range(d):
            miss = max(miss, abs(x[1 + k] - P[k]))
    return float(miss)


@kernel
def _branch(t: ModeTree, c: ModeCones, a: ActiveColumns, node: ModeNode, i: int) -> None:
    """Put the nodes below this one, in which contact i has each of its modes or patches, the likeliest last."""
    codes, corners, _, x, y, _ = node
    d = c.tangents[i]
    if codes[i] == SLIDES:
        for k in range(count_parts(corners[i], d, c.faces)):
            at = _push_node(t, a, node, i)
            split_patch(corners[i], k, d, c.faces, t.corners[at, i])
            t.splits[at, i] += 1
        return
    if codes[i] == TOUCHES:
        for k in range(count_patches(d)):
            at = _push_node(t, a, node, i)
            t.codes[at, i] = SLIDES
            write_first_patch(k, d, c.faces, t.corners[at, i])
        at = _push_node(t, a, node, i)
        t.codes[at, i] = STUCK
        return
    force, motion = 0.0, 0.0
    for q in range(4):
        force, motion = max(force, abs(x[i, q])), max(motion, abs(y[i, q]))
    for k in range(2):
        at = _push_node(t, a, node, i)
        t.codes[at, i] = OPEN if (k == 0) == (force > motion) else STUCK if d == 0 else TOUCHES


@kernel
def _push_node(t: ModeTree, a: ActiveColumns, node: ModeNode, i: int) -> int:
    """One more node, as the one that is visited; returns its place."""
    at = t.counts[0]
    t.codes[at], t.corners[at], t.splits[at] = node.codes, node.corners, node.splits
    t.warm[at, :, 0] = -1.0
    for s in range(a.used[0]):
        if a.owner[s] != i:
            t.warm[at, s, 0], t.warm[at, s, 1] = a.owner[s], a.kind[s]
            t.warm[at, s, 2:] = a.components[s]
    t.counts[0] = at + 1
    return int(at)


# ----------------------------------------------------------------
# Every choice of modes of a contact problem at once: answers, or the proof that there is none.
#
# Pairs are open or closed; contacts with friction are open, stick, or slide somewhere. A tree of modes
# (`mode_search.py`) asks
# what forces x and motions y fit M x + q = y, without what is free in it (`mode_cones.py`).
#
# What is cut off is proven, each time, by signs that allow for rounding, within bounds on forces and motions that are
# far beyond any grasp. An answer is only a candidate: one that its caller refuses forbids the claim that there is
# none.


@dataclass(frozen=True)
class ModeSearchOptions:
    """What a search over contact modes spends before it gives up or looks up."""

    work_between_clocks: int = 200_000  # multiply-adds, half a millisecond: between two looks at the clock
    work_per_call: float = 1e5  # multiply-adds as long as a call of other kernels where they run as plain Python
    max_refused: int = 100  # candidates at the end of their branch; then the search gives up
    max_early_candidates: int = 12  # candidates further up that are handed out: where they help, the first ones do


_OPTIONS = ModeSearchOptions()


class ModeSearch:
    """A search that can be paused: `candidates` goes on where it stopped.

    most_x, most_y (n,) : bounds of pairs and normal unknowns, and of their motions, within which "none" is claimed,
    natural units; those of a normal unknown hold for its contact's tangents as well. There are no contacts with three
    tangents beside faces.
    """

    def __init__(self, problem: ContactProblem, most_x: Array, most_y: Array) -> None:
        self.problem, self.exhausted = problem, False
        friction = {int(b[0]): (b[b >= 0], float(mu)) for b, mu in zip(problem.blocks, problem.limits, strict=True)}
        own = [friction.get(i, (np.array([i]), 0.0)) for i in np.flatnonzero(problem.role == 1).tolist()]
        self._own, self._free = [places for places, _ in own], np.flatnonzero(problem.role == 0)
        # A pair's y is told in units of its q where that is large: nothing looks small beside a bound out of reach
        alone = np.array([places[0] for places in self._own if len(places) == 1], dtype=np.int64)
        self._unit = np.ones(problem.n)
        self._unit[alone] = np.maximum(abs(problem.q[alone]), 1.0)
        self._M, self._q, most_y = problem.M / self._unit[:, None], problem.q / self._unit, most_y / self._unit
        row, columns = np.full((len(own), 4), -1), np.zeros((problem.n, len(own), 4))
        for i, places in enumerate(self._own):
            row[i, : len(places)], columns[:, i, : len(places)] = places, self._M[:, places]
        tangents = np.array([len(places) - 1 for places in self._own], dtype=np.int64)
        limits, F = np.array([mu for _, mu in own], dtype=float), np.ascontiguousarray(self._M[:, self._free])
        self._whole = FullEquations(columns, F, self._q, row, tangents, limits, problem.faces)
        first = np.array([places[0] for places in self._own], dtype=np.int64)
        most = np.column_stack([most_x[first], most_y[first]])
        # What rounding leaves of the free unknowns' columns, with unknowns as large as any bound
        size = np.linalg.norm(F, 2) if F.size else 0.0
        self._claim = NonexistenceClaim(most, RANK_TOLERANCE * float(size * most.max(initial=0.0)))
        self._tree, self._node = new_mode_tree(self._whole), new_mode_node(self._whole)
        self._early = 0

    @property
    def node_count(self) -> int:
        """How many nodes of the tree were visited."""
        return int(self._tree.counts[1])

    @property
    def refused_count(self) -> int:
        """How many candidates ended their branch without being accepted."""
        return int(self._tree.counts[2])

    @property
    def is_none_proven(self) -> bool:
        """Whether it is proven that there is no answer within the bounds, unless one was accepted."""
        return self.exhausted and not self.refused_count

    @property
    def choice_count(self) -> float:
        """How many choices of modes there are; inf where friction is round, and contacts slide in any direction."""
        faces = float(self._whole.faces) if self._whole.faces > 2 else math.inf
        each = [2.0 if t == 0 else 4.0 if t == 1 else 2.0 + 2.0 * faces for t in self._whole.tangents.tolist()]
        return math.prod(each)

    def candidates(self, work: float, end: float = math.inf) -> Iterator[Array]:
        """Candidates (n,) in natural units that may be an answer, or near one, until so many multiply-adds were spent
        in all.

        end : of `time.monotonic`, if earlier.
        """
        visits = self._visits(work, end)
        while self.refused_count <= _OPTIONS.max_refused and (last := next(visits, None)) is not None:
            if last or self._early < _OPTIONS.max_early_candidates:
                self._early += not last
                yield self._unknowns()

    def each_choice(self, work: float) -> Iterator[Array]:
        """One answer (n,) of each choice of modes that has any; where `exhausted`, others are proven to have none."""
        return (self._unknowns() for last in self._visits(work, math.inf) if last)

    def _visits(self, work: float, end: float) -> Iterator[bool]:
        """At each candidate, whether its branch ends there."""
        counts = self._tree.counts
        while not self.exhausted:
            if (left := work - counts[4]) <= 0 or time.monotonic() > end:
                return
            report_progress(f"{self.node_count} choices of contact modes")
            ended, budget = int(counts[2]), int(min(left, _OPTIONS.work_between_clocks))
            with compile_in_background(work / _OPTIONS.work_per_call):
                what = visit_nodes(self._tree, self._whole, self.problem.sets.normals, self._claim, budget, self._node)
            self.exhausted = what == EXHAUSTED
            if what == CANDIDATE:
                yield bool(counts[2] > ended)

    def _unknowns(self) -> Array:
        """All unknowns, from forces of the contacts and the free ones that go with them."""
        x = np.zeros(self.problem.n)
        for i, places in enumerate(self._own):
            x[places] = self._node.x[i, : len(places)]
        x[self._free] = self._node.u
        return x
