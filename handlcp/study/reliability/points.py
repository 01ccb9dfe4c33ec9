"""Sobol points in blocks, each scrambled on its own."""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import qmc

from handlcp.check import Array

BLOCKS = 16  # at least: their spread tells how far the estimate may be off


class Blocks:
    """`count` blocks of `size` points each, a power of two, in d dimensions."""

    def __init__(self, seed: int, dimensions: int, size: int, count: int) -> None:
        self.seed, self.dimensions, self.size, self.count = seed, dimensions, size, count
        self._last: tuple[int, Array] | None = None  # the block that was asked for last, which slices share

    @property
    def samples(self) -> int:
        """Of all blocks."""
        return self.size * self.count

    def block(self, k: int) -> Array:
        """(size, d) points of [0, 1), the same on every call."""
        if self._last is not None and self._last[0] == k:
            return self._last[1]
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(k,)))
        made = np.asarray(qmc.Sobol(self.dimensions, scramble=True, seed=rng).random(self.size))
        self._last = k, made
        return made

    def points(self, begin: int, end: int) -> Array:
        """(end - begin, d) of samples in a row."""
        first, last = begin // self.size, -(-end // self.size)
        every = np.concatenate([self.block(k) for k in range(first, last)])
        return every[begin - first * self.size : end - first * self.size]


def blocks_of(seed: int, dimensions: int, samples: int) -> Blocks:
    """With 16 to 32 blocks, and at least so many samples."""
    size = 2 ** int(math.log2(samples / BLOCKS))
    return Blocks(seed, dimensions, size, -(-samples // size))
