"""`RowLayout`: where the numbers of several arrays stand in one row, which compiled code passes as one array."""

from __future__ import annotations

import math

import numpy as np

from handlcp.check import Array


class RowLayout:
    """Named arrays in one row of floats, one behind the other.

    parts : name → (where it stands, its shape). starts (m + 1,) : where each begins, in the order of the names, and the
    end of the last. size : of the row.
    """

    def __init__(self, shapes: dict[str, tuple[int, ...]], begin: int = 0) -> None:
        """Lay out arrays of these shapes. begin : numbers that stand before them."""
        self.parts = dict[str, tuple[slice, tuple[int, ...]]]()
        starts = [begin]
        for name, shape in shapes.items():
            starts.append(starts[-1] + math.prod(shape))
            self.parts[name] = slice(starts[-2], starts[-1]), shape
        self.starts, self.size = np.array(starts, dtype=np.int64), starts[-1]

    def read(self, row: Array, name: str) -> Array:
        """A view of one of the arrays."""
        at, shape = self.parts[name]
        found: Array = row[at]
        return found if len(shape) == 1 else found.reshape(shape)
