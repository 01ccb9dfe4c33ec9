"""What is wrong in the paper: values missed, and where no equilibrium exists."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp import Grasp, GraspSolution
from handlcp.lcp.search import SearchResult, search
from handlcp.method.paper.data import AXES, COLUMN, PRELOAD, PaperTable, example, short
from handlcp.method.paper.printed import SignedForces, against_faces, compatibility, excess, motion, signed_forces

# ----------------------------------------------------------------
# Example 4: held by friction, yet no elastic equilibrium; a little preload gives one.
#
# Three statements, and what shows each:
#
# - A force in the friction pyramids balances the weight. The certified answer with preload is such a force: preload
# changes elastic displacements, not which forces can hold. - There is no elastic equilibrium without preload, with
# normal forces and friction reserves up to 1000 N, slips and gaps up to 1 mm. A search over all active sets (`search`)
# finds none. - The search does find equilibria that exist: on the preloaded scene it finds the certified forces.

FORCE_BOUND, MOTION_BOUND = 1000.0, 1e-3  # N, m
WORK = 1e10  # multiply-adds for each search, a minute at most
FACES = (4, 6, 8)
PRELOAD_FACES = 8


@dataclass(frozen=True, slots=True)
class NoEquilibrium:
    """What is known of Example 4.

    unloaded : our answer without preload (6 faces, as Table 9). preloaded : with 5 µm on fingers 1 and 2, 8 faces.
    searches : ((faces, E_T [m/N], result), …) without preload. control : the search on the preloaded scene.
    control_normal : (n,) N normal forces that it found.
    """

    unloaded: GraspSolution
    preloaded: GraspSolution
    searches: tuple[tuple[int, float, SearchResult], ...]
    control: SearchResult
    control_normal: Array

    @property
    def proved(self) -> bool:
        """Whether all searches came out empty and the control did not."""
        return all(r.none_exists for *_, r in self.searches) and self.control.z is not None


def search_grasp(grasp: Grasp, faces: int) -> SearchResult:
    """All active sets, forces within `FORCE_BOUND`, slips and gaps within `MOTION_BOUND`; z in natural units."""
    problem = grasp.problem(faces)
    force = np.array([label.startswith("r_N") for label in problem.labels])
    z, w = np.where(force, FORCE_BOUND, MOTION_BOUND), np.where(force, MOTION_BOUND, FORCE_BOUND)
    return search(problem, z / problem.scaled.units.z, w / problem.scaled.units.w, WORK)


def no_equilibrium() -> NoEquilibrium:
    """Solve and search Example 4, with E_T of the text (Example 2) and with E_T = E_N, which its printed slips fit."""
    bare, preloaded = example(4).grasp, example(4, preload=PRELOAD).grasp
    E_T, _, E_N = bare.scene.flexibility.diagonal()[:3].tolist()
    searches = tuple(
        (faces, value, search_grasp(example(4, tangential=value).grasp, faces))
        for value in (E_T, E_N)
        for faces in FACES
    )
    control = search_grasp(preloaded, PRELOAD_FACES)
    normal = np.full(3, np.nan)
    if control.z is not None:
        normal = preloaded.problem(PRELOAD_FACES).candidate(control.z).forces[:, 2]
    return NoEquilibrium(bare.solve(6, throw=False), preloaded.solve(PRELOAD_FACES), searches, control, normal)


# ----------------------------------------------------------------
# One line per equation of the paper: whether a table's printed numbers satisfy it, and how far they miss it.

# Misses that are allowed, as shares of the largest elastic displacement; the second for printed slips
_FITS, _FITS_SLIPS = 1e-4, 0.02


@dataclass(frozen=True, slots=True)
class Miss:
    """How far the printed numbers miss one equation.

    equation : the paper's name and number. amount : [N], or [m] of displacements. elastic : the largest elastic
    displacement [m], which a miss of displacements is compared with; None: the equation is about forces.
    allowed : the miss that the printed digits leave open, [N] or a share of `elastic`. forces : whether the printed
    forces alone decide it.
    """

    equation: str
    amount: float
    elastic: float | None
    allowed: float
    forces: bool
    comment: str = ""

    @property
    def share(self) -> float | None:
        """The amount as a share of the largest elastic displacement; None for forces."""
        return None if self.elastic is None else self.amount / self.elastic

    @property
    def holds(self) -> bool:
        """Whether the equation is satisfied as far as the printed digits tell."""
        return (self.amount if self.share is None else self.share) <= self.allowed

    @property
    def size(self) -> str:
        """The amount, readable: "0.254 N", "0.116 µm"."""
        if self.amount < 1e-9:
            return "0"
        return f"{short(self.amount)} N" if self.elastic is None else f"{short(self.amount * 1e6)} µm"

    @property
    def percent(self) -> str:
        """The share, such as "1.7 %"; empty for forces."""
        if self.share is None or self.amount < 1e-9:
            return ""
        return f"{100 * self.share:.0f} %" if self.share >= 0.1 else f"{100 * self.share:.2g} %"


@dataclass(frozen=True, slots=True)
class Evidence:
    """The printed forces with the signs that balance best (and overwritten ones recovered), and the misses.

    fits : the E_T [m/N] for which the printed displacement gives the printed slips; stated : the one of the example.
    """

    signed: SignedForces
    misses: tuple[Miss, ...]
    fits: float
    stated: float

    def failed(self, forces: bool) -> tuple[Miss, ...]:
        """Equations missed by the printed forces (or, False, by the printed displacements)."""
        return tuple(m for m in self.misses if not m.holds and m.forces is forces)


def evidence(table: PaperTable) -> Evidence:
    """How far a table with friction (3 to 10) misses equations (1) to (13)."""
    assert table.faces is not None
    grasp, faces = example(table.example).grasp, table.faces
    digits = sum(x.ulp for column in table.force.values() for x in column)
    length = grasp.scene.units.length

    def balance(signed: SignedForces, comment: str) -> Miss:
        return Miss("balance (1)", float(np.hypot(signed.force, signed.moment / length)), None, digits, True, comment)

    out = []
    if table.readings or table.overwritten:
        comment = "as printed" if table.readings else "as printed: slips stand in place of forces"
        out.append(balance(signed_forces(grasp, table, read=False), comment))
    signed = signed_forces(grasp, table)
    out.append(balance(signed, _reading(table, signed)))
    over = float(np.nanmax(excess(grasp, faces, signed.forces)))
    out.append(Miss("friction limit (8)", max(over, 0.0), None, digits, True, _where(over, digits)))
    E_T, _, E_N = grasp.scene.flexibility.diagonal()[:3].tolist()
    # Examples 3 to 5 come without flexibilities, and their printed slips fit E_T = E_N: both are tried
    tangentials = (E_T,) if table.example == 2 else (E_T, E_N)
    for value in tangentials:
        miss, size = compatibility(example(table.example, tangential=value).grasp, faces, signed.forces)
        comment = f"E_T = {short(value)} m/N"
        out.append(Miss("elastic compatibility (2), (5), (13)", miss, size, _FITS, True, comment))
    fit = motion(grasp, table, signed.forces, tangentials)
    scene = example(table.example, tangential=fit.tangential).grasp.scene
    elastic = abs(scene.flexibility @ signed.forces.ravel())
    size = float(elastic[np.repeat(np.array(scene.governed), 3)].max())
    slide = against_faces(grasp, faces, signed.forces, np.nan_to_num(fit.slip))
    said = "finger and object overlap" if -np.nanmin(fit.gap) > np.nanmax(fit.gap) else "a gap that carries force"
    fits = f"fits E_T = {short(fit.tangential)} m/N"
    out.append(Miss("printed slip (5), (13)", fit.slip_miss, size, _FITS_SLIPS, False, fits))
    out.append(Miss("unilateral contact (3), (4)", float(np.nanmax(abs(fit.gap))), size, _FITS, False, said))
    out.append(Miss("slip against its faces (11), (12)", slide, size, _FITS_SLIPS, False))
    return Evidence(signed, tuple(out), fit.tangential, E_T)


def _reading(table: PaperTable, signed: SignedForces) -> str:
    if signed.recovered:
        axes = sorted(AXES, key=lambda axis: COLUMN[axis])
        found = ", ".join(f"{i + 1} {axes[k]} = {x:.5g}" for i, k, x in signed.recovered)
        return f"{found} N recovered from it"
    if table.readings:
        return "misprint read as " + ", ".join(r.read for r in table.readings)
    return ""


def _where(over: float, digits: float) -> str:
    return "" if over > digits else "on a face" if over > -10 * digits else f"inside by {-over:.3g} N"
