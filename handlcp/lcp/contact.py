"""Frictional contact as a complementarity problem with friction as a set: its size does not depend on any faces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.lazy import lazy
from handlcp.lcp.kernels.contact_packed import packed
from handlcp.lcp.scaling import Units

NO_NORMALS = read_only(np.zeros((0, 3)))


@dataclass(frozen=True, slots=True, eq=False)
class FrictionSets:
    """Where the tangential unknowns of each block may be, per unit of its normal unknown.

    limits : (k,) radius of the block's ball, or distance of the faces of its polygon or polyhedron from the axis [-].
    faces : 0 balls; ≥ 3 regular polygons with outward normals at 2πj/m from the first tangent; 2 intervals. Blocks with
        one tangent have an interval in any case.
    normals : (f, 3) outward unit normals of the polyhedra of blocks with three tangents, where there are faces.
    """

    limits: Array
    faces: int
    normals: Array = field(default_factory=lambda: NO_NORMALS)


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """Which role each unknown plays, whatever the numbers. Make it with `Pattern.of`.

    free : (n,) bool. blocks : (k, 4) indices of a normal unknown and its tangents, -1 for those that there are not.
    role : (n,) 0 free, 1 pair, 2 tangent. order : (n,) the unknowns in the order in which kernels take them: contact by
        contact, then single pairs, then the free ones. A finger's rows meet few columns but its own and the object's,
        so that elimination in this order finds most multipliers zero.
    """

    free: Bools
    blocks: Ints
    role: Ints
    order: Ints

    @staticmethod
    def of(free: Bools, blocks: Ints) -> Pattern:
        """From the free unknowns and the blocks; blocks (k, 3) have two tangents at most."""
        if blocks.shape[1] < 4:
            blocks = np.pad(blocks, ((0, 0), (0, 4 - blocks.shape[1])), constant_values=-1)
        role = np.where(free, 0, 1)
        role[blocks[:, 1:][blocks[:, 1:] >= 0]] = 2
        in_blocks = blocks[blocks >= 0]
        alone = np.setdiff1d(np.arange(len(free)), in_blocks)
        order = np.concatenate([in_blocks, alone[role[alone] == 1], alone[role[alone] == 0]])
        return Pattern(free, blocks, role, order)


class ContactProblem:
    """Find x with y = M x + q, in natural units, where each unknown plays one of three roles:

    free : y_i = 0. pair : 0 ≤ x_i ⟂ y_i ≥ 0.
    friction block (N, T, …) : N is a pair; x_T in the set of the block, x_N times as large, and y_T in minus the set's
        normal cone at x_T: zero inside, against x_T on the limit. For balls this is second-order-cone complementarity.

    M (n, n), q (n,). pattern : roles of the unknowns. sets : of the blocks. units : natural sizes of every x and y, or
    a function that makes them. flat : the sets with m faces in their place, as a function of m; None: nobody knows.
    free, role, blocks, limits and faces are those of the pattern and the sets.
    """

    def __init__(
        self,
        M: Array,
        q: Array,
        pattern: Pattern,
        sets: FrictionSets,
        units: Units | Callable[[], Units],
        flat: Callable[[int], FrictionSets] | None = None,
    ) -> None:
        self.M, self.q, self.pattern, self.sets, self.flat = read_only(M), read_only(q), pattern, sets, flat
        self.n, self.free, self.role, self.blocks = len(q), pattern.free, pattern.role, pattern.blocks
        self.limits, self.faces, self._units = sets.limits, sets.faces, units

    @lazy
    def units(self) -> Units:
        """Natural sizes of every x and y."""
        return self._units if isinstance(self._units, Units) else self._units()

    @lazy
    def prepared(self) -> tuple[Array, Ints]:
        """What kernels work on: the problem as two rows of numbers, as in `contact_packed`."""
        s, p = self.sets, self.pattern
        return packed(self.M, self.q, p.role, p.blocks, p.order, s.limits, s.faces, s.normals)

    def varied(self, M: Array, q: Array, limits: Array) -> ContactProblem:
        """Another problem with the same pattern."""
        return ContactProblem(M, q, self.pattern, FrictionSets(limits, self.sets.faces, self.sets.normals), self._units)

    def complete(self) -> None:
        """Compute now what is otherwise computed when first asked for."""
        self.prepared, self.units  # noqa: B018

    def __repr__(self) -> str:
        kind = {0: "exact cone", 2: "planar"}.get(self.faces, f"{self.faces} faces")
        return f"{type(self).__name__}(n={self.n}, {len(self.blocks)} contacts with friction, {kind})"
