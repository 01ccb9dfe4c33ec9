"""`LCP`: a linear complementarity problem and its natural units; `Status`: what is known of one, and of a grasp.

With z = U_z ẑ and w = U_w ŵ (diagonal, positive), w = M z + q becomes ŵ = M̂ ẑ + q̂ with M̂ = U_w⁻¹ M U_z and
q̂ = U_w⁻¹ q. Complementarity is untouched. Solvers see the hatted problem only; a caller that knows the physics
(the grasp) gives the units, otherwise they are found by equilibration.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, check_array, check_init_call, check_method_calls, read_only
from handlcp.errors import InputError, shorten_repr
from handlcp.lazy_property import lazy_property
from handlcp.tolerances import MAX_RAW_NUMBER

_MAX_SWEEPS = 12  # Ruiz's iteration halves the logarithmic spread each time: 2^-12 of it is left
_MIN_UNIT, _MAX_UNIT = 1e-300, 1e250  # units: their products with numbers in natural units still fit a float64


@dataclass(frozen=True, slots=True)
class Units:
    """Sizes of one natural unit of every z and w, (n,) each, positive, in the user's units."""

    z: Array
    w: Array

    @staticmethod
    def ones(n: int) -> Units:
        """Units of 1, so that solvers work on the numbers as they are (the paper's way)."""
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
        for _ in range(_MAX_SWEEPS):
            # No entry exceeds one: units of w only shrink and those of z only grow, and cutting them lets no entry grow
            row, col = np.sqrt(A.max(axis=1, initial=0.0)), np.sqrt(A.max(axis=0, initial=0.0))
            row[row == 0], col[col == 0] = 1.0, 1.0
            A = A / row[:, None] / col
            w, z = w * row, z / col
        w, z = np.maximum(w * root, _MIN_UNIT), np.minimum(z / root, _MAX_UNIT)
        size = float((abs(q) / w).max(initial=0.0)) or 1.0
    size = max(size, _MIN_UNIT / float(z.min(initial=1.0)))
    if size * float(max(z.max(initial=0.0), w.max(initial=0.0))) > _MAX_UNIT:
        raise InputError("q", f"numbers so small beside those of M that z stays below {_MAX_UNIT:g}", "larger ones")
    return Units(read_only(z * size), read_only(np.maximum(w * size, _MIN_UNIT)))


# ----------------------------------------------------------------
# What may come out of a solve. A status is the certifier's word, never the solver's.


class Status(Enum):
    """The value of each member is its meaning and what to do about it."""

    SOLVED = "solved: every condition was recomputed and holds within the stated residual"
    INFEASIBLE = "infeasible: no z ≥ 0 gives w = M z + q ≥ 0; the certificate y ≥ 0 proves it (Mᵀy ≤ 0, qᵀy < 0)"
    NO_EQUILIBRIUM = (
        "no elastic equilibrium: some contact forces balance the wrench, but these compliances and gaps cannot create "
        "them; squeeze harder (preload) or change the flexibility"
    )
    NOT_HOLDABLE = (
        "not holdable: no contact forces within friction balance the wrench; the certificate is a motion in which the "
        "object escapes; add or move fingers, or raise friction"
    )
    UNDECIDED = (
        "undecided: the solver's budget was spent without an answer; this says nothing about the scene; "
        "try more iterations, another seed or another solver"
    )

    @property
    def meaning(self) -> str:
        """The sentence for people."""
        return self.value


# ----------------------------------------------------------------
# The (mixed) linear complementarity problem as a value.


class ScaledLCP(NamedTuple):
    """The problem in its natural units, which `units` lead back from: M̂ (n, n), q̂ (n,), free (n,)."""

    M: Array
    q: Array
    free: Bools
    units: Units


