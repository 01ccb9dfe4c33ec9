"""The methods that the study compares: what each works on, and what its settings mean."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from handlcp.lcp import NSNGRK, Lemke, SemismoothNewton
from handlcp.lcp.solvers.printed import AsPrinted

__all__ = ["METHODS", "WHOLE", "Method"]

RES, STEPS = 1e-5, 20_000  # where the paper stops (section 5)
MOST = 200_000  # Kaczmarz steps that methods without Newton's may take


@dataclass(frozen=True, slots=True)
class Method:
    """name, meaning : in tables. form : what it works on, "SI" (the pyramid's LCP in metres and newtons as they are),
    "LCP" (the same in natural units), "cone" (friction as a set; faces mean nothing to it) or "grasp" (all of
    `grasp.solve`).

    make : the solver for a tolerance, at most so many steps, and a seed. most : steps at most. growth : how the cost of
    a step grows with the unknowns n, n^growth. tolerant : whether it has a tolerance; own : that it always runs with
    beside those asked for; None: the tightest.
    """

    name: str
    meaning: str
    form: str
    make: Callable[[float, int, int], Any]
    most: int = 1
    growth: int = 1
    tolerant: bool = True
    own: float | None = None


def _printed(tol: float, most: int, seed: int) -> Any:
    return AsPrinted(tol=tol, max_iterations=most, seed=seed)


def _unpolished(tol: float, most: int, seed: int) -> Any:
    return NSNGRK(tol=tol, max_iterations=most, seed=seed, polish=False)


def _polished(tol: float, most: int, seed: int) -> Any:
    return NSNGRK(tol=tol, max_iterations=most, seed=seed)


def _lemke(tol: float, most: int, seed: int) -> Any:
    return Lemke(max_iterations=most, seed=seed)


def _newton(tol: float, most: int, seed: int) -> Any:
    return SemismoothNewton(tol=tol, max_iterations=most)


WHOLE = Method("grasp.solve()", "all of it: assembly, solver, certificate", "grasp", _newton, tolerant=False)

# Cheap ones first: what they leave of the budget is for the others
METHODS: dict[str, Method] = {
    m.name: m
    for m in (
        WHOLE,
        Method("cone, Newton", "projection equations on the exact cone", "cone", _newton, 100, 3),
        Method("cone, NSNGRK", "Kaczmarz steps on the exact cone, no polish", "cone", _unpolished, MOST),
        Method("NSNGRK polished", "Kaczmarz and Newton steps, natural units", "LCP", _polished, STEPS),
        Method("Newton", "damped semismooth Newton, natural units", "LCP", _newton, 100, 3),
        Method("Lemke", "pivoting", "LCP", _lemke, 10_000, 2, tolerant=False),
        Method("NSNGRK scaled", "Kaczmarz steps alone, natural units", "LCP", _unpolished, MOST),
        Method("as printed, scaled", "the paper's code, but natural units", "LCP", _printed, STEPS, 2),
        Method("NSNGRK as printed", "the paper's: metres and newtons", "SI", _printed, STEPS, 2, own=RES),
    )
}
