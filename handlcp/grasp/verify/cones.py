"""Products of half-lines and second-order cones, and Nesterov and Todd's scaling of pairs in them, for many at once.

    Q_d = {(t, u) : t ≥ |u|, u ∈ R^{d-1}},    W z = W⁻¹ s

Source: Vandenberghe, The CVXOPT linear and quadratic cone program solvers (2010), sections 2 and 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.lazy import lazy


@dataclass(frozen=True, slots=True)
class _Group:
    """count cones of `dimension` whose rows begin at `start`, one after the other."""

    start: int
    count: int
    dimension: int

    def of(self, a: Array) -> Array:
        """(p, count, dimension) their rows of (p, m)."""
        return a[:, self.start : self.start + self.count * self.dimension].reshape(len(a), self.count, self.dimension)


class Cones:
    """The cones of m rows: `linear` half-lines, then so many second-order cones of each dimension, in order."""

    def __init__(self, linear: int, more: tuple[tuple[int, int], ...]) -> None:
        """More : (dimension, count) of second-order cones."""
        self.linear, at, groups = linear, linear, []
        for dimension, count in more:
            if count:
                groups.append(_Group(at, count, dimension))
                at += dimension * count
        self.groups, self.rows = tuple(groups), at
        self.count = linear + sum(g.count for g in groups)

    @lazy
    def unit(self) -> Array:
        """(m,) e: 1 on half-lines, (1, 0, …) on cones."""
        e = np.zeros(self.rows)
        e[: self.linear] = 1.0
        for g in self.groups:
            e[g.start : g.start + g.count * g.dimension : g.dimension] = 1.0
        return e

    def product(self, a: Array, b: Array) -> Array:
        """(p, m) a ∘ b = (aᵀb, a₀ b₁ + b₀ a₁) on every cone."""
        out = a * b
        for g in self.groups:
            x, y, z = g.of(a), g.of(b), g.of(out)
            first = (x * y).sum(axis=2)
            z[:, :, 1:] = x[:, :, :1] * y[:, :, 1:] + y[:, :, :1] * x[:, :, 1:]
            z[:, :, 0] = first
            out[:, g.start : g.start + g.count * g.dimension] = z.reshape(len(a), -1)
        return np.asarray(out)

    def divided(self, a: Array, b: Array) -> Array:
        """(p, m) the x with a ∘ x = b."""
        out = b / np.where(a == 0.0, 1.0, a)
        for g in self.groups:
            x, y = g.of(a), g.of(b)
            t, u = x[:, :, 0], x[:, :, 1:]
            det = _gap(x)
            along = (u * y[:, :, 1:]).sum(axis=2)
            first = (t * y[:, :, 0] - along) / det
            rest = (y[:, :, 1:] - first[:, :, None] * u) / t[:, :, None]
            whole = np.concatenate([first[:, :, None], rest], axis=2)
            out[:, g.start : g.start + g.count * g.dimension] = whole.reshape(len(a), -1)
        return np.asarray(out)

    def scaling(self, s: Array, z: Array) -> Scaling:
        """Of pairs (p, m) inside the cones."""
        return Scaling(self, s, z)


class Scaling:
    """W of pairs (s, z), (p, m) each. point (p, m) : W z = W⁻¹ s."""

    def __init__(self, cones: Cones, s: Array, z: Array) -> None:
        self.cones = cones
        k = cones.linear
        self._line = np.sqrt(s[:, :k] / z[:, :k])
        self._parts: list[tuple[Array, Array]] = []
        for g in cones.groups:
            a, b = g.of(s), g.of(z)
            ga, gb = np.sqrt(_gap(a)), np.sqrt(_gap(b))
            a, b = a / ga[:, :, None], b / gb[:, :, None]
            half = np.sqrt((1.0 + (a * b).sum(axis=2)) / 2.0)[:, :, None]
            b = np.concatenate([b[:, :, :1], -b[:, :, 1:]], axis=2)
            self._parts.append((np.sqrt(ga / gb)[:, :, None], (a + b) / (2.0 * half)))
        self.point = self.times(z)

    def times(self, a: Array) -> Array:
        """(p, m) W a."""
        return self._applied(a, 1.0)

    def inverse(self, a: Array) -> Array:
        """(p, m) W⁻¹ a."""
        return self._applied(a, -1.0)

    def _applied(self, a: Array, sign: float) -> Array:
        k, out = self.cones.linear, np.empty_like(a)
        out[:, :k] = a[:, :k] * self._line if sign > 0 else a[:, :k] / self._line
        for g, (eta, w) in zip(self.cones.groups, self._parts, strict=True):
            x = g.of(a)
            t, u, v = x[:, :, :1], x[:, :, 1:], sign * w[:, :, 1:]
            along = (v * u).sum(axis=2)[:, :, None]
            whole = np.concatenate([w[:, :, :1] * t + along, u + (t + along / (1.0 + w[:, :, :1])) * v], axis=2)
            whole = whole * eta if sign > 0 else whole / eta
            out[:, g.start : g.start + g.count * g.dimension] = whole.reshape(len(a), -1)
        return out

    def rows(self, G: Array) -> Array:
        """(p, m, v) W⁻¹ G of a matrix (m, v)."""
        k, p = self.cones.linear, len(self._line)
        out = np.empty((p, *G.shape))
        out[:, :k] = G[:k] / self._line[:, :, None]
        for g, (eta, w) in zip(self.cones.groups, self._parts, strict=True):
            block = G[g.start : g.start + g.count * g.dimension].reshape(g.count, g.dimension, -1)
            t, u, v = block[:, :1], block[:, 1:], -w[:, :, 1:, None]
            along = (v * u).sum(axis=2, keepdims=True)
            head = w[:, :, :1, None]
            whole = np.concatenate([head * t + along, u + (t + along / (1.0 + head)) * v], axis=2) / eta[..., None]
            out[:, g.start : g.start + g.count * g.dimension] = whole.reshape(p, -1, G.shape[1])
        return out

    def closing(self, d: Array) -> Array:
        """(p,) 1/α of the largest α with point + α d in the cones; ≤ 0 where all are."""
        k = self.cones.linear
        worst = (-d[:, :k] / self.point[:, :k]).max(axis=1, initial=-np.inf)
        for g in self.cones.groups:
            x, y = g.of(self.point), g.of(d)
            size = np.sqrt(_gap(x))[:, :, None]
            x = x / size
            first = x[:, :, :1] * y[:, :, :1] - (x[:, :, 1:] * y[:, :, 1:]).sum(axis=2, keepdims=True)
            rest = y[:, :, 1:] - (first + y[:, :, :1]) / (1.0 + x[:, :, :1]) * x[:, :, 1:]
            far = np.sqrt((rest * rest).sum(axis=2)) - first[:, :, 0]
            worst = np.maximum(worst, (far / size[:, :, 0]).max(axis=1))
        return np.asarray(worst)


def _gap(x: Array) -> Array:
    """(p, count) t² - |u|² without cancelling."""
    u = np.sqrt((x[:, :, 1:] ** 2).sum(axis=2))
    return np.asarray((x[:, :, 0] - u) * (x[:, :, 0] + u))
