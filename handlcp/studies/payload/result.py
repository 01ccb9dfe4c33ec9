"""`Payload`: the largest mass that a grasp holds, in which direction of gravity, and what gives out there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, check_method_calls
from handlcp.grasp import LoadLimit
from handlcp.grasp.failure.failure_mode import UNDECIDED, FailureMode
from handlcp.grasp.failure.failure_text import describe_failures, describe_own_wrench
from handlcp.record import Record
from handlcp.studies.envelope.question import DirectionalLoad
from handlcp.studies.envelope.result import describe_geometry, format_direction
from handlcp.words import TextTable, wrap_text

_MAX_CAUSE_LETTERS = 40  # letters of a cause
_DESIGN_NOTE = "first slip is what to design for in repeated use; mass is what is held once"
_IMMEDIATE_SLIP_SHARE = 1e-3  # of the mass that is held, or of 1 kg: with less a finger slides at once


@dataclass(frozen=True, eq=False)
class Orientation(Record):
    """The largest mass [kg] with gravity in one direction, seen from the hand.

    direction (3,) : of gravity, world axes, which are those of the hand's base. mass : [kg], infinite where nothing
    gives out, 0 where the grasp does not hold without an object, NaN where it is undecided; held, and may not be the
    largest, where `undecided` is true. binds : what gives out
    first, each with `kind` and `who`; () for nothing. says : the same in words. acceleration (3,) : of the hand [m/s²],
    the way with the least mass; zero at rest. limit : of a load of 1 kg, with forces at the limit (`at_limit`), path
    and picture.
    """

    entries = (
        "direction (3,)", "mass_kg", "binds", "says", "acceleration_m_per_s2 (3,)", "first_slip_kg", "slides_kg",
        "lost_kg",
    )  # fmt: skip

    direction: Array
    mass: float
    binds: tuple[FailureMode, ...]
    says: str
    acceleration: Array
    limit: LoadLimit

    @property
    def undecided(self) -> bool:
        """Whether more than this mass was not followed to an end."""
        return any(cause.kind == UNDECIDED for cause in self.binds)

    @property
    def most(self) -> str:
        """The mass in words, without its unit, such as "0.328", "any", "≥ 0.1" where more is undecided."""
        return f"≥ {_format_number(self.mass)}" if self.undecided and self.mass > 0.0 else _format_number(self.mass)

    @property
    def first_slip(self) -> float | None:
        """The mass [kg] with which a finger begins to slide; None: none does."""
        return self.limit.first_slip

    @property
    def slides(self) -> float | None:
        """The mass [kg] with which a contact has slid as far as it may; None: none does."""
        return self.limit.slides

    @property
    def lost(self) -> float | None:
        """The mass [kg] beyond which no state at rest follows; None: there is one, or a joint's limit comes before."""
        return self.limit.lost


def mass_order(row: Orientation) -> float:
    """The least mass first; what is undecided after all masses, and before what nothing limits."""
    return float(np.nan_to_num(row.mass, nan=np.finfo(float).max, posinf=np.inf))


