"""Linear complementarity problems, mixed or not, and what a solver and the certifier say of one."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, array, read_only
from handlcp.errors import InputError, shown
from handlcp.keywords import helped_init, helped_methods
from handlcp.lazy import lazy
from handlcp.lcp.scaling import Units, equilibrate
from handlcp.tolerances import LARGEST_RAW

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


class Scaled:
    """The problem in its natural units: M̂ (n, n), q̂ (n,), free (n,) and the `units` that lead back. See `scaling`."""

    __slots__ = ("M", "free", "q", "units")

    def __init__(self, M: Array, q: Array, free: Bools, units: Units) -> None:
        self.M, self.q, self.free, self.units = M, q, free, units


@helped_init()
@helped_methods
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
        self.q: Array = array("q", q, (-1,), largest=LARGEST_RAW)
        n = len(self.q)
        self.__dict__["M"] = array("M", M, (n, n), largest=LARGEST_RAW)
        self.free: Bools = _mask(free, n)
        if units is not None:
            _check_units(units, self.M, self.q)
        self._units = units

    def _hold(self, scaled: Scaled) -> None:
        """Take over a problem that is in natural units already: a subclass's constructor calls it instead of ours."""
        self.free, self._units = scaled.free, scaled.units
        self.__dict__["scaled"] = scaled
        self.q = read_only(scaled.q * scaled.units.w)

    @lazy
    def M(self) -> Array:
        """(n, n) matrix in the user's units."""
        s = self.scaled
        return read_only(s.M * s.units.w[:, None] / s.units.z)

    @lazy
    def scaled(self) -> Scaled:
        """The problem in natural units: what solvers see."""
        units = self._units or equilibrate(self.M, self.q)
        # Two steps, so that units from 1e-160 to 1e160 neither over- nor underflow on the way.
        M = np.ascontiguousarray(self.M / units.w[:, None] * units.z)
        return Scaled(read_only(M), read_only(self.q / units.w), self.free, units)

    @property
    def n(self) -> int:
        """Number of unknowns."""
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


def _mask(free: Any, n: int) -> Bools:
    try:
        mask = np.zeros(n, bool) if free is None else np.array(free)
    except ValueError:  # lists of different lengths
        raise InputError("free", f"a boolean mask of shape ({n},)", shown(free)) from None
    if mask.dtype != bool or mask.shape != (n,):
        raise InputError("free", f"a boolean mask of shape ({n},)", f"dtype {mask.dtype}, shape {mask.shape}")
    mask.flags.writeable = False
    return mask


def _check_units(units: Units, M: Array, q: Array) -> None:
    if not isinstance(units, Units):
        raise InputError("units", "Units(z, w)", repr(units))
    for name, u in (("units.z", units.z), ("units.w", units.w)):
        if not (array(name, u, (len(q),), largest=LARGEST_RAW) > 0).all():
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
