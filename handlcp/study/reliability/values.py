"""The values of many samples as arrays, parameter by parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.study.reliability.spread import Dimension


@dataclass(frozen=True, slots=True)
class Values:
    """rows (m, d) : of m samples, in the order of the dimensions."""

    dimensions: Sequence[Dimension]
    rows: Array

    def one(self, parameter: str) -> list[float | None]:
        """(m,) of a parameter with one value; None where it does not vary."""
        for d, column in zip(self.dimensions, self.rows.T, strict=True):
            if d.parameter == parameter:
                return list(column.tolist())
        return [None] * len(self.rows)

    def each(self, parameter: str, count: int, default: Array | float) -> Array | None:
        """(m, count) of a parameter with a value for each contact, joint or tip; None where it does not vary."""
        out: Array | None = None
        for d, column in zip(self.dimensions, self.rows.T, strict=True):
            if d.parameter == parameter:
                if out is None:
                    out = np.broadcast_to(default, (len(self.rows), count)).astype(float)
                out[:, list(d.at) if d.at else slice(None)] = column[:, None]
        return out

    def shifts(self, count: int) -> Array | None:
        """(m, count, 2) of contacts along their tangents [m]; None where none moves."""
        out: Array | None = None
        for d, column in zip(self.dimensions, self.rows.T, strict=True):
            if d.parameter == "positions":
                out = np.zeros((len(self.rows), count, 2)) if out is None else out
                out[:, d.at[0], d.at[1]] = column
        return out
