"""What a solver proposes, and what `solve_lcp` returns."""

from __future__ import annotations

from dataclasses import dataclass, field

from handlcp.check import Array
from handlcp.lcp.status import Status


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
