"""`AccuracyCost`: the result of a study of accuracy and cost: plain numbers, written as JSON or CSV and read back."""

from __future__ import annotations

import csv
import io
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.check import check_method_calls, check_number
from handlcp.errors import InputError
from handlcp.record import Record, columns_from_rows, make_data_frame
from handlcp.studies.accuracy.methods import ROUNDING, microseconds, share
from handlcp.words import wrap_text
from handlcp.write_file import write_file

CERTIFIED, LOOSE, SPENT, FAILED = "certified", "loose", "budget spent", "not converged"
OTHER, NOT_RUN = "another equilibrium", "not run: budget"

_DISTINCT = 0.9  # times that differ by less than a tenth count as equal: they are no more certain than that


@dataclass(frozen=True, slots=True)
class Row:
    """One method with one setting. None: there is no such number.

    section : "inscribed" or "circumscribed" pyramid of `faces`, or "exact" (cone, planar scene, no friction: None).
    tolerance : at which the method stops, in its own measure; None where it has none.
    status : "certified" (the certifier's, for the row's own section), "loose" (the method met its tolerance, the
        certifier refuses the answer), "budget spent", "not converged", "not run: budget"; of `grasp.solve()` also "not
        holdable", "no equilibrium", "undecided"; "another equilibrium": Newton's method leads from the answer to an
        equilibrium that is not the reference, so that the errors compare two different things.
    unknowns : of the problem that the method gets. seconds : median; low, high: quartiles; runs : how many.
    iterations : of the method's own kind. residual : the certifier's worst, relative.
    force_error : max |f_i - f*_i| over max |f*_i|. slip_error : max |s_i - s*_i| over the scene's motion scale.
    torque_error : max |τ - τ*| over max |τ*|; None without a hand. All against the exact cone. outcome : the method's
        own words.
    """

    method: str
    section: str
    faces: int | None
    tolerance: float | None
    status: str
    unknowns: int | None = None
    seconds: float | None = None
    seconds_low: float | None = None
    seconds_high: float | None = None
    runs: int = 0
    iterations: int | None = None
    residual: float | None = None
    force_error: float | None = None
    slip_error: float | None = None
    torque_error: float | None = None
    outcome: str = ""

    @property
    def comparable(self) -> bool:
        """Whether there are a time and a force error, and the equilibrium is that of the reference."""
        return self.seconds is not None and self.force_error is not None and self.status != OTHER

    @property
    def cost(self) -> tuple[float, float]:
        """(time, force error); infinite where there is none."""
        time, error = self.seconds, self.force_error
        return np.inf if time is None else time, np.inf if error is None else error


@dataclass(frozen=True, slots=True)
class LeftOut:
    """The scene without one effect, solved exactly.

    effect, instead : what was left out, and what was put in its place. status : "certified", "forces not determined"
    (the smallest are taken), or why there is no answer ("not holdable", "no equilibrium", "undecided").
    force_error, slip_error, torque_error : as in `Row`.
    """

    effect: str
    instead: str
    status: str
    force_error: float | None = None
    slip_error: float | None = None
    torque_error: float | None = None


@dataclass(frozen=True, slots=True)
class Reference:
    """The certified equilibrium on the exact cone that errors are measured against.

    forces (n, 3) N and slip (n, 2) m, contact axes; torques (nv,) N·m, None without a hand; motion_scale [m] of slips.
    """

    names: tuple[str, ...]
    forces: tuple[tuple[float, ...], ...]
    slip: tuple[tuple[float, ...], ...]
    torques: tuple[float, ...] | None
    motion_scale: float
    residual: float
    forces_determined: bool


@dataclass(frozen=True, slots=True)
class Conditions:
    """Where and how times were taken. budget, seconds : the time that the study was given, and took [s]."""

    handlcp: str
    python: str
    machine: str
    processors: int
    date: str
    repeats: int
    seed: int
    budget: float
    seconds: float


@dataclass(frozen=True, slots=True)
class FaceLaw:
    """force error ≈ factor · m^-exponent, least squares over the pyramids of `faces` in logarithms."""

    section: str
    exponent: float
    factor: float
    faces: tuple[int, ...]


