"""Natural units of a linear complementarity problem: one size for each z and one for each w.

With z = U_z ẑ and w = U_w ŵ (diagonal, positive), w = M z + q becomes ŵ = M̂ ẑ + q̂ with M̂ = U_w⁻¹ M U_z and
q̂ = U_w⁻¹ q. Complementarity is untouched. Solvers see the hatted problem only; a caller that knows the physics
(the grasp) gives the units, otherwise they are found by equilibration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, read_only

__all__ = ["Units", "equilibrate"]

_SWEEPS = 12  # Ruiz's iteration halves the logarithmic spread each time: 2^-12 of it is left


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
    Rows or columns of zeros keep the unit one.
    """
    n = len(q)
    z, w = np.ones(n), np.ones(n)
    A = abs(M)
    for _ in range(_SWEEPS):
        # Only the larger of the two factors of a pass may underflow for entries near 1e-308: sqrt keeps both in range.
        row, col = np.sqrt(A.max(axis=1, initial=0.0)), np.sqrt(A.max(axis=0, initial=0.0))
        row[row == 0], col[col == 0] = 1.0, 1.0
        A = A / row[:, None] / col
        w, z = w * row, z / col
    size = float((abs(q) / w).max(initial=0.0)) or 1.0
    return Units(read_only(z * size), read_only(w * size))
