"""Every choice of modes of a contact problem at once: answers, or the proof that there is none.

Pairs are open or closed; contacts with friction are open, stick, or slide somewhere. A tree of modes (`tree.py`) asks
what forces x and motions y fit M x + q = y, without what is free in it (`equations.py`).

What is cut off is proven, each time, by signs that allow for rounding, within bounds on forces and motions that are far
beyond any grasp. An answer is only a candidate: one that its caller refuses forbids the claim that there is none.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import numpy as np

from handlcp.check import Array
from handlcp.lcp.compiler.when import soon
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.modes.equations import Whole
from handlcp.lcp.modes.tree import CANDIDATE, EXHAUSTED, Claim, advance, new_node, new_tree
from handlcp.progress import tick
from handlcp.tolerances import RANK

_PAUSE = 200_000  # multiply-adds, half a millisecond: between two looks at the clock
_A_CALL = 1e5  # multiply-adds that take as long as a call of other kernels where they run as plain Python
_MOST_REFUSED = 100  # candidates at the end of their branch; then the search gives up
_EARLY = 12  # candidates further up that are handed out: where they help, the first ones do


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
        self._whole = Whole(columns, F, self._q, row, tangents, limits, problem.faces)
        first = np.array([places[0] for places in self._own], dtype=np.int64)
        most = np.column_stack([most_x[first], most_y[first]])
        # What rounding leaves of the free unknowns' columns, with unknowns as large as any bound
        size = np.linalg.norm(F, 2) if F.size else 0.0
        self._claim = Claim(most, RANK * float(size * most.max(initial=0.0)))
        self._tree, self._node = new_tree(self._whole), new_node(self._whole)
        self._early = 0

    @property
    def nodes(self) -> int:
        """How many nodes of the tree were visited."""
        return int(self._tree.counts[1])

    @property
    def refused(self) -> int:
        """How many candidates ended their branch without being accepted."""
        return int(self._tree.counts[2])

    @property
    def ended(self) -> bool:
        """Whether nothing more will come, whatever the budget."""
        return self.exhausted or self.refused > _MOST_REFUSED

    @property
    def none(self) -> bool:
        """Whether it is proven that there is no answer within the bounds, unless one was accepted."""
        return self.exhausted and not self.refused

    @property
    def choices(self) -> float:
        """How many choices of modes there are; inf where friction is round, and contacts slide in any direction."""
        faces = float(self._whole.faces) if self._whole.faces > 2 else math.inf
        each = [2.0 if t == 0 else 4.0 if t == 1 else 2.0 + 2.0 * faces for t in self._whole.tangents.tolist()]
        return math.prod(each)

    def candidates(self, work: float, end: float = math.inf) -> Iterator[Array]:
        """(n,) each, natural units: what may be an answer, or near one, until so many multiply-adds were spent in all.

        end : of `time.monotonic`, if earlier.
        """
        visits = self._visits(work, end)
        while not self.ended and (last := next(visits, None)) is not None:
            if last or self._early < _EARLY:
                self._early += not last
                yield self._unknowns()

    def every(self, work: float) -> Iterator[Array]:
        """(n,) each, natural units: one answer of each choice of modes that has any, until so many multiply-adds were
        spent in all. Where `exhausted`, the other choices are proven to have none within the bounds.
        """
        return (self._unknowns() for last in self._visits(work, math.inf) if last)

    def _visits(self, work: float, end: float) -> Iterator[bool]:
        """At each candidate, whether its branch ends there."""
        counts = self._tree.counts
        while not self.exhausted:
            if (left := work - counts[4]) <= 0 or time.monotonic() > end:
                return
            tick(f"{self.nodes} choices of contact modes")
            ended, budget = int(counts[2]), int(min(left, _PAUSE))
            with soon(work / _A_CALL):
                what = advance(
                    self._tree, self._whole, self.problem.sets.normals, self._claim, budget, self._node
                )  # fmt: skip
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
