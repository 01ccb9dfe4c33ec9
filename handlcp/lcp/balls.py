"""Contacts with friction in three dimensions: soft fingers, beside points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.lcp.problem import LCP
from handlcp.lcp.scaling import Units

__all__ = ["BallProblem"]


class BallProblem:
    """Find x with y = M x + q, in natural units, where each unknown plays one of three roles:

    free : y_i = 0. pair : 0 ≤ x_i ⟂ y_i ≥ 0.
    ball (N, T, O, S) : N is a pair; (x_T, x_O, x_S) in the ball of radius limit · x_N, and y there in minus its normal
        cone: zero inside, against x on the limit. Or in a polyhedron, whose faces are that far from the origin.

    M (n, n), q (n,), free (n,) bool. balls (k, 4): indices of the normal and of two or three tangents (-1: none).
    limits (k,) radius per unit of normal force [-]. faces : of polyhedra, the outward unit normals of those with two
    tangents (f, 3), their third component zero, and of those with three (g, 3); None: balls. units: natural sizes of
    every x and y.
    pyramid : the same scene with an m-face polyhedron instead of each ball as a plain `LCP`, and its z as an x. own :
    the m that stands for this very problem; 0: none, balls are no polyhedra.

    A `ContactProblem` is the same with two tangents at most: the one nearly all scenes have.
    """

    def __init__(
        self,
        M: Array,
        q: Array,
        free: Bools,
        balls: Ints,
        limits: Array,
        faces: tuple[Array, Array] | None,
        units: Units,
        pyramid: Callable[[int], tuple[LCP, Callable[[Array], Array]]],
        own: int,
    ) -> None:
        self.M, self.q, self.free = read_only(M), read_only(q), free
        self.balls, self.limits, self.units, self.pyramid, self.own = balls, limits, units, pyramid, own
        self.faces = (_NO_FACES, _NO_FACES) if faces is None else faces

    @property
    def n(self) -> int:
        """Number of unknowns."""
        return len(self.q)

    def complete(self) -> None:
        """Everything is there already."""

    def __repr__(self) -> str:
        kind = f"{len(self.faces[1])} faces" if len(self.faces[1]) else "exact cone"
        return f"{type(self).__name__}(n={self.n}, {len(self.balls)} contacts with friction, {kind})"


_NO_FACES = read_only(np.zeros((0, 3)))
