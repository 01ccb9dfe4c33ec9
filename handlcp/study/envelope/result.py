"""The envelope of a grasp: how much it holds in each direction, what gives out first, what compliance gives away."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp import Grasp
from handlcp.keywords import helped_methods
from handlcp.lazy import lazy
from handlcp.record import Record, data_frame, pick, versions
from handlcp.study.envelope.ask import Binds, Question
from handlcp.study.envelope.causes import Compliance, Sector, causes_of
from handlcp.study.envelope.grid import Grid
from handlcp.study.envelope.printed import printed
from handlcp.views import view

_HELD_AS = {"force": "force_N", "torque": "torque_Nm", "gravity": "mass_kg", "wrench": "factor"}
_WRENCH = ("Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm")


@dataclass(frozen=True, slots=True)
class Extreme:
    """One direction of an envelope: its number, the unit vector (3,) in world axes (zero for a wrench), the factor
    [N, N·m, kg], and what binds.
    """

    number: int
    direction: Array
    factor: float
    binds: Binds


@helped_methods
@dataclass(frozen=True, eq=False)
class Envelope(Record):
    """How much a grasp holds in each of m directions; made by `envelope`.

    factors : (m,) in `unit`, infinite where nothing gives out, 0 where the grasp does not even hold without a load,
        NaN where it is undecided: no limit was found, although friction and torque limits alone must end the load.
    binds : (m,) tuples of what gives out first, each with `kind` and `who`, as `LoadLimit.binds`; () for nothing,
        and the kind "undecided" where it is.
    accuracy : (m,) estimated relative errors of the factors; NaN where none was asked for.
    """

    question: Question
    grid: Grid
    given: Array | None
    factors: Array
    binds: tuple[Binds, ...]
    plane: Array | None
    accuracy: Array

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        read_only(self.factors)
        read_only(self.accuracy)

    @property
    def of(self) -> str:
        """What the object is loaded with: "force", "torque", "gravity", or "wrench" where wrenches were given."""
        return self.question.load.of

    @property
    def unit(self) -> str:
        """The unit of the factors: "N", "N·m", "kg"; "" for multiples of wrenches."""
        return self.question.load.unit

    @property
    def geometry(self) -> str:
        """As asked or chosen: "fixed" or "followed"."""
        return self.question.geometry

    @property
    def grasp(self) -> Grasp:
        """The one that is loaded; for gravity, without its object's weight."""
        return self.question.load.grasp

    @property
    def directions(self) -> Array:
        """(m, 3) unit vectors, world axes; those that were added where causes change come last. Zero for wrenches."""
        return self.grid.points

    @property
    def triangles(self) -> Ints:
        """(k, 3) numbers of the directions at the corners of triangles that cover the sphere, counterclockwise from
        outside; (0, 3) where the directions do not lie all around.
        """
        cells = self.grid.cells
        return cells if cells.shape[1] == 3 else np.zeros((0, 3), dtype=np.int64)

    @lazy
    def wrenches(self) -> Array:
        """(m, 6) force and torque [N, N·m] for a factor of 1, about the grasp's reference, world axes."""
        return read_only(np.array(self.question.wrenches(self.directions, self.given)))

    @lazy
    def shares(self) -> Array:
        """(m,) what part of all directions each stands for: by solid angle, or by angle in a plane. Their sum is 1."""
        return read_only(self.grid.shares)

    @lazy
    def weakest(self) -> Extreme:
        """The direction with the smallest factor that is known: its `number`, unit vector `direction` (3,), `factor`
        and `binds`.
        """
        least = int(np.argmin(np.where(np.isnan(self.factors), np.inf, self.factors)))
        left = np.flatnonzero(np.isnan(self.factors))
        return self._at(int(left[0]) if len(left) and not np.isfinite(self.factors[least]) else least)

    @lazy
    def strongest(self) -> Extreme:
        """The direction with the largest factor, as `weakest`."""
        return self._at(int(np.argmax(np.where(np.isnan(self.factors), -1.0, self.factors))))

    @property
    def causes(self) -> tuple[Sector, ...]:
        """What gives out first, the most frequent cause first. Each has `binds`, as here; `says`, in words; `share` of
        all directions; the `least` and the `median` factor there.
        """
        return self._causes[0]

    @property
    def cause(self) -> Ints:
        """(m,) number in `causes` of what gives out first in each direction."""
        return self._causes[1]

    @property
    def bound(self) -> Array:
        """The factors (m,) without compliance: as long as any forces within friction and torque limits balance the
        load, whether or not these fingers create them. Computed when it is first asked for.
        """
        return self._bound

    @property
    def compliance(self) -> Compliance:
        """What passive compliance leaves: factors as shares of `bound`, over the directions where that is finite. Their
        `median`; the `least`, and the `number` of its direction.
        """
        return Compliance.of(self.factors, self.bound, self.shares)

    @lazy
    def _causes(self) -> tuple[tuple[Sector, ...], Ints]:
        return causes_of(self.binds, self.factors, self.shares, self.grasp.spec)

    @lazy
    def _bound(self) -> Array:
        return read_only(self.question.bound(self.directions, self.given))

    def _at(self, k: int) -> Extreme:
        return Extreme(k, self.directions[k], float(self.factors[k]), self.binds[k])

    def plot(self, path: Any = None, *, title: str = "") -> Any:
        """The surface of the factors in space, coloured by what gives out first, the bound as lines around it; for
        directions in a plane, their polar diagram. A matplotlib figure, or the file that it was written to.

        path : of a png, svg, pdf or jpg file; None: the figure itself. Raises InputError for an unknown format, and for
        directions that lie neither all around nor in a plane; Unsupported without matplotlib.
        """
        return view("envelope_plot")(self, path, title)

    def polar(self, path: Any = None, *, title: str = "") -> Any:
        """Polar diagrams of the factors in the planes xy, yz and xz, or in the plane that was asked for: coloured by
        what gives out first, the bound dashed. Returns and raises as `plot`.
        """
        return view("envelope_polar")(self, path, title)

    def page(self, path: Any, *, title: str = "") -> Path:
        """A page to turn the hand on, with the surface around it: one HTML file that needs no network. Returns the
        file. Raises InputError for a file that cannot be written, or directions that do not lie all around; Unsupported
        without trimesh.
        """
        written: Path = view("envelope_page")(self, path, title)
        return written

    def to_frame(self) -> Any:
        """A pandas table with a row for each direction: x, y, z, the factor and the bound with their unit, what binds,
        and the share of all directions. Raises Unsupported without pandas.
        """
        held, wrenches = self.held_as, self.of == "wrench"
        names, ways = (_WRENCH, self.wrenches) if wrenches else ("xyz", self.directions)
        found = dict(zip(names, ways.T, strict=True)) | {held: self.factors, f"bound_{held}": self.bound}
        return data_frame(found | {"binds": [self.causes[k].says for k in self.cause], "share": self.shares})

    def to_dict(self) -> dict[str, Any]:
        """The whole envelope as plain data: SI units in the key names, None for what is infinite."""
        held, found = self.held_as, super().to_dict()
        for which in ("weakest", "strongest"):
            one: Extreme = getattr(self, which)
            told = pick(one, "number", "direction", f"{held} = factor", "binds")
            found[which] = told | {"says": self.causes[self.cause[one.number]].says}
        lines = "binds", "says", "share", f"least_{held} = least", f"median_{held} = median"
        found["causes"] = [pick(one, *lines) for one in self.causes]
        if self.of not in ("force", "gravity"):
            found["at_m"] = None
        found["share_of_bound"]["direction"] = self.directions[self.compliance.number].tolist()
        return found | {"versions": versions("numpy")}

    def _lines(self) -> tuple[str, ...]:
        held = self.held_as
        return (
            "of",
            "geometry",
            "at_m (3,) = question.load.at",
            "object_mass_kg = question.load.mass",
            "motion_m = question.motion",
            "turn_rad = question.turn",
            "accuracy_asked = question.accuracy",
            "accuracy (m,)",
            "plane (2, 3)",
            "weakest",
            "strongest",
            "causes",
            "share_of_bound.median = compliance.median",
            "share_of_bound.least = compliance.least",
            "directions (m, 3)",
            "wrenches_N_Nm (m, 6)",
            f"{held} (m,) = factors",
            f"bound_{held} (m,) = bound",
            "cause (m,)",
            "share (m,) = shares",
            "triangles (k, 3)",
        )

    @property
    def held_as(self) -> str:
        """What the factors are called in dictionaries and tables: "force_N", "torque_Nm", "mass_kg", or "factor"."""
        return _HELD_AS[self.of]

    def __str__(self) -> str:
        """What was asked, the weakest and the strongest direction, a table of what gives out first."""
        return printed(self)

    def __repr__(self) -> str:
        return f"Envelope(of={self.of!r}, {len(self.factors)} directions, weakest={self.weakest.factor:.6g})"
