"""Frictional contact as a complementarity problem with cones: its size does not depend on faces of any pyramid."""

from __future__ import annotations

from collections.abc import Callable

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.lazy import lazy
from handlcp.lcp.kernels.contact import prepare, roles
from handlcp.lcp.problem import LCP
from handlcp.lcp.scaling import Units

__all__ = ["ContactProblem"]


class ContactProblem:
    """Find x with y = M x + q, in natural units, where each unknown plays one of three roles:

    free : y_i = 0. pair : 0 ≤ x_i ⟂ y_i ≥ 0.
    friction block (N, T, O) : N is a pair; x_T in the disc (polygon, interval) of radius limit · x_N, and y_T in minus
        its normal cone: zero inside, against x_T on the limit. Second-order-cone complementarity, for the disc.

    M (n, n), q (n,), free (n,) bool. blocks (k, 3): indices of normal, first and second tangent (-1: planar).
    limits (k,) radius per unit of normal force [-]. faces: 0 the disc, ≥ 3 a regular polygon of that apothem with
    outward normals at 2πj/m, 2 an interval. units: natural sizes of every x and y, or a function that makes them.
    pyramid : how to get the same scene with an m-face pyramid as a plain `LCP`, and its z as an x, or None.
    role : (n,) 0 free, 1 pair, 2 tangent of a friction block; None: found from free and blocks.
    """

    def __init__(
        self,
        M: Array,
        q: Array,
        free: Bools,
        blocks: Ints,
        limits: Array,
        faces: int,
        units: Units | Callable[[], Units],
        pyramid: Callable[[int], tuple[LCP, Callable[[Array], Array]]] | None = None,
        role: Ints | None = None,
    ) -> None:
        self.role = roles(free, blocks) if role is None else role
        self.M, self.q, self.free = read_only(M), read_only(q), free
        self.blocks, self.limits, self.faces, self.pyramid = blocks, limits, faces, pyramid
        self._units = units

    @property
    def n(self) -> int:
        """Number of unknowns."""
        return len(self.q)

    @lazy
    def units(self) -> Units:
        """Natural sizes of every x and y."""
        return self._units if isinstance(self._units, Units) else self._units()

    @lazy
    def prepared(self) -> tuple[Ints, Ints, Array, Array, Array, Array, Ints, Array, Ints]:
        """What kernels work on, in the order of the arrow that M is: see `kernels.contact.prepare`."""
        return prepare(self.M, self.q, self.role, self.blocks)

    def complete(self) -> None:
        """Compute now what is otherwise computed when first asked for."""
        self.prepared, self.units  # noqa: B018

    def __repr__(self) -> str:
        kind = "exact cone" if self.faces == 0 else "planar" if self.faces == 2 else f"{self.faces} faces"
        return f"{type(self).__name__}(n={self.n}, {len(self.blocks)} contacts with friction, {kind})"
