"""One row per printed number: ours beside it, the difference, and a mark."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from handlcp.check import Array
from handlcp.grasp import GraspSolution
from handlcp.study.paper.data import AXES, COLUMN, Number, PaperTable
from handlcp.study.paper.examples import Example

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
