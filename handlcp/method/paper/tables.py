"""The paper's tables, recomputed row by row."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from functools import cache

import numpy as np

from handlcp.check import Array
from handlcp.grasp import GraspSolution
from handlcp.method.paper.data import AXES, COLUMN, NUMBERS, PRELOAD, Example, Number, PaperTable, example, short, table
from handlcp.method.paper.misses import PRELOAD_FACES, Evidence, Miss, evidence

# ----------------------------------------------------------------
# One row per printed number: ours beside it, the difference, and a mark.

_ZERO, _NOISE, _RESIDUE = 1e-9, 1e-12, 1e-6  # shares of the table's largest force or motion
_PLANAR = {"u_x": 0, "u_y": 1, "φ": 5}  # names and numbers of the components of a motion
_SPATIAL = {"u_x": 0, "u_y": 1, "u_z": 2, "φ_x": 3, "φ_y": 4, "φ_z": 5}


class Mark(Enum):
    """How a printed number and ours compare; the value is what the report prints."""

    DIGITS = "✓"  # every printed digit
    LAST = "±1"  # to one unit of the last printed digit
    RESIDUE = "≈0"  # exactly zero, printed as the residual that the paper's stop rule permits
    LOOSE = "loose"  # the solution leaves this component free
    OTHER = "other"  # ours solves another problem (preloaded): shown, not compared
    NO = "✗"

    @property
    def fits(self) -> bool:
        """Whether the printed number is reproduced."""
        return self in (Mark.DIGITS, Mark.LAST, Mark.RESIDUE)


@dataclass(frozen=True, slots=True)
class Row:
    """A printed magnitude and ours, which has its sign. SI.

    column : "force" [N] | "slip" [m] | "fingertip" [m] | "object" [m, rad]. place : "1 n", "3 t", "u_x", …
    """

    column: str
    place: str
    printed: Number
    ours: float
    mark: Mark

    @property
    def difference(self) -> float:
        """|ours| minus printed, SI."""
        return abs(self.ours) - self.printed.value

    @property
    def relative(self) -> float:
        """The difference as a share of the printed number; NaN where that is zero."""
        return self.difference / self.printed.value if self.printed.value else float("nan")


def mark_of(printed: Number, ours: float, scale: float) -> Mark:
    """Compare magnitudes. scale : the largest force or motion, beside which a number may count as zero."""
    size, off = abs(ours), abs(abs(ours) - printed.value)
    if printed.value <= _RESIDUE * scale and size <= _ZERO * scale:
        return Mark.DIGITS if printed.value <= _NOISE * scale else Mark.RESIDUE
    if printed.value == 0.0:
        return Mark.NO
    if off <= 0.5 * printed.ulp * (1 + 1e-6):
        return Mark.DIGITS
    return Mark.LAST if off < 1.5 * printed.ulp else Mark.NO


def rows_of(table: PaperTable, example: Example, solution: GraspSolution, other: bool) -> tuple[Row, ...]:
    """All rows of a table; other : ours solves another problem, so nothing is marked right or wrong."""
    scene = example.grasp.scene
    loose_twist, loose_slip = _loose(solution, scene.positions, scene.frames)
    entries: list[tuple[str, str, Number, float, bool]] = []  # column, place, printed, ours, left free
    for finger, numbers in table.force.items():
        for axis, number in zip(AXES, numbers, strict=False):
            ours = float(solution.forces[finger - 1, COLUMN[axis]])
            entries.append(("force", f"{finger} {axis}", number, ours, False))
    for finger, numbers in table.fingertip.items():
        retreat = float(scene.flexibility[3 * finger - 1] @ solution.forces.ravel())
        entries += [("fingertip", f"{finger} n", number, retreat, False) for number in numbers]
    for finger, numbers in table.slip.items():
        for k, (axis, number) in enumerate(zip(AXES[1:], numbers, strict=True)):
            ours, loose = float(solution.slip[finger - 1, k]), bool(loose_slip[finger - 1, k])
            entries.append(("slip", f"{finger} {axis}", number, ours, loose))
    names = _PLANAR if len(table.object) == 3 else _SPATIAL
    for (name, k), number in zip(names.items(), table.object, strict=True):
        entries.append(("object", name, number, float(solution.object_displacement[k]), bool(loose_twist[k])))
    # Of a misprint, the number that it is read as is compared
    read = {("force", f"{r.finger} {r.axis}"): Number.parse(r.read) for r in table.readings}
    meant = [read.get((column, place), number) for column, place, number, _, _ in entries]
    sizes = {True: 0.0, False: 0.0}  # the largest force, and the largest motion
    for (column, _, _, ours, _), number in zip(entries, meant, strict=True):
        sizes[column == "force"] = max(sizes[column == "force"], abs(ours), number.value)
    rows = []
    for (column, place, printed, ours, loose), number in zip(entries, meant, strict=True):
        mark = Mark.OTHER if other else Mark.LOOSE if loose else mark_of(number, ours, sizes[column == "force"])
        rows.append(Row(column, place, printed, ours, mark))
    return tuple(rows)


def _loose(solution: GraspSolution, positions: Array, frames: Array) -> tuple[Array, Array]:
    """(6,) and (n, 2) bool: components of the object's displacement and of the slips that the solution leaves free."""
    directions = np.zeros((0, 6)) if solution.uniqueness is None else solution.uniqueness.directions
    points = directions[:, None, :3] + np.cross(directions[:, None, 3:], positions)
    slips = (frames.transpose(0, 2, 1) @ points[..., None])[..., :2, 0]
    size = abs(directions).max(initial=0.0)
    return (abs(directions) > 1e-6 * size).any(axis=0), (abs(slips) > 1e-6 * size).any(axis=0)


# ----------------------------------------------------------------
# Tables 1 to 10: rows, evidence, and a verdict each.

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
