"""The conic programs of the largest loads: their equations, their units, and which loads need no program.

    max λ    W r + λ w = -w₀,  E r = e,  h - G r ∈ K

A factor far from one, in units of what the grasp bears, is computed again in units of its own, so that all are
accurate to the same share of themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.verify.capacity import Capacity
from handlcp.grasp.verify.cones import Cones
from handlcp.grasp.verify.conic import ENDED, NOTHING_FITS, UNBOUNDED, solve_conic
from handlcp.grasp.verify.newton import Conic
from handlcp.tolerances import RANK

_TOGETHER = 500  # programs at once: their matrices stay within a few dozen megabytes
_FROM, _TO = 1e-2, 1e3  # factors that are accurate as they are, in units of what the grasp bears
_AGAIN = 3  # changes of units
_DECIDED = 1e-3  # a gap that tells nothing from everything
_LEAST = 1e-9  # of what the grasp bears: what it holds of less is nothing


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """Of k wrenches, natural units: factors (k,), gaps (k,) relative, forces (k, m), multipliers (k, rows) of the rows
    of the capacity. NaN as in `Bounds`.
    """

    factors: Array
    gaps: Array
    forces: Array
    multipliers: Array

    def put(self, rows: Ints, other: Factors) -> None:
        self.factors[rows], self.gaps[rows] = other.factors, other.gaps
        self.forces[rows], self.multipliers[rows] = other.forces, other.multipliers


def depth(capacity: Capacity, base: Array) -> float:
    """The largest t ≤ 1 such that forces with t of room to every limit balance base (dof,), in units of what the grasp
    bears: < 0 where none balance it at all.
    """
    A, b = _equations(capacity, base)
    size, kept = _size(capacity, base), _range(A)
    if (abs(b - kept.T @ (kept @ b)) > RANK * max(size, float(abs(b).max(initial=0.0)))).any():
        return -1.0
    G, cones = capacity.G, capacity.cones
    room = np.column_stack([G, cones.unit])
    lid = np.append(np.zeros(G.shape[1]), 1.0)[None]
    program = Conic(
        -lid[0], np.column_stack([kept @ A, np.zeros(len(kept))])[None], (kept @ b / size)[None],
        np.concatenate([lid, room]), np.append(1.0, capacity.h / size)[None], _wider(cones),
    )  # fmt: skip
    found = solve_conic(program)
    return float(found.x[0, -1]) if found.status[0] == ENDED else -1.0


def largest(capacity: Capacity, base: Array, wrenches: Array) -> Factors:
    """The factors of wrenches (k, dof) beside a base (dof,) that is balanced."""
    k, m, rows = len(wrenches), capacity.G.shape[1], len(capacity.h)
    out = Factors(np.zeros(k), np.zeros(k), np.full((k, m), np.nan), np.zeros((k, rows)))
    length = np.sqrt((wrenches**2).sum(axis=1))
    A, _ = _equations(capacity, base)
    kept = _range(A)
    column = np.concatenate([wrenches, np.zeros((k, len(capacity.values)))], axis=1)
    outside = abs(column - column @ kept.T @ kept).max(axis=1, initial=0.0) > RANK * length
    out.factors[length == 0.0] = np.inf
    todo = np.flatnonzero((length > 0.0) & ~outside)
    units = np.full(k, _size(capacity, base))
    for _ in range(_AGAIN):
        if not len(todo):
            break
        for part in np.array_split(todo, -(-len(todo) // _TOGETHER)):
            out.put(part, _solved(capacity, base, wrenches[part], units[part], kept, length[part]))
        share = out.factors[todo] * length[todo] / units[todo]
        far = np.isfinite(share) & ((share < _FROM) | (share > _TO)) & (share > _LEAST)
        units[todo] *= np.where(far, share, 1.0)
        todo = todo[far]
    if not (base.any() or capacity.h.any() or capacity.values.any()):  # a cone bears all of a load, or nothing
        decided = (out.gaps < _DECIDED) & ~np.isinf(out.factors)
        out.factors[decided], out.gaps[decided] = 0.0, 0.0
    nothing = out.factors * length < _LEAST * _size(capacity, base)
    out.factors[nothing], out.gaps[nothing] = 0.0, 0.0
    return out


def _solved(capacity: Capacity, base: Array, wrenches: Array, units: Array, kept: Array, length: Array) -> Factors:
    """The programs of wrenches (p, dof) in units (p,) of force."""
    p, m, (A, b), cones = len(wrenches), capacity.G.shape[1], _equations(capacity, base), capacity.cones
    column = np.concatenate([wrenches / length[:, None], np.zeros((p, len(capacity.values)))], axis=1)
    whole = np.concatenate([np.tile(kept @ A, (p, 1, 1)), (column @ kept.T)[:, :, None]], axis=2)
    up = np.append(np.zeros(m), 1.0)
    G = np.concatenate([-up[None], np.column_stack([capacity.G, np.zeros(len(capacity.h))])])
    h = np.column_stack([np.zeros(p), np.outer(1.0 / units, capacity.h)])
    found = solve_conic(Conic(-up, whole, np.outer(1.0 / units, kept @ b), G, h, _wider(cones)))
    factors = np.where(found.status == ENDED, found.x[:, -1] * units / length, np.nan)
    factors[found.status == UNBOUNDED] = np.inf
    factors[found.status == NOTHING_FITS] = 0.0
    with np.errstate(divide="ignore"):
        gaps = found.gap * np.maximum(1.0, units / (factors * length))  # relative to the factor
    gaps[~(factors > 0.0)] = found.gap[~(factors > 0.0)]
    ended = (found.status == ENDED)[:, None]
    forces, z = np.where(ended, found.x[:, :m] * units[:, None], np.nan), np.where(ended, found.z[:, 1:], 0.0)
    return Factors(np.maximum(factors, 0.0), gaps, forces, z)


def _equations(capacity: Capacity, base: Array) -> tuple[Array, Array]:
    """(e, m) and (e,): balance, and forces that are known."""
    return np.concatenate([capacity.wrenches, capacity.equations]), np.concatenate([-base, capacity.values])


def _range(A: Array) -> Array:
    """(r, e) an orthonormal basis, in rows, of what the columns of A span."""
    u, s, _ = np.linalg.svd(A, full_matrices=False)
    return np.ascontiguousarray(u[:, s > RANK * s.max(initial=0.0)].T)


def _size(capacity: Capacity, base: Array) -> float:
    """Of what the grasp bears: the geometric mean of its limits and of the load that is there."""
    numbers = np.concatenate([abs(capacity.h), abs(capacity.values), [np.sqrt(base @ base)]])
    numbers = numbers[numbers > 0.0]
    return float(np.exp(np.log(numbers).mean())) if len(numbers) else 1.0


def _wider(cones: Cones) -> Cones:
    """With one half-line more, in front."""
    return Cones(cones.linear + 1, tuple([(g.dimension, g.count) for g in cones.groups]))
