"""Every choice of modes of a contact problem at once: answers, or the proof that there is none.

Pairs are open or closed; contacts with friction are open, stick, or slide somewhere. With N orthogonal to the columns
of the free unknowns, M x + q = y becomes Nᵀ M x - Nᵀ y = -Nᵀ q in the others' forces x and motions y, and a tree of
modes asks what fits (`kernels.mode_search`).

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
from handlcp.lcp.modes.generators import Cones
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
        self._U, size, self._V = np.linalg.svd(self._M[:, self._free])
        self._size = size[size > RANK * size.max(initial=0.0)]
        N = self._U[:, len(self._size) :]
        R, MN = N.shape[1], N.T @ self._M
        columns = np.zeros((R, len(own), 2, 4))
        for i, places in enumerate(self._own):
            columns[:, i, 0, : len(places)] = MN[:, places]
            columns[:, i, 1, : len(places)] = -N[places].T
        products = np.ascontiguousarray(np.einsum("rika,rikb->ikab", columns, columns))
        tangents = np.array([len(places) - 1 for places in self._own], dtype=np.int64)
        limits = np.array([mu for _, mu in own], dtype=float)
        self._cones = Cones(columns.reshape(R, len(own), 8), products, tangents, limits, problem.faces)
        first = np.array([places[0] for places in self._own], dtype=np.int64)
        most = np.column_stack([most_x[first], most_y[first]])
        # What N leaves of the free unknowns' columns, by rounding, with unknowns as large as any bound
        self._claim = Claim(most, RANK * float(size.max(initial=0.0) * most.max(initial=0.0)))
        self._b, self._tree = -N.T @ self._q, new_tree(self._cones)
        self._early = 0
        self._node = new_node(self._cones)

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
        faces = float(self._cones.faces) if self._cones.faces > 2 else math.inf
        each = [2.0 if t == 0 else 4.0 if t == 1 else 2.0 + 2.0 * faces for t in self._cones.tangents.tolist()]
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
                    self._tree, self._cones, self._b, self.problem.sets.normals, self._claim, budget, self._node
                )  # fmt: skip
            self.exhausted = what == EXHAUSTED
            if what == CANDIDATE:
                yield bool(counts[2] > ended)

    def _unknowns(self) -> Array:
        """All unknowns, from forces and motions of the contacts: the free ones fit M x + q = y best."""
        p = self.problem
        x, y = np.zeros(p.n), np.zeros(p.n)
        for i, places in enumerate(self._own):
            x[places], y[places] = self._node.x[i, : len(places)], self._node.y[i, : len(places)]
        k = len(self._size)
        with np.errstate(over="ignore", invalid="ignore"):  # the certifier refuses what is not finite
            x[self._free] = self._V[:k].T @ ((self._U[:, :k].T @ (y - self._q - self._M @ x)) / self._size)
        return x
