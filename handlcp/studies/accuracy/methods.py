"""The methods that the study compares, and the settings that it runs them with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from handlcp.grasp import Pyramid
from handlcp.lcp import NSNGRK, Auto, Lemke, SemismoothNewton
from handlcp.studies.accuracy.as_printed import RES, STEPS, AsPrinted
from handlcp.tolerances import SOLVE_TOLERANCE

# ---------------------------------------------------------------- Errors and times for people.

ROUNDING = 1e-12  # errors below say nothing about methods and faces


def share(error: float) -> str:
    """An error for people: 0 where it is rounding, powers of ten, percents from 0.01 % on, multiples from ten on."""
    if error < ROUNDING:
        return "0"
    if error < 0.995e-4:
        return f"{error:.0e}"
    return f"{100 * error:.2g} %" if error < 0.995 else f"{100 * error:.0f} %" if error < 10 else f"{error:.0f} ×"


def microseconds(seconds: float) -> str:
    """A time for people: "42 µs", "3.1 ms", "1.2 s"."""
    for size, name in ((1e-6, "µs"), (1e-3, "ms")):
        if seconds < 999.5 * size:
            value = seconds / size
            return f"{value:.0f} {name}" if value >= 9.95 else f"{value:.1f} {name}"
    return f"{seconds:.2g} s"


# ----------------------------------------------------------------

FACES = (3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)
TOLERANCES = tuple(10.0**-k for k in range(1, 13))
_SWEPT = (8, 16)  # faces at which all tolerances are tried
MOST = 200_000  # Kaczmarz steps of methods without Newton steps at the end


@dataclass(frozen=True, slots=True)
class Method:
    """One method of solving whose cost is measured.

    meaning : in words.
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

    def configure(self, tol: float, most: int, seed: int) -> Any:
        """The solver with those of the settings that it has."""
        settings = {"tol": tol, "max_iterations": most, "seed": seed}
        return replace(self.solver, **{name: x for name, x in settings.items() if hasattr(self.solver, name)})


# Cheap ones first: the others get the time that they leave
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


@dataclass(frozen=True, slots=True)
class Setting:
    """A method with its faces, the pyramid's section and a tolerance, as in `Row`."""

    method: Method
    faces: int | None
    section: str
    tolerance: float | None

    @property
    def faces_asked(self) -> int | str | Pyramid:
        """The argument `faces` of `grasp.problem` and `grasp.solve`. LCPs of scenes without pyramids ignore the 8."""
        if self.faces is not None:
            return Pyramid(self.faces, inscribed=self.section == "inscribed")
        return 8 if self.method.form in ("LCP", "SI") else "cone"


def settings(
    methods: Sequence[Method], faces: Sequence[int] | None, tolerances: Sequence[float] | None, pyramids: bool
) -> dict[Method, tuple[Setting, ...]]:
    """The settings of each method, in the order in which to run them: not every pair, unless both lists are given.

    faces, tolerances : None: the study's own. pyramids : whether the scene has any; without them LCPs are exact, too,
    and faces mean nothing.
    """
    sides, tols, swept = faces or FACES, tolerances or TOLERANCES, faces or _SWEPT
    tight = min((t for t in tols if t >= SOLVE_TOLERANCE), default=min(tols))
    out: dict[Method, tuple[Setting, ...]] = {}
    for method in methods:
        if method.form == "grasp":
            cells = [Setting(method, None, "exact", None)]
            if pyramids:
                both = ("inscribed", "circumscribed")
                cells += [Setting(method, m, section, None) for m in sides for section in both]
        elif not pyramids or method.form == "cone":
            cells = [Setting(method, None, "exact", t) for t in (tols if method.tolerant else (None,))]
        elif not method.tolerant:
            cells = [Setting(method, m, "inscribed", None) for m in sides]
        else:
            few = tolerances or (method.own or tight,)
            cells = [Setting(method, m, "inscribed", t) for m in swept for t in tols]
            cells += [Setting(method, m, "inscribed", t) for m in sides for t in few]
        out[method] = tuple(dict.fromkeys(cells))
    return out
