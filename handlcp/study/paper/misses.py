"""One line per equation of the paper: whether a table's printed numbers satisfy it, and by how much they don't."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.study.paper.data import PaperTable, short
from handlcp.study.paper.examples import example
from handlcp.study.paper.printed import (
    Motion,
    SignedForces,
    against_faces,
    compatibility,
    excess,
    motion,
    signed_forces,
)

__all__ = ["Evidence", "Miss", "evidence"]

# A displacement equation holds when missed by less than this share of the largest elastic displacement
_FITS = 1e-4


@dataclass(frozen=True, slots=True)
class Miss:
    """How far the printed numbers miss one equation.

    equation : the paper's name and number. amount [unit]; share : of the largest elastic displacement, None for forces.
    holds : within what the printed digits leave open. forces : whether the printed forces alone decide it.
    """

    equation: str
    amount: float
    unit: str
    share: float | None
    holds: bool
    forces: bool
    comment: str = ""

    @property
    def size(self) -> str:
        """The amount, readable: "0.254 N", "0.116 µm"."""
        if self.amount < 1e-9:
            return "0"
        return f"{short(self.amount * 1e6)} µm" if self.unit == "m" else f"{short(self.amount)} {self.unit}"

    @property
    def percent(self) -> str:
        """The share, such as "1.7 %"; empty for forces."""
        if self.share is None or self.amount < 1e-9:
            return ""
        return f"{100 * self.share:.0f} %" if self.share >= 0.1 else f"{100 * self.share:.2g} %"


@dataclass(frozen=True, slots=True)
class Evidence:
    """The printed forces with signs that balance best (and overwritten ones recovered), and the misses.

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
    """Residuals of a table with friction (3 to 10) in equations (1) to (13)."""
    assert table.faces is not None
    grasp, faces = example(table.example).grasp, table.faces
    digits = sum(x.ulp for column in table.force.values() for x in column)
    length = grasp.scene.units.length
    out: list[Miss] = []

    def balance(signed: SignedForces, comment: str) -> None:
        miss = float(np.hypot(signed.force, signed.moment / length))
        out.append(Miss("balance (1)", miss, "N", None, miss <= digits, True, comment))

    signed = signed_forces(grasp, table)
    if table.readings or table.overwritten:
        comment = "as printed" if table.readings else "as printed: slips stand in place of forces"
        balance(signed_forces(grasp, table, read=False), comment)
    balance(signed, _reading(table, signed))
    over = float(np.nanmax(excess(grasp, faces, signed.forces)))
    out.append(Miss("friction limit (8)", max(over, 0.0), "N", None, over <= digits, True, _where(over, digits)))
    E_T = float(grasp.scene.flexibility[0, 0])
    E_N = float(grasp.scene.flexibility[2, 2])
    # Examples 3 to 5 come without flexibilities, and their printed slips fit E_T = E_N: both are tried
    tangentials = (E_T,) if table.example == 2 else (E_T, E_N)
    for value in tangentials:
        miss, size = compatibility(example(table.example, tangential=value).grasp, faces, signed.forces)
        share = miss / size
        out.append(
            Miss(
                "elastic compatibility (2), (5), (13)",
                miss,
                "m",
                share,
                share <= _FITS,
                True,
                f"E_T = {short(value)} m/N",
            )
        )
    fit = motion(grasp, table, signed.forces, tangentials)
    return Evidence(signed, (*out, *_displacements(table, signed.forces, fit)), fit.tangential, E_T)


def _displacements(table: PaperTable, forces: Array, fit: Motion) -> list[Miss]:
    assert table.faces is not None
    used = example(table.example, tangential=fit.tangential).grasp
    size = float(abs(used.scene.flexibility @ forces.ravel())[np.repeat(np.array(used.scene.governed), 3)].max())
    tangent, slide = fit.slip_miss, against_faces(used, table.faces, forces, np.nan_to_num(fit.slip))
    overlap, gap = float(np.nanmin(fit.gap)), float(np.nanmax(fit.gap))
    said = "finger and object overlap" if -overlap > gap else "a gap that carries force"
    return [
        Miss(
            "printed slip (5), (13)",
            tangent,
            "m",
            tangent / size,
            tangent / size <= 0.02,
            False,
            f"fits E_T = {short(fit.tangential)} m/N",
        ),
        Miss("unilateral contact (3), (4)", fit.worst, "m", fit.worst / size, fit.worst / size <= _FITS, False, said),
        Miss("slip against its faces (11), (12)", slide, "m", slide / size, slide / size <= 0.02, False, ""),
    ]


def _reading(table: PaperTable, signed: SignedForces) -> str:
    if signed.recovered:
        axis = {0: "o", 1: "t"}
        found = ", ".join(f"{i + 1} {axis[k]} = {x:.5g}" for i, k, x in signed.recovered)
        return f"{found} N recovered from it"
    if table.readings:
        return "misprint read as " + ", ".join(r.read for r in table.readings)
    return ""


def _where(over: float, digits: float) -> str:
    return "" if over > digits else "on a face" if over > -10 * digits else f"inside by {-over:.3g} N"
