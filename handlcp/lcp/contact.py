"""Frictional contact as a complementarity problem with cones: its size does not depend on faces of any pyramid."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.lcp.problem import LCP
from handlcp.lcp.scaling import Units

__all__ = ["ContactProblem"]

_FREE, _PAIR, _TANGENT = 0, 1, 2


class ContactProblem:
    """Find x with y = M x + q, in natural units, where each unknown plays one of three roles:

    free : y_i = 0. pair : 0 ≤ x_i ⟂ y_i ≥ 0.
    friction block (N, T, O) : N is a pair; x_T in the disc (polygon, interval) of radius limit · x_N, and y_T in minus
        its normal cone: zero inside, against x_T on the limit. Second-order-cone complementarity, for the disc.

    M (n, n), q (n,), free (n,) bool. blocks (k, 3): indices of normal, first and second tangent (-1: planar).
    limits (k,) radius per unit of normal force [-]. faces: 0 the disc, ≥ 3 a regular polygon of that apothem with
    outward normals at 2πj/m, 2 an interval. units: natural sizes of every x and y.
    pyramid : how to get the same scene with an m-face pyramid as a plain `LCP`, and its z as an x, or None.
    """

    def __init__(
        self,
        M: Array,
        q: Array,
        free: Bools,
        blocks: Ints,
        limits: Array,
        faces: int,
        units: Units,
        pyramid: Callable[[int], tuple[LCP, Callable[[Array], Array]]] | None = None,
    ) -> None:
        self.M, self.q, self.free = read_only(M), read_only(q), free
        self.blocks, self.limits, self.faces, self.units, self.pyramid = blocks, limits, faces, units, pyramid

    @property
    def n(self) -> int:
        """Number of unknowns."""
        return len(self.q)

    @cached_property
    def role(self) -> Ints:
        """(n,) 0 free, 1 pair, 2 tangent of a friction block."""
        role = np.where(self.free, _FREE, _PAIR)
        tangents = self.blocks[:, 1:].ravel()
        role[tangents[tangents >= 0]] = _TANGENT
        return role

    @cached_property
    def rho(self) -> Array:
        """(n,) scale that makes ρ y comparable with x: one over the stiffness seen by each contact."""
        own = np.abs(np.diagonal(self.M)).copy()
        for block in self.blocks:
            mine = block[block >= 0]
            own[mine] = own[mine].mean()
        floor = 1e-6 * (own.max(initial=0.0) or 1.0)
        return 1.0 / np.where(own > 0, np.maximum(own, floor), 1.0)

    def __repr__(self) -> str:
        kind = "exact cone" if self.faces == 0 else "planar" if self.faces == 2 else f"{self.faces} faces"
        return f"{type(self).__name__}(n={self.n}, {len(self.blocks)} contacts with friction, {kind})"
