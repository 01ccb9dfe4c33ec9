"""`Envelope`: what holds along many directions, what gives out where, and what compliance gives away."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Ints, check_method_calls, read_only
from handlcp.grasp import Grasp
from handlcp.grasp.failure.failure_text import NOTHING_FAILS, describe_failures, describe_own_wrench
from handlcp.lazy_property import lazy_property
from handlcp.record import Record, make_data_frame, package_versions, pick_entries
from handlcp.studies.envelope.direction import (
    BindingCauses,
    Compliance,
    DirectionGrid,
    Sector,
    group_causes,
    weighted_median,
)
from handlcp.studies.envelope.question import FOLLOWED_GEOMETRY, EnvelopeQuestion
from handlcp.words import TextTable, wrap_text

_MAX_TABLE_ROWS = 8  # causes of a table; the rest are one row
_LOAD_NAMES = {"force": "a force", "torque": "a torque", "gravity": "gravity", "wrench": "the load"}
_AXIS_NAMES = ("x", "y", "z")


def envelope_headline(env: Any) -> str:
    """The weakest direction and what gives out there, in one sentence."""
    w, left = env.weakest, int(np.isnan(env.factors).sum())
    where = _describe_direction(env, w.number)
    if np.isnan(w.factor):
        return f"undecided {where}: no limit was found, although friction and torque limits end any load"
    if np.isinf(w.factor):
        return f"{NOTHING_FAILS}, in no direction"
    if env.strongest.factor == 0.0:
        return f"the grasp does not hold without a load: {_describe_cause(env, w)}"
    but = f" but {left} that are undecided" if left else ""
    around = " in every direction" if len(env.triangles) else ""
    scope = around if env.plane is None else " in every direction of the plane"
    held = f"the grasp holds {format_factor(env, w.factor)}{scope}{but}"
    return f"{held}; weakest {where}: {_describe_cause(env, w)}"


def describe_geometry(env: Any) -> str:
    """What stays where it is while the load grows, and what else one may ask for."""
    if env.geometry == FOLLOWED_GEOMETRY:
        return "fingers and object move under the load, and contacts are detected anew"
    return (
        'contacts stay where they are in this posture; geometry="followed" (--followed) lets fingers and object move: '
        "slower, and for soft hands the numbers can differ much"
    )


def _describe_accuracy(env: Any) -> str:
    """How near the factors are to those of finer steps, where that was asked for."""
    asked = env.question.accuracy
    if asked is None:
        return ""
    off = np.where(np.isnan(env.accuracy), np.inf, env.accuracy)
    k, m = int(off.argmax()), int((off <= asked).sum())
    few = "all" if m == len(off) else f"{m} of"
    text = f"estimated to be within {words.format_percent(asked)} in {few} {len(off)} directions"
    most = words.format_percent(float(off[k]))
    return text if m == len(off) else f"{text}; off by {most} {_describe_direction(env, k)}"


def format_factor(env: Any, factor: float) -> str:
    """A factor with its unit in words, such as "3.2 N", "0.41 kg (2.1 times the object's)", "1.3 times the wrench"."""
    if np.isnan(factor):
        return "undecided"
    if np.isinf(factor):
        return "any load"
    if env.of == "force":
        return words.format_force(factor)
    if env.of == "torque":
        return words.format_torque(factor)
    if env.of == "gravity":
        mass = env.question.load.mass
        return f"{factor:.3g} kg" + (f" ({factor / mass:.3g} times the object’s)" if mass else "")
    return f"{factor:.3g} times the wrench"


def format_direction(d: Array) -> str:
    """A unit vector (3,) in words, such as "+x" or "(0.71, 0, -0.71)"."""
    k = int(abs(d).argmax())
    if abs(d[k]) > 1.0 - 1e-9:
        return f"{'+' if d[k] > 0 else '-'}{_AXIS_NAMES[k]}"
    return "(" + ",\N{NO-BREAK SPACE}".join(f"{round(x, 2) + 0.0:g}" for x in d.tolist()) + ")"


def _describe_cause(env: Any, extreme: Any) -> str:
    return describe_failures(extreme.binds, env.grasp.spec)


def _describe_direction(env: Any, k: int) -> str:
    """Direction k of an envelope in words, such as "along +x"; of wrenches, which one."""
    return f"with wrench {k + 1}" if env.of == "wrench" else f"along {format_direction(env.directions[k])}"


def _describe_question(env: Any) -> str:
    """The question of an envelope in words: which load, in how many directions."""
    load, m = env.question.load, len(env.factors)
    what = _LOAD_NAMES[env.of]
    if env.of == "force":
        unit = words.choose_length_unit(load.at.tolist())
        what += " at (" + ", ".join(unit(x) for x in load.at.tolist()) + f") {unit.name}"
    around = "in a plane" if env.plane is not None else "all around" if len(env.triangles) else ""
    if own := describe_own_wrench(load.grasp.spec):
        what += f" {own}"
    ways = "wrenches" if env.of == "wrench" else "directions"
    return f"how much it holds: {what}, {m} {ways}{f' {around}' if around else ''}"


def describe_compliance(env: Any) -> str:
    """What passive compliance gives away, in words; "" where nothing is known of it."""
    c = env.compliance
    if np.isnan(c.median):
        return ""
    least, ways = format_factor(env, float(env.bound.min())), "wrenches" if env.of == "wrench" else "directions"
    weakest = "of the weakest wrench" if env.of == "wrench" else "in the weakest direction"
    text = f"friction and torque limits alone would allow {least} {weakest}"
    if env.geometry == FOLLOWED_GEOMETRY:  # which may end in postures that hold more
        return f"in this posture, {text}"
    if c.least > 1.0 - 1e-6:
        return f"{text}; the compliant fingers hold all that these limits allow"
    where = _describe_direction(env, c.number)
    half, least = words.format_percent(c.median), words.format_percent(c.least)
    return (
        f"{text}; the compliant fingers do not create all of these forces: in half of the {ways} they hold at most "
        f"{half} of what the limits allow there, {where} only {least}"
    )


def _cause_table(env: Any) -> TextTable:
    """A row for each cause, the most frequent first."""
    shown, rest = env.causes[:_MAX_TABLE_ROWS], env.causes[_MAX_TABLE_ROWS:]
    if len(rest) == 1:
        shown, rest = env.causes, ()
    found = [(c.says, c.share, c.least, c.median) for c in shown]
    if rest:
        least = min([c.least for c in rest], key=lambda x: (np.isnan(x), x))
        found.append((f"{len(rest)} more", sum(c.share for c in rest), least, np.nan))
    rows = []
    for says, share, *factors in found:
        texts = ["any" if np.isinf(x) else "" if np.isnan(x) else f"{x:.3g}" for x in factors]
        rows.append((says, words.format_percent(share), *texts))
    unit = f"\n{env.unit}" if env.unit else ""
    return TextTable(("what gives out first", "directions", f"least{unit}", f"median{unit}"), tuple(rows), "<>>>")


# ----------------------------------------------------------------
# The envelope of a grasp: how much it holds in each direction, what gives out first, what compliance gives away.


_FACTOR_KEYS = {"force": "force_N", "torque": "torque_Nm", "gravity": "mass_kg", "wrench": "factor"}
_WRENCH_COLUMNS = ("Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm")


@dataclass(frozen=True, slots=True)
class Extreme:
    """One direction of an envelope: its number, the unit vector (3,) in world axes (zero for a wrench), the factor
    [N, N·m, kg], and what binds.
    """

    number: int
    direction: Array
    factor: float
    binds: BindingCauses


@check_method_calls
@dataclass(frozen=True, eq=False)
class Envelope(Record):
    """How much a grasp holds in each of m directions; made by `envelope`.

    factors : (m,) in `unit`, infinite where nothing gives out, 0 where the grasp does not even hold without a load,
        NaN where it is undecided: no limit was found, although friction and torque limits alone must end the load.
    binds : (m,) tuples of what gives out first, each with `kind` and `who`, as `LoadLimit.binds`; () for nothing,
        and the kind "undecided" where it is.
    accuracy : (m,) estimated relative errors of the factors; NaN where none was asked for.
    """

    question: EnvelopeQuestion
    grid: DirectionGrid
    given: Array | None
    factors: Array
    binds: tuple[BindingCauses, ...]
    plane: Array | None
    accuracy: Array

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        read_only(self.factors)
        read_only(self.accuracy)

    @property
    def of(self) -> str:
        """What the object is loaded with: "force", "torque", "gravity", or "wrench" where wrenches were given."""
        return self.question.load.kind

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

    @lazy_property
    def wrenches(self) -> Array:
        """(m, 6) force and torque [N, N·m] for a factor of 1, about the grasp's reference, world axes."""
        return read_only(np.array(self.question.wrenches(self.directions, self.given)))

    @lazy_property
    def shares(self) -> Array:
        """(m,) what part of all directions each stands for: by solid angle, or by angle in a plane. Their sum is 1."""
        return read_only(self.grid.shares)

    @lazy_property
    def weakest(self) -> Extreme:
        """The direction with the smallest factor that is known: its `number`, unit vector `direction` (3,), `factor`
        and `binds`.
        """
        least = int(np.argmin(np.where(np.isnan(self.factors), np.inf, self.factors)))
        left = np.flatnonzero(np.isnan(self.factors))
        return self._extreme_at(int(left[0]) if len(left) and not np.isfinite(self.factors[least]) else least)

    @lazy_property
    def strongest(self) -> Extreme:
        """The direction with the largest factor, as `weakest`."""
        return self._extreme_at(int(np.argmax(np.where(np.isnan(self.factors), -1.0, self.factors))))

    @property
    def causes(self) -> tuple[Sector, ...]:
        """What gives out first, the most frequent cause first. Each has `binds`, as here; `says`, in words; `share` of
        all directions; the `least` and the `median` factor there.
        """
        return self._grouped_causes[0]

    @property
    def cause(self) -> Ints:
        """(m,) number in `causes` of what gives out first in each direction."""
        return self._grouped_causes[1]

    @lazy_property
    def bound(self) -> Array:
        """The factors (m,) without compliance: as long as any forces within friction and torque limits balance the
        load, whether or not these fingers create them. Computed when it is first asked for.
        """
        return read_only(self.question.find_bound_factors(self.directions, self.given))

    @property
    def compliance(self) -> Compliance:
        """What passive compliance leaves: factors as shares of `bound`, over the directions where that is finite. Their
        `median`; the `least`, and the `number` of its direction.
        """
        known = np.flatnonzero(np.isfinite(self.bound) & (self.bound > 0.0) & np.isfinite(self.factors))
        if not len(known):
            return Compliance(np.nan, np.nan, 0)
        kept = self.factors[known] / self.bound[known]
        least = int(kept.argmin())
        return Compliance(weighted_median(kept, self.shares[known]), float(kept[least]), int(known[least]))

    @lazy_property
    def _grouped_causes(self) -> tuple[tuple[Sector, ...], Ints]:
        return group_causes(self.binds, self.factors, self.shares, self.grasp.spec)

    def _extreme_at(self, k: int) -> Extreme:
        return Extreme(k, self.directions[k], float(self.factors[k]), self.binds[k])

    def plot(self, path: Any = None, *, title: str = "") -> Any:
        """The surface of the factors in space, coloured by what gives out first, the bound as lines around it; for
        directions in a plane, their polar diagram. A matplotlib figure, or the file that it was written to.

        path : of a png, svg, pdf or jpg file; None: the figure itself. Raises InputError for an unknown format, and for
        directions that lie neither all around nor in a plane; Unsupported without matplotlib.
        """
        from handlcp.viz import draw_envelope, draw_or_save  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_envelope, self, title)

    def polar(self, path: Any = None, *, title: str = "") -> Any:
        """Polar diagrams of the factors in the planes xy, yz and xz, or in the plane that was asked for: coloured by
        what gives out first, the bound dashed. Returns and raises as `plot`.
        """
        from handlcp.viz import draw_or_save, draw_polar_envelope  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_polar_envelope, self, title)

    def page(self, path: Any, *, title: str = "") -> Path:
        """A page to turn the hand on, with the surface around it: one HTML file that needs no network. Returns the
        file. Raises InputError for a file that cannot be written, or directions that do not lie all around; Unsupported
        without trimesh.
        """
        from handlcp.viz import write_envelope_page  # answers pay for no page that nobody writes

        return write_envelope_page(self, path, title)

    def to_frame(self) -> Any:
        """A pandas table with a row for each direction: x, y, z, the factor and the bound with their unit, what binds,
        and the share of all directions. Raises Unsupported without pandas.
        """
        held, wrenches = self.held_as, self.of == "wrench"
        names, ways = (_WRENCH_COLUMNS, self.wrenches) if wrenches else ("xyz", self.directions)
        found = dict(zip(names, ways.T, strict=True)) | {held: self.factors, f"bound_{held}": self.bound}
        return make_data_frame(found | {"binds": [self.causes[k].says for k in self.cause], "share": self.shares})

    def to_dict(self) -> dict[str, Any]:
        """The whole envelope as plain data: SI units in the key names, None for what is infinite."""
        held, found = self.held_as, super().to_dict()
        for which in ("weakest", "strongest"):
            one: Extreme = getattr(self, which)
            told = pick_entries(one, "number", "direction", f"{held} = factor", "binds")
            found[which] = told | {"says": self.causes[self.cause[one.number]].says}
        lines = "binds", "says", "share", f"least_{held} = least", f"median_{held} = median"
        found["causes"] = [pick_entries(one, *lines) for one in self.causes]
        if self.of not in ("force", "gravity"):
            found["at_m"] = None
        found["share_of_bound"]["direction"] = self.directions[self.compliance.number].tolist()
        return found | {"versions": package_versions("numpy")}

    def _entry_lines(self) -> tuple[str, ...]:
        held = self.held_as
        return (
            "of", "geometry", "at_m (3,) = question.load.at", "object_mass_kg = question.load.mass",
            "motion_m = question.motion", "turn_rad = question.turn", "accuracy_asked = question.accuracy",
            "accuracy (m,)", "plane (2, 3)", "weakest", "strongest", "causes",
            "share_of_bound.median = compliance.median", "share_of_bound.least = compliance.least",
            "directions (m, 3)", "wrenches_N_Nm (m, 6)", f"{held} (m,) = factors", f"bound_{held} (m,) = bound",
            "cause (m,)", "share (m,) = shares", "triangles (k, 3)",
        )  # fmt: skip

    @property
    def held_as(self) -> str:
        """What the factors are called in dictionaries and tables: "force_N", "torque_Nm", "mass_kg", or "factor"."""
        return _FACTOR_KEYS[self.of]

    def __str__(self) -> str:
        """What was asked, the weakest and the strongest direction, a table of what gives out first."""
        w, s = self.weakest, self.strongest
        if s.factor == 0.0:
            return "\n".join([wrap_text(text, "  ") for text in (_describe_question(self), envelope_headline(self))])
        ways = [
            f"{how}: {format_factor(self, one.factor)} {_describe_direction(self, one.number)}: "
            f"{_describe_cause(self, one)}"
            for how, one in (("weakest", w), ("strongest", s))
        ]
        told = [_describe_question(self), *ways, describe_compliance(self), describe_geometry(self)]
        lines = [wrap_text(line, "  ") for line in (*told, _describe_accuracy(self)) if line]
        return "\n".join([*lines, "", str(_cause_table(self))])

    def __repr__(self) -> str:
        return f"Envelope(of={self.of!r}, {len(self.factors)} directions, weakest={self.weakest.factor:.6g})"