@check_method_calls
@dataclass(frozen=True)
class AccuracyCost(Record):
    """What accuracy costs in one scene; made by `accuracy_cost`.

    rows : one for each setting. left_out : one for each effect. notes : caveats about the errors.
    """

    entries = ("summary", "reference", "rows", "left_out", "conditions", "notes", "face_laws")

    reference: Reference
    rows: tuple[Row, ...]
    left_out: tuple[LeftOut, ...]
    conditions: Conditions
    notes: tuple[str, ...] = ()

    @property
    def methods(self) -> tuple[str, ...]:
        """The methods that have rows, in their order."""
        return tuple(dict.fromkeys(r.method for r in self.rows))

    def of(self, method: str) -> tuple[Row, ...]:
        """The rows of one method."""
        return tuple(r for r in self.rows if r.method == method)

    def front(self, method: str) -> tuple[Row, ...]:
        """The method's best settings, fastest first: no other is as fast (to a tenth) and nearer to the exact one."""
        out: list[Row] = []
        rows = [r for r in self.of(method) if r.comparable]
        for r in sorted(rows, key=lambda r: (r.cost[1] if r.cost[1] > ROUNDING else 0.0, r.cost[0])):
            if not out or r.cost[0] < _DISTINCT * out[-1].cost[0]:
                out.append(r)
        return tuple(reversed(out))

    def cheapest(self, error: float, method: str | None = None) -> Row | None:
        """The fastest setting whose force error is at most `error`, of one method or of all; None: there is none."""
        error = check_number("error", error, minimum=0.0, finite=False)
        met = [r for r in self.rows if r.comparable and method in (None, r.method) and r.cost[1] <= error]
        return min(met, key=lambda r: r.cost, default=None)

    def pyramids(self, section: str = "inscribed") -> tuple[tuple[int, float], ...]:
        """(faces, force error) of exactly solved pyramids, by faces."""
        found: dict[int, float] = {}
        for r in self.rows:
            if r.section == section and r.faces and r.status == CERTIFIED and r.force_error is not None:
                found.setdefault(r.faces, r.force_error)
        return tuple(sorted(found.items()))

    def law(self, section: str = "inscribed") -> FaceLaw | None:
        """How the error falls with the faces; None for undetermined forces, or fewer than three errors to fit."""
        points = [(m, e) for m, e in self.pyramids(section) if e > ROUNDING]
        if len(points) < 3 or not self.reference.forces_determined:
            return None
        m, e = np.array(points).T
        slope, height = np.polyfit(np.log(m), np.log(e), 1)
        return FaceLaw(section, float(-slope), float(np.exp(height)), tuple(int(x) for x in m))

    @property
    def face_laws(self) -> tuple[FaceLaw, ...]:
        """Those that there are, of pyramids inside the cone and around it."""
        return tuple([law for law in map(self.law, ("inscribed", "circumscribed")) if law is not None])

    def __str__(self) -> str:
        return wrap_text(self.summary)

    @property
    def summary(self) -> str:
        """One sentence about what 8 faces cost, or the number nearest to it, and what the cone costs."""
        if not any(any(f) for f in self.reference.forces):
            return "no finger pushes here: there is no relative force error"
        solved = [r for r in self.rows if r.status == CERTIFIED and r.comparable]
        flat, exact = ([r for r in solved if r.section == section] for section in ("inscribed", "exact"))
        parts = []
        if flat:
            faces = min((r.faces or 0 for r in flat), key=lambda m: (abs(m - 8), m))
            parts.append(f"{faces} faces: {_price([r for r in flat if r.faces == faces], 'no force error')}")
        if exact:
            kind = "the cone" if any(r.section != "exact" for r in self.rows) else "no pyramids here"
            parts.append(f"{kind}: {_price(exact, 'exact')}")
        return "; ".join(parts) or "nothing was certified within the budget"

    def to_frame(self) -> Any:
        """A pandas table of `rows`, one line for each; NaN or None where there is no number. Raises Unsupported without
        pandas.
        """
        return make_data_frame(columns_from_rows(self.rows, *(f.name for f in fields(Row))))

    @classmethod
    def from_json(cls, text: str) -> AccuracyCost:
        """Read what `to_json` wrote. Raises InputError for anything else."""
        from pydantic import TypeAdapter, ValidationError

        try:
            return TypeAdapter(cls).validate_json(text)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(map(str, first["loc"])) or "text"
            raise InputError("text", "JSON that AccuracyCost.to_json wrote", f"{where}: {first['msg']}") from None

    def to_csv(self, path: Any) -> Path:
        """Write `rows` under a heading; an empty cell is None. Raises InputError for a file that cannot be written."""
        out = io.StringIO(newline="")
        writer = csv.DictWriter(out, [f.name for f in fields(Row)])
        writer.writeheader()
        writer.writerows(asdict(r) for r in self.rows)
        return write_file("csv", path, out.getvalue())


def _price(rows: list[Row], none: str) -> str:
    """Error, time and method of the fastest row. none : words for an error below rounding."""
    best = min(rows, key=lambda r: r.cost)
    time, error = best.cost
    return f"{none if error < ROUNDING else f'{share(error)} force error'} in {microseconds(time)} ({best.method})"
