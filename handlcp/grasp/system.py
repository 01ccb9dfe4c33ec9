"""Where effects stamp: named groups of unknowns, and the blocks of w = M x + q between them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array

__all__ = ["System", "Unknown"]


@dataclass(frozen=True, slots=True)
class Unknown:
    """A group of unknowns that an effect brings, each with a row of its own.

    name : of the group ("r_N", "u", …); blocks are addressed by it.
    count : how many.
    free : rows are equations and the unknowns have no sign; otherwise 0 ≤ x ⟂ w ≥ 0.
    unit, row_unit : SI units of x and of its row w, for people.
    size, row_size : SI size of one natural unit of x and of w, a number or (count,).
    """

    name: str
    count: int
    free: bool
    unit: str
    row_unit: str
    size: float | Array
    row_size: float | Array


class System:
    """M (N, N) and q (N,) in natural units, complementary groups first, free groups last."""

    __slots__ = ("M", "at", "free_from", "groups", "q")

    def __init__(self, unknowns: Iterable[Unknown]) -> None:
        groups = [u for u in unknowns if u.count]
        self.groups = tuple([u for u in groups if not u.free] + [u for u in groups if u.free])
        self.at: dict[str, slice] = {}
        start = 0
        self.free_from = 0
        for g in self.groups:
            self.at[g.name] = slice(start, start + g.count)
            start += g.count
            if not g.free:
                self.free_from = start
        self.M, self.q = np.zeros((start, start)), np.zeros(start)

    def __contains__(self, name: str) -> bool:
        return name in self.at

    def add(self, row: str, column: str, block: Array | float) -> None:
        """M[row, column] += block, when the scene has both groups."""
        if row in self.at and column in self.at:
            self.M[self.at[row], self.at[column]] += block

    def load(self, row: str, values: Array | float) -> None:
        """q[row] += values, when the scene has that group."""
        if row in self.at:
            self.q[self.at[row]] += values

    def sizes(self) -> tuple[Array, Array]:
        """(N,) SI sizes of one natural unit of every x and every w."""
        x, w = np.empty(len(self.q)), np.empty(len(self.q))
        for g in self.groups:
            x[self.at[g.name]], w[self.at[g.name]] = g.size, g.row_size
        return x, w
