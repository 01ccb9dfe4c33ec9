"""The linear equations of one step of many conic programs, in two forms.

    [0  Aᵀ  Gᵀ] [x]   [p_x]
    [A  0   0 ] [y] = [p_y]
    [G  0  -W²] [z]   [p_z]

Without z they are short: H = Gᵀ W⁻² G and A. That squares their condition. With W z in place of z they are long, and
do not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.verify.cones import Cones, Scaling


class Conic(NamedTuple):
    """c (v,), A (p, e, v) of p programs, b (p, e), G (m, v), h (p, m), and the cones of the m rows."""

    c: Array
    A: Array
    b: Array
    G: Array
    h: Array
    cones: Cones

    def at(self, rows: Ints) -> Conic:
        """Some of the programs."""
        return self._replace(A=self.A[rows], b=self.b[rows], h=self.h[rows])


class Reduced:
    """The short equations; each answer is refined twice against what rounding left."""

    def __init__(self, programs: Conic, scaling: Scaling) -> None:
        self.programs, self.scaling = programs, scaling
        p, e, v = programs.A.shape
        across = scaling.rows(programs.G)
        K = np.zeros((p, v + e, v + e))
        K[:, :v, :v] = across.transpose(0, 2, 1) @ across
        K[:, v:, :v], K[:, :v, v:] = programs.A, programs.A.transpose(0, 2, 1)
        size = np.ones((p, v + e))
        size[:, :v] = 1.0 / np.sqrt(np.maximum(np.einsum("pii->pi", K[:, :v, :v]), 1e-300))
        size[:, v:] = 1.0 / np.sqrt(np.maximum((programs.A**2 * size[:, None, :v] ** 2).sum(axis=2), 1e-300))
        self._size, self._inverse = size, _inverse(K * size[:, :, None] * size[:, None, :])

    def solve(self, px: Array, py: Array, pz: Array) -> tuple[Array, Array, Array]:
        """(x, y, z) for these right-hand sides (p, ·)."""
        G, A = self.programs.G, self.programs.A
        x, y, z = self._once(px, py, pz)
        for _ in range(2):
            ex = px - np.einsum("pev,pe->pv", A, y) - z @ G
            ey = py - np.einsum("pev,pv->pe", A, x)
            ez = pz - x @ G.T + self.scaling.times(self.scaling.times(z))
            dx, dy, dz = self._once(ex, ey, ez)
            x, y, z = x + dx, y + dy, z + dz
        return x, y, z

    def _once(self, px: Array, py: Array, pz: Array) -> tuple[Array, Array, Array]:
        G, v = self.programs.G, px.shape[1]
        less = self.scaling.inverse(self.scaling.inverse(pz))
        right = np.concatenate([px + less @ G, py], axis=1) * self._size
        found = (self._inverse @ right[:, :, None])[:, :, 0] * self._size
        x = found[:, :v]
        return x, found[:, v:], self.scaling.inverse(self.scaling.inverse(x @ G.T - pz))


class Whole:
    """The long equations, by elimination with pivots."""

    def __init__(self, programs: Conic, scaling: Scaling) -> None:
        self._scaling = scaling
        p, e, v = programs.A.shape
        across = scaling.rows(programs.G)
        m = across.shape[1]
        K = np.zeros((p, v + e + m, v + e + m))
        K[:, :v, v : v + e], K[:, v : v + e, :v] = programs.A.transpose(0, 2, 1), programs.A
        K[:, :v, v + e :], K[:, v + e :, :v] = across.transpose(0, 2, 1), across
        K[:, range(v + e, v + e + m), range(v + e, v + e + m)] = -1.0
        # Columns of x have the size of their largest entry; what is free altogether is held by a little
        size = np.ones((p, v + e + m))
        size[:, :v] = 1.0 / np.maximum(abs(K[:, :, :v]).max(axis=1), 1e-300)
        self._size, self._K, self._parts = size, K * size[:, :, None] * size[:, None, :], (v, v + e)

    def solve(self, px: Array, py: Array, pz: Array) -> tuple[Array, Array, Array]:
        """As `Reduced.solve`."""
        right = np.concatenate([px, py, self._scaling.inverse(pz)], axis=1) * self._size
        try:
            found = np.linalg.solve(self._K, right[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            n = self._K.shape[1]
            found = np.linalg.solve(self._K + 1e-14 * np.eye(n), right[:, :, None])[:, :, 0]
        x, y, z = np.split(found * self._size, self._parts, axis=1)
        return x, y, self._scaling.inverse(z)


def _inverse(K: Array) -> Array:
    """Of each matrix; where one is singular to the last bit, all are moved by their rounding."""
    try:
        return np.asarray(np.linalg.inv(K))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.inv(K + 1e-14 * np.eye(K.shape[1])))
