"""The designs of a sweep, and which of them share grasps: those of one cell, from the ones in its middle.

Words and whole numbers among the choices make another hand, such as one with a finger more, and no grasp can be brought
from one to the other: each combination of them is a group for itself. Within it the cube is halved along the coordinate
in which designs lie farthest apart, until no cell has more than `MOST` (a k-d tree). All of it hangs on the points
alone: cells are the same wherever and in whatever order they are worked on.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints, check_integer
from handlcp.design.space import Choices, ParameterValue, Space
from handlcp.errors import InputError

GRID, SOBOL, LHS = "grid", "sobol", "lhs"
MOST = 256  # designs of a cell


def points(space: Space, sampling: Any, samples: Any, seed: Any) -> Array:
    """(n, d) of the unit cube. Raises InputError."""
    if sampling not in (GRID, SOBOL, LHS):
        raise InputError("sampling", f'"{GRID}", "{SOBOL}" or "{LHS}"', repr(sampling)[:80])
    check_integer("seed", seed, 0)
    if sampling == GRID:
        return space.grid(samples)
    return space.sobol(samples, seed) if sampling == SOBOL else space.lhs(samples, seed)


def numbered(space: Space, cube: Array) -> dict[int, dict[str, ParameterValue]]:
    """The parameters of each design, by its number."""
    return {k: space.point(u) for k, u in enumerate(cube)}


def cells_of(space: Space, cube: Array) -> list[list[int]]:
    """Numbers of the points (n, d) of each cell, those nearest to its middle first."""
    same = alike(space)
    kinds, near = cube[:, ~same], cube[:, same]
    _, group = np.unique(kinds, axis=0, return_inverse=True)
    every = np.arange(len(cube))
    return [cell for g in range(group.max() + 1) for cell in _halved(near, every[group.reshape(-1) == g])]


def alike(space: Space) -> Bools:
    """(d,) coordinates along which hands are much the same, so that a grasp can be brought from one to another."""
    apart = [isinstance(e, Choices) and not all(isinstance(v, float) for v in e.values) for e in space.free.values()]
    return ~np.array(apart, dtype=bool)


def _halved(cube: Array, own: Ints) -> Iterator[list[int]]:
    """Cells of these points."""
    there = cube[own]
    if len(own) <= MOST:
        middle = (there.min(axis=0) + there.max(axis=0)) / 2 if there.size else there
        away = ((there - middle) ** 2).sum(axis=1)
        yield own[np.argsort(away, kind="stable")].tolist()
        return
    widest = int(np.ptp(there, axis=0).argmax()) if there.size else 0
    order = own[np.argsort(there[:, widest], kind="stable")] if there.size else own
    for half in np.array_split(order, 2):
        yield from _halved(cube, half)
