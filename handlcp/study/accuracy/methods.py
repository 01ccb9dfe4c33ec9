"""The methods that the study compares: what each works on, and what its settings mean."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from handlcp.lcp import NSNGRK, Auto, Lemke, SemismoothNewton
from handlcp.lcp.solvers.printed import AsPrinted
from handlcp.study.nsngrk import RES, STEPS

__all__ = ["METHODS", "Method"]

MOST = 200_000  # Kaczmarz steps of methods that end without Newton's


@dataclass(frozen=True, slots=True)
class Method:
    """One method.

    form : what it works on. "grasp": all of `grasp.solve`. "cone": friction as a set, so that faces mean nothing.
        "LCP": the pyramid's complementarity problem in natural units. "SI": the same in metres and newtons.
    most : steps at most. growth : the cost of a step grows as n^growth with the unknowns n.
    own : a tolerance with which it runs beside those asked for; None: the tightest of them.
    """

    name: str
    meaning: str
    form: str
    solver: Any
    most: int = 1
    growth: int = 1
    own: float | None = None

    @property
    def tolerant(self) -> bool:
        """Whether it has a tolerance."""
        return hasattr(self.solver, "tol")

    def set(self, tol: float, most: int, seed: int) -> Any:
        """The solver with those of the settings that it has."""
        settings = {"tol": tol, "max_iterations": most, "seed": seed}
        return replace(self.solver, **{name: x for name, x in settings.items() if hasattr(self.solver, name)})


# Cheap ones first: what they leave of the budget is for the others
METHODS: dict[str, Method] = {
    m.name: m
    for m in (
        Method("grasp.solve()", "all of it: assembly, solver, certificate", "grasp", Auto()),
        Method("cone, Newton", "projection equations on the exact cone", "cone", SemismoothNewton(), 100, 3),
        Method("cone, NSNGRK", "Kaczmarz steps on the exact cone, no polish", "cone", NSNGRK(polish=False), MOST),
        Method("NSNGRK polished", "Kaczmarz and Newton steps, natural units", "LCP", NSNGRK(), STEPS),
        Method("Newton", "damped semismooth Newton, natural units", "LCP", SemismoothNewton(), 100, 3),
        Method("Lemke", "pivoting", "LCP", Lemke(), 10_000, 2),
        Method("NSNGRK scaled", "Kaczmarz steps alone, natural units", "LCP", NSNGRK(polish=False), MOST),
        Method("as printed, scaled", "the paper's code, but natural units", "LCP", AsPrinted(), STEPS, 2),
        Method("NSNGRK as printed", "the paper's: metres and newtons", "SI", AsPrinted(), STEPS, 2, RES),
    )
}
