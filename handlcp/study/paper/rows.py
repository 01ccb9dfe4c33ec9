"""One row per printed number: ours beside it, the difference, and a mark."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from handlcp.check import Array
from handlcp.grasp import GraspSolution
from handlcp.study.paper.data import AXES, Number, PaperTable
from handlcp.study.paper.examples import Example

__all__ = ["Mark", "Row", "mark_of", "rows_of"]

_ZERO, _NOISE, _RESIDUE = 1e-9, 1e-12, 1e-6  # shares of the table's largest force or motion
_OURS = {"n": 2, "o": 0, "t": 1}
_PLANAR = (("u_x", 0), ("u_y", 1), ("φ", 5))
_SPATIAL = tuple((name, k) for k, name in enumerate(("u_x", "u_y", "u_z", "φ_x", "φ_y", "φ_z")))


class Mark(Enum):
    """How a printed number and ours compare; the value is what the report prints."""

    DIGITS = "✓"  # every printed digit
    LAST = "±1"  # to one unit of the last printed digit
    RESIDUE = "≈0"  # exactly zero, printed as what the paper's stop rule leaves
    LOOSE = "loose"  # the solution leaves this component free
    OTHER = "other"  # ours solves another problem (preloaded): shown, not compared
    NO = "✗"

    @property
    def fits(self) -> bool:
        """Whether the printed number is reproduced."""
        return self in (Mark.DIGITS, Mark.LAST, Mark.RESIDUE)


@dataclass(frozen=True, slots=True)
class Row:
    """A printed magnitude and ours.

    column : "force" [N] | "slip" [m] | "fingertip" [m] | "object" [m, rad]. place : "1 n", "3 t", "u_x", …
    ours : with its sign, SI. difference : |ours| - printed; relative : of the printed number, NaN where that is zero.
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
        """The difference as a share of the printed number."""
        return self.difference / self.printed.value if self.printed.value else float("nan")


def mark_of(printed: Number, ours: float, scale: float) -> Mark:
    """Compare magnitudes; scale : the largest number of its kind (forces, or motions), which says what zero is."""
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
    read = {(r.finger, r.axis): Number.parse(r.read) for r in table.readings}
    entries: list[tuple[str, str, Number, Number, float, bool]] = []
    loose_twist, loose_slip = _loose(solution, scene.positions, scene.frames)
    for finger, numbers in table.force.items():
        for axis, number in zip(AXES, numbers, strict=False):
            ours = float(solution.forces[finger - 1, _OURS[axis]])
            entries.append(("force", f"{finger} {axis}", number, read.get((finger, axis), number), ours, False))
    for finger, numbers in table.fingertip.items():
        retreat = scene.flexibility[3 * finger - 1] @ solution.forces.ravel()
        entries += [("fingertip", f"{finger} n", x, x, float(retreat), False) for x in numbers]
    for finger, numbers in table.slip.items():
        for k, (axis, number) in enumerate(zip(AXES[1:], numbers, strict=True)):
            loose = bool(loose_slip[finger - 1, k])
            entries.append(("slip", f"{finger} {axis}", number, number, float(solution.slip[finger - 1, k]), loose))
    for (name, k), number in zip(_PLANAR if len(table.object) == 3 else _SPATIAL, table.object, strict=True):
        entries.append(("object", name, number, number, float(solution.object_displacement[k]), bool(loose_twist[k])))
    # One scale for forces, one for everything that moves
    scales = {f: max(max(abs(e[4]), e[3].value) for e in entries if (e[0] == "force") is f) for f in (True, False)}
    rows = []
    for column, place, number, meant, ours, loose in entries:
        mark = Mark.OTHER if other else Mark.LOOSE if loose else mark_of(meant, ours, scales[column == "force"])
        rows.append(Row(column, place, number, ours, mark))
    return tuple(rows)


def _loose(solution: GraspSolution, positions: Array, frames: Array) -> tuple[Array, Array]:
    """(6,) and (n, 2) bool: components of the object's displacement and of the slips that the solution leaves free."""
    directions = np.zeros((0, 6)) if solution.uniqueness is None else solution.uniqueness.directions
    points = directions[:, None, :3] + np.cross(directions[:, None, 3:], positions)
    slips = (frames.transpose(0, 2, 1) @ points[..., None])[..., :2, 0]
    size = abs(directions).max(initial=0.0)
    return (abs(directions) > 1e-6 * size).any(axis=0), (abs(slips) > 1e-6 * size).any(axis=0)
