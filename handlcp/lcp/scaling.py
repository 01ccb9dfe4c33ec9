"""Natural units of a linear complementarity problem: one size for each z and one for each w.

With z = U_z ẑ and w = U_w ŵ (diagonal, positive), w = M z + q becomes ŵ = M̂ ẑ + q̂ with M̂ = U_w⁻¹ M U_z and
q̂ = U_w⁻¹ q. Complementarity is untouched. Solvers see the hatted problem only; a caller that knows the physics
(the grasp) gives the units, otherwise they are found by equilibration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError

_SWEEPS = 12  # Ruiz's iteration halves the logarithmic spread each time: 2^-12 of it is left
_LEAST, _MOST = 1e-300, 1e250  # units: their products with numbers in natural units still fit a float64


@dataclass(frozen=True, slots=True)
class Units:
    """Sizes of one natural unit of every z and w, (n,) each, positive, in the user's units."""

    z: Array
    w: Array

    @staticmethod
    def ones(n: int) -> Units:
        """No scaling: solvers then work on the numbers as they are (the paper's way)."""
        one = read_only(np.ones(n))
        return Units(one, one)


def equilibrate(M: Array, q: Array) -> Units:
    """Units in which the largest entry of each row and column of M̂ is about one, and so is the largest |q̂|.

    Ruiz's simultaneous row and column scaling (D. Ruiz, RAL-TR-2001-034), then one common factor for q.
    Rows or columns of zeros keep the unit of the largest. Raises InputError where z or w may outgrow a float64.
    """
    n = len(q)
    z, w = np.ones(n), np.ones(n)
    A = abs(M)
    largest = float(A.max(initial=0.0)) or 1.0
    A, root = A / largest, largest**0.5
    with np.errstate(over="ignore"):  # what overflows is cut back, or refused
        for _ in range(_SWEEPS):
            # No entry exceeds one: units of w only shrink and those of z only grow, and cutting them lets no entry grow
            row, col = np.sqrt(A.max(axis=1, initial=0.0)), np.sqrt(A.max(axis=0, initial=0.0))
            row[row == 0], col[col == 0] = 1.0, 1.0
            A = A / row[:, None] / col
            w, z = w * row, z / col
        w, z = np.maximum(w * root, _LEAST), np.minimum(z / root, _MOST)
        size = float((abs(q) / w).max(initial=0.0)) or 1.0
    size = max(size, _LEAST / float(z.min(initial=1.0)))
    if size * float(max(z.max(initial=0.0), w.max(initial=0.0))) > _MOST:
        raise InputError("q", f"numbers so small beside those of M that z stays below {_MOST:g}", "larger ones")
    return Units(read_only(z * size), read_only(np.maximum(w * size, _LEAST)))
