"""What studies of NSNGRK have in common: the paper's settings, and the units in which a problem is solved."""

from __future__ import annotations

from typing import Literal

from handlcp.check import Array
from handlcp.lcp import LCP
from handlcp.lcp.problem import Scaled

RES, STEPS = 1e-5, 20_000  # where the paper stops: ‖Φ‖₂ < RES, or after so many steps (section 5)
SEEDS = tuple(range(6))

UnitsOf = Literal["natural", "equilibrated", "given"]


def in_units(problem: LCP, units: UnitsOf) -> tuple[Scaled, Array]:
    """(the problem in these units, sizes (n,)): z in these units divided by the sizes is z in natural units.

    "natural": the problem's own. "equilibrated": found from M and q alone (Ruiz). "given": the user's, as in the paper.
    """
    if units == "natural":
        scaled = problem.scaled
    elif units == "given":
        scaled = problem.unscaled().scaled
    else:
        scaled = LCP(problem.M, problem.q, problem.free).scaled
    return scaled, problem.scaled.units.z / scaled.units.z