@check_init_call()
@check_method_calls
class LCP:
    """Find z with w = M z + q, where w_i = 0 for free i, and 0 ≤ z_i ⟂ w_i ≥ 0 for the others.

    Parameters
    ----------
    M : (n, n) matrix, any.
    q : (n,) vector.
    free : (n,) bool, rows that are equations and whose z has no sign; None: none (the standard LCP, paper (17)).
    units : sizes of one natural unit of each z and w. None: found by equilibration. `Units.ones(n)`: solvers take the
        numbers as they are.

    Raises InputError for wrong shapes, numbers not finite, units that are not positive.
    """

    def __init__(self, M: Any, q: Any, free: Any = None, *, units: Units | None = None) -> None:
        self.q: Array = check_array("q", q, (-1,), largest=MAX_RAW_NUMBER)
        n = len(self.q)
        self.__dict__["M"] = check_array("M", M, (n, n), largest=MAX_RAW_NUMBER)
        self.free: Bools = _free_mask(free, n)
        if units is not None:
            _check_units(units, self.M, self.q)
        self._units = units

    def _adopt_scaled(self, scaled: ScaledLCP) -> None:
        """Take over a problem that is in natural units already: a subclass's constructor calls it instead of ours."""
        self.free, self._units = scaled.free, scaled.units
        self.__dict__["scaled"] = scaled
        self.q = read_only(scaled.q * scaled.units.w)

    @lazy_property
    def M(self) -> Array:
        """(n, n) matrix in the user's units."""
        s = self.scaled
        return read_only(s.M * s.units.w[:, None] / s.units.z)

    @lazy_property
    def scaled(self) -> ScaledLCP:
        """The problem in natural units: what solvers see."""
        units = self._units or equilibrate(self.M, self.q)
        # Two steps, so that units from 1e-160 to 1e160 neither over- nor underflow on the way.
        M = np.ascontiguousarray(self.M / units.w[:, None] * units.z)
        return ScaledLCP(read_only(M), read_only(self.q / units.w), self.free, units)

    @property
    def n(self) -> int:
        """The number of unknowns of the problem."""
        return len(self.q)

    @property
    def mixed(self) -> bool:
        """Whether there are free rows."""
        return bool(self.free.any())

    def unscaled(self) -> LCP:
        """The same problem with natural units of one, so that solvers work on the numbers as they are."""
        return LCP(self.M, self.q, self.free, units=Units.ones(self.n))

    def __repr__(self) -> str:
        kind = f"mixed, {int(self.free.sum())} free" if self.mixed else "standard"
        return f"{type(self).__name__}(n={self.n}, {kind})"


def _free_mask(free: Any, n: int) -> Bools:
    try:
        mask = np.zeros(n, bool) if free is None else np.array(free)
    except ValueError:  # lists of different lengths
        raise InputError("free", f"a boolean mask of shape ({n},)", shorten_repr(free)) from None
    if mask.dtype != bool or mask.shape != (n,):
        raise InputError("free", f"a boolean mask of shape ({n},)", f"dtype {mask.dtype}, shape {mask.shape}")
    mask.flags.writeable = False
    return mask


def _check_units(units: Units, M: Array, q: Array) -> None:
    if not isinstance(units, Units):
        raise InputError("units", "Units(z, w)", repr(units))
    for name, u in (("units.z", units.z), ("units.w", units.w)):
        if not (check_array(name, u, (len(q),), largest=MAX_RAW_NUMBER) > 0).all():
            raise InputError(name, "positive numbers", f"a smallest of {u.min():.3g}")
    with np.errstate(over="ignore"):
        fits = np.isfinite(M / units.w[:, None] * units.z).all() and np.isfinite(q / units.w).all()
    if not fits:
        raise InputError("units", "units in which M and q fit a float64", "units in which they overflow")


# ----------------------------------------------------------------
# What a solver proposes, and what `solve_lcp` returns.


@dataclass(frozen=True, slots=True)
class Proposal:
    """A solver's candidate in natural units: nothing more than a proposal until the certifier has seen it.

    z : (n,) candidate, natural units.
    iterations : how many steps of the method's own kind were taken.
    outcome : the solver's own words, for the trace ("converged", "secondary ray", …).
    history : (k, 2) step number and ‖Φ‖₂, when asked for.
    """

    z: Array
    iterations: int
    outcome: str
    history: Array | None = None


@dataclass(frozen=True, slots=True)
class LCPSolution:
    """The certified answer to an `LCP`, in the user's units.

    z, w : (n,) unknowns and their complements, w = M z + q recomputed; NaN throughout unless there is an answer
        worth looking at (SOLVED, or the best iterate of UNDECIDED).
    status : the certifier's verdict.
    residual : worst natural residual, relative to the problem's units (see `certify`).
    iterations : steps of the method that gave the answer.
    certificate : for INFEASIBLE the Farkas vector y (n,), otherwise None.
    outcome : the solver's own words.
    trace : one line per stage that ran.
    history : residual history, when the solver was asked for it.
    """

    z: Array
    w: Array
    status: Status
    residual: float
    iterations: int
    certificate: Array | None = None
    outcome: str = ""
    trace: tuple[str, ...] = ()
    history: Array | None = field(default=None, repr=False)


def stage_line(name: str, outcome: str, iterations: int, residual: float) -> str:
    """What a trace says of a stage."""
    return f"{name}: {outcome}, {iterations} iterations, residual {residual:.1e}"
