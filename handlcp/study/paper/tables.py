"""Tables 1 to 10: rows, evidence, and a verdict each."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

from handlcp.grasp import GraspSolution
from handlcp.study.paper.data import NUMBERS, PaperTable, short, table
from handlcp.study.paper.examples import PRELOAD, Example, example
from handlcp.study.paper.misses import Evidence, Miss, evidence
from handlcp.study.paper.no_equilibrium import PRELOAD_FACES
from handlcp.study.paper.rows import Mark, Row, rows_of

_COLUMNS = {"force": "forces", "fingertip": "fingertip displacements", "object": "object displacement", "slip": "slips"}


@dataclass(frozen=True, slots=True)
class Comparison:
    """A table of the paper beside ours.

    table, example : what was printed, and the grasp. solution : our certified answer. rows : one per printed number.
    evidence : the printed numbers in the paper's own equations; None for the frictionless Tables 1 and 2.
    ours : the problem that our column solves, in words.
    """

    table: PaperTable
    example: Example
    solution: GraspSolution
    ours: str
    rows: tuple[Row, ...]
    evidence: Evidence | None

    @property
    def golden(self) -> bool:
        """Whether (some columns of) this table must be reproduced."""
        return bool(self.table.golden)

    @property
    def golden_rows(self) -> tuple[Row, ...]:
        """The rows that must match."""
        return tuple(r for r in self.rows if r.column in self.table.golden)

    @property
    def ok(self) -> bool:
        """Whether all golden rows match; True for tables without any."""
        return all(r.mark.fits for r in self.golden_rows)

    @property
    def level(self) -> str:
        """For a golden table "reproduced" or "failed", for another "solution" or "not a solution"."""
        if self.golden:
            return "reproduced" if self.ok else "failed"
        return "not a solution" if self.evidence is not None and self.evidence.failed(forces=True) else "solution"

    @property
    def verdict(self) -> str:
        """One sentence: whether the golden rows match, else which of the paper's equations the printed forces miss."""
        if not self.golden:
            return self._missing()
        rows = self.golden_rows
        *most, final = (_COLUMNS[c] for c in self.table.golden)
        what = f"{', '.join(most)} and {final}" if most else final
        wrong = [f"{_COLUMNS[r.column]} {r.place}" for r in rows if not r.mark.fits]
        if wrong:
            return f"NOT reproduced: {', '.join(wrong)}"
        exact, last, residue = (sum(r.mark is m for r in rows) for m in (Mark.DIGITS, Mark.LAST, Mark.RESIDUE))
        text = f"{what} reproduced to every printed digit"
        if last:
            text = f"{what} reproduced, {exact} of {len(rows)} to every printed digit, {last} to ±1 in the last one"
        if residue:
            text += f"; {residue} are exactly 0, where the paper prints what its stop rule RES < 1e-5 leaves"
        return text

    @property
    def remarks(self) -> tuple[str, ...]:
        """Further findings: misprints, what the printed displacements miss, what the solution leaves free."""
        readings = self.table.readings
        out = [f"misprint: force {r.finger} {r.axis} = {r.printed} reads {r.read} ({r.why})" for r in readings]
        e = self.evidence
        if e is None:
            return tuple(out)
        if any(r.mark is Mark.LAST for r in self.golden_rows):
            worst = short(min(m.amount for m in e.misses if m.equation.startswith("balance")))
            last = "their last digit is what the stop rule RES < 1e-5 leaves"
            out.append(f"the printed forces miss balance by {worst} N themselves: {last}")
        if self.golden and (failed := e.failed(forces=False)):
            out.append("the printed displacements do not belong to these forces: they miss " + _list(failed))
        return (*out, *self._free(), *self._other_flexibility(e))

    def _free(self) -> list[str]:
        """On directions in which the object may move without a change of forces."""
        unique = self.solution.uniqueness
        if unique is None or not unique.loose_motions or not any(r.mark is Mark.LOOSE for r in self.rows):
            return []
        n = unique.loose_motions
        text = f"the object's motion is free in {n} direction{'s' if n > 1 else ''}; ours is the smallest one"
        wrong = [r for r in self.rows if r.column in ("slip", "object") and r.mark is Mark.NO]
        if self.golden and wrong:
            fixed = ", ".join(("slip " if r.column == "slip" else "") + r.place for r in wrong)
            text += f", and all share our {fixed}: whatever the lost signs, the printed motion is none of them"
        return [text]

    def _other_flexibility(self, e: Evidence) -> list[str]:
        """On the tangential flexibility that the printed slips fit, where it is not the stated one."""
        if e.fits == e.stated:
            return []
        text = f"the printed slips fit E_T = {short(e.fits)} m/N, not the {short(e.stated)} of Example 2"
        out = [text + ("; the forces are the same for both" if self.golden else "")]
        if self.table.example == 5:  # the only example whose forces depend on E_T
            normal = example(5, tangential=e.fits).grasp.solve(self.table.faces or 8).normal_force
            numbers = ", ".join(f"{x:.6g}" for x in normal)
            out.append(f"with E_T = {short(e.fits)} m/N the certified r_N are {numbers} N, not the printed ones either")
        return out

    def _missing(self) -> str:
        assert self.evidence is not None
        failed = [m for m in self.evidence.failed(forces=True) if m.comment != "as printed"]
        if not failed:
            return "the printed forces satisfy the paper's own equations"
        return f"not a solution of the paper's own model: misses {_list(failed)}"


def _list(misses: Iterable[Miss]) -> str:
    """Each equation once: "balance (1) by 0.3 N; elastic compatibility … by 1.7 % … (9.5 % at E_T = 1.5e-06 m/N)"."""
    texts: dict[str, str] = {}
    for m in misses:
        if m.equation in texts:  # the same equation with another E_T
            texts[m.equation] += f" ({m.percent} at {m.comment})"
        elif m.percent:
            texts[m.equation] = f"{m.equation} by {m.size}, {m.percent} of the largest elastic displacement"
        else:
            texts[m.equation] = f"{m.equation} by {m.size}{f' ({m.comment})' if m.comment else ''}"
    return "; ".join(texts.values())


@cache
def compare(number: int) -> Comparison:
    """Solve the example of Table `number` (1 to 10) and lay ours beside the printed numbers."""
    t = table(number)
    e = example(t.example)
    faces = t.faces or 8
    other = t.example == 4
    if other:  # no elastic equilibrium as printed: ours is the preloaded scene
        solution = example(4, preload=PRELOAD).grasp.solve(PRELOAD_FACES)
        ours = f"with 5 µm preload on fingers 1 and 2, {PRELOAD_FACES} faces"
    else:
        solution, ours = e.grasp.solve(faces), "certified" if t.faces is None else f"certified, {faces} faces"
    return Comparison(t, e, solution, ours, rows_of(t, e, solution, other), None if t.faces is None else evidence(t))


def compare_all() -> tuple[Comparison, ...]:
    """Tables 1 to 10."""
    return tuple(compare(k) for k in NUMBERS)