@check_method_calls
@dataclass(frozen=True, eq=False)
class Payload(Record):
    """The largest mass that a grasp holds in several directions of gravity; made by `Grasp.payload`.

    by_orientation : a row for each direction of gravity, along the axes of the hand's base first; where "any" was
    asked for, the worst direction that was found comes last. orientations : as asked, 6 or "any". acceleration : as
    asked [m/s²]. geometry : "fixed" or "followed", of the rows. load : of a mass of 1 kg. tried : how many directions
    were tried. searched : the geometry in which the worst direction was looked for.
    """

    entries = (
        "mass_kg", "binds", "says", "direction (3,)", "orientations", "acceleration_m_per_s2", "geometry",
        "object_mass_kg", "at_m (3,)", "tried", "searched", "warnings", "by_orientation",
    )  # fmt: skip

    by_orientation: tuple[Orientation, ...]
    orientations: int | str
    acceleration: float
    geometry: str
    load: DirectionalLoad
    tried: int
    searched: str

    @property
    def worst(self) -> Orientation:
        """The row with the least mass."""
        return min(self.by_orientation, key=mass_order)

    @property
    def mass(self) -> float:
        """The least of all rows [kg]: what is held in each of these directions. Infinite where nothing gives out."""
        return self.worst.mass

    @property
    def binds(self) -> tuple[FailureMode, ...]:
        """What gives out first with that mass; `says` has it in words."""
        return self.worst.binds

    @property
    def says(self) -> str:
        """What gives out first with that mass, in words."""
        return self.worst.says

    @property
    def direction(self) -> Array:
        """(3,) of gravity with that mass, axes of the hand's base."""
        return self.worst.direction

    @property
    def at(self) -> Array:
        """(3,) where the mass is [m]: the object's centre of mass, or the grasp's reference without an object."""
        return self.load.at

    @property
    def object_mass(self) -> float:
        """Of the object as it is [kg], which is left out; 0 where it has none."""
        return self.load.mass

    @property
    def headline(self) -> str:
        """The mass, in which direction of gravity it is least, and what gives out, in one sentence."""
        row, where = self.worst, f"gravity along {format_direction(self.worst.direction)}"
        if np.isnan(row.mass):
            return f"undecided with {where}: no limit was found, although friction and torque limits end any load"
        if np.isinf(row.mass):
            return "any mass is held: nothing gives out"
        if row.undecided:
            most = f"at least {format_mass(row.mass)}, undecided beyond" if row.mass > 0.0 else "undecided"
            return f"{most}, with {where}: {row.limit.why}"
        if row.mass == 0.0:
            return f"no mass is held with {where}: {row.says}"
        times = f", {row.mass / self.object_mass:.3g} times the object’s" if self.object_mass else ""
        return f"{format_mass(row.mass)}{times}; least with {where}{self.moving(row)}, where {row.says}"

    @property
    def asked(self) -> str:
        """In words, what was asked."""
        rest = f"the hand accelerating by {self.acceleration:g} m/s²" if self.acceleration else "the hand at rest"
        if own := describe_own_wrench(self.load.grasp.spec):
            rest += f", {own}"
        axes = len(self.by_orientation) - (self.orientations == "any")
        if self.orientations == "any" and self.searched == self.geometry:
            return f"gravity in any direction, {rest}: the least of {self.tried} directions that were tried, no proof"
        if self.orientations == "any":
            return (
                f"gravity in any direction, {rest}: the axes, and the worst of {self.tried} directions that were tried "
                "with contacts that stay where they are in this posture, which is quicker; no proof"
            )
        return f"gravity both ways along the axes of the hand's base ({axes} directions), {rest}"

    @property
    def warnings(self) -> tuple[str, ...]:
        """In words, the links that the object begins inside, before the hand closes."""
        spec = self.load.grasp.spec
        reasons = [] if spec.mechanism is None else spec.mechanism.report.start_inside_reasons(spec)
        return tuple([r.sentence for r in reasons])

    def moving(self, row: Orientation) -> str:
        """In words, how the hand accelerates in a row; "" at rest."""
        return f" and the hand speeding up along {_format_acceleration(row)}" if row.acceleration.any() else ""

    def cause(self, row: Orientation, letters: int) -> str:
        """What gives out first in a row, in words; in short where these have more letters."""
        return row.says if len(row.says) <= letters else describe_failures(row.binds, self.load.grasp.spec, brief=True)

    def plot(self, path: Any = None, *, title: str = "") -> Any:
        """A bar for each direction of gravity: the mass, coloured by what gives out first. A matplotlib figure, or the
        file that it was written to.

        path : of a png, svg, pdf or jpg file; None: the figure itself. Raises InputError for an unknown format;
        Unsupported without matplotlib.
        """
        from handlcp.viz import draw_or_save, draw_payload  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_payload, self, title)

    def __str__(self) -> str:
        """The mass, what was asked, warnings, a table of the directions, for which number to design, and doubts."""
        warnings = [f"Warning: {text}." for text in self.warnings]
        told = (f"payload: {self.headline}", self.asked, describe_geometry(self), *warnings)
        lines = [wrap_text(text, "  ") for text in told]
        doubts = [
            wrap_text(f"{format_direction(row.direction)} is undecided beyond: {row.limit.undecided}", "  ")
            for row in self.by_orientation
            if row.undecided and row.limit.undecided
        ]
        which = [_DESIGN_NOTE] if any(_format_first_slip(row) for row in self.by_orientation) else []
        return "\n".join([*lines, "", str(self._table()), *which, *([""] if doubts else []), *doubts])

    def __repr__(self) -> str:
        return f"Payload(mass={self.mass:.6g}, binds={words.list_names([f'{b.kind}: {b.who}' for b in self.binds])})"

    def _table(self) -> TextTable:
        """A row for each direction."""
        heads = ["gravity: what gives out first", "first slip\nkg", "mass\nkg"]
        rows = []
        for row in self.by_orientation:
            what = f"{format_direction(row.direction)}: {self.cause(row, _MAX_CAUSE_LETTERS)}"
            rows.append([what, _format_first_slip(row), row.most])
            if self.acceleration:
                rows[-1].insert(1, _format_acceleration(row))
        if self.acceleration:
            heads.insert(1, "hand speeds\nup along")
        return TextTable(tuple(heads), tuple(map(tuple, rows)), "<<>>" if self.acceleration else "<>>")


def _format_first_slip(row: Orientation) -> str:
    """The mass with which a finger begins to slide, in words; "at once" where one slides as soon as there is any."""
    if row.first_slip is None or not row.mass > 0.0:
        return ""
    least = _IMMEDIATE_SLIP_SHARE * (row.mass if row.mass < np.inf else 1.0)
    return "at once" if row.first_slip < least else f"{row.first_slip:.3g}"


def _format_acceleration(row: Orientation) -> str:
    """The way that the hand accelerates, such as "+x"."""
    return format_direction(row.acceleration / np.linalg.norm(row.acceleration))


def format_mass(mass: float) -> str:
    """A mass with its unit in words, such as "0.328 kg"."""
    return f"{_format_number(mass)} kg"


def _format_number(mass: float) -> str:
    return "any" if np.isinf(mass) else "?" if np.isnan(mass) else f"{mass:.3g}"
