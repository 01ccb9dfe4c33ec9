"""`GraspSolution`: one solve's certified answer, with `held` (its status) and `verdict` (a word and its reasons)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from handlcp import words
from handlcp.check import Array, check_method_calls, freeze_arrays, read_only
from handlcp.contact.friction import Pyramid, Section
from handlcp.errors import InputError
from handlcp.grasp.effects.joint_offset import describe_missing_squeeze
from handlcp.grasp.failure.reason import describe_large_motion
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.status import contact_statuses
from handlcp.grasp.verify.certifier import Residuals
from handlcp.lcp.problem import Status
from handlcp.record import Record, columns_from_arrays, make_data_frame
from handlcp.tolerances import CERTIFY_TOLERANCE
from handlcp.words import TextTable, wrap_text

if TYPE_CHECKING:
    from handlcp.grasp.derivatives.sensitivity import Sensitivity
    from handlcp.grasp.solution.force_bounds import ForceBounds
    from handlcp.grasp.solution.uniqueness import Uniqueness
    from handlcp.grasp.solution.verdict import Verdict

# ----------------------------------------------------------------
# What an answer looks like: a picture, plain data. Made by `handlcp.viz`, which stands above this room.


def contact_data(s: Any) -> dict[str, Any]:
    """Columns of a table with a row for each contact."""
    found = columns_from_arrays(s, "state = contact_state", "normal_N = normal_force") | {
        "friction_N": np.hypot(*s.tangential_force.T),
        "friction_used": s.friction_used,
        "friction_margin_N": s.friction_margin,
        "slip_m": np.hypot(*s.slip.T),
        "gap_m": s.gap,
    }
    for which, forces in (("", s.forces), ("world_", s.forces_world)):
        found |= {f"{which}{axis}_N": forces[:, k] for k, axis in enumerate("xyz")}
    if s.torsion is not None:
        found |= columns_from_arrays(s, "moment_Nm = torsion", "spin_rad")
    return found


# ----------------------------------------------------------------
# A solution as text: the verdict, then a table of the contacts, then what the object does. In 80 columns.


def format_solution(s: Any, tables: Sequence[Any]) -> str:
    """Of a `GraspSolution`, which imports this file; tables : what else stands under the contacts, with `str`."""
    if not s.held:
        return str(s.verdict)
    parts = [str(s.verdict), str(contact_text_table(s)), *(str(t) for t in tables)]
    free = s.uniqueness or "what is left free was not examined"
    u = np.where(abs(s.object_displacement) > CERTIFY_TOLERANCE * s.residuals.motion_scale, s.object_displacement, 0.0)
    unit = words.choose_length_unit(u[:3].tolist())
    moves, turns = ", ".join(unit(x) for x in u[:3].tolist()), ", ".join(_format_degrees(u[3:]))
    moved = f"Object: moves ({moves}) {unit.name}, turns ({turns})°."  # along and about the world's axes
    told = [wrap_text(moved, "  "), wrap_text(f"Certified: {free}.", "  ")]
    if s.accuracy is not None:
        told.append(wrap_text(f"Accuracy: {s.accuracy}.", "  "))
    return "\n\n".join([*parts, "\n".join(told)])


def contact_text_table(s: Any) -> TextTable:
    """Finger by finger, then the environment's contacts: state, forces, share of the friction limit, slip and gap."""
    least = CERTIFY_TOLERANCE * s.residuals.motion_scale
    slips, gaps = (np.where(abs(a) > least, a, 0.0) for a in (np.hypot(*s.slip.T), s.gap))
    unit, moments = words.choose_length_unit([*slips.tolist(), *gaps.tolist()]), s.torsion
    who = "finger" if s.spec is None else s.spec.who
    heads, columns = [who, "state"], [list(s.names), list(s.contact_state)]
    noise = CERTIFY_TOLERANCE * s.residuals.force_scale
    normal, friction = (np.where(abs(a) > noise, a, 0.0) for a in (s.normal_force, np.hypot(*s.tangential_force.T)))
    name, size = words.choose_prefix("N", [*normal.tolist(), *friction.tolist()])
    heads += [f"normal\n{name}", f"friction\n{name}"]
    columns += [words.format_column((a / size).tolist()) for a in (normal, friction)]
    if moments is not None:
        name, size = words.choose_prefix("N·m", (moments / 10.0).tolist())  # half a newton-metre is 500 mN·m
        heads.append(f"moment\n{name}")
        columns.append(words.format_column((moments / size).tolist()))
    heads += ["of limit", f"slip\n{unit.name}", f"gap\n{unit.name}"]
    columns += [[words.format_percent(x) for x in s.friction_used.tolist()]]
    columns += [[unit(x) for x in a.tolist()] for a in (slips, gaps)]
    return TextTable(tuple(heads), tuple(zip(*columns, strict=True)), "<<" + ">" * (len(heads) - 2))


def _format_degrees(turn: Array) -> list[str]:
    """Each with three digits of the largest; a bare 0 for what is nothing beside it."""
    angles = np.degrees(turn)
    largest = float(abs(angles).max(initial=0.0))
    if largest < 1e-4:
        return ["0"] * len(angles)
    decimals = max(0, 2 - int(np.floor(np.log10(largest))))
    return [f"{round(x, decimals) + 0.0:.{decimals}f}" if abs(x) > 1e-4 * largest else "0" for x in angles.tolist()]


# ----------------------------------------------------------------
# What `solve(accuracy=...)` was asked for, and what it reached.


@dataclass(frozen=True, slots=True)
class Accuracy(Record):
    """Force errors are relative to the largest contact force.

    asked : the error that was asked for. error : the estimate of the error reached, against the equilibrium on the
        exact cone: largest |f_i - f*_i| over the largest |f*_i|. NaN where none is known, and so without an answer.
    setting : what was taken, such as "exact cone". solves : how many problems that took. seconds : how long, estimate
        included.
    """

    entries = ("asked", "error", "met", "setting", "solves", "seconds")

    asked: float
    error: float
    setting: str
    solves: int
    seconds: float

    @property
    def met(self) -> bool:
        """Whether the estimate keeps what was asked for; never without one."""
        return self.error <= self.asked

    def __str__(self) -> str:
        several = "s" if self.solves > 1 else ""
        cost = f"{self.solves} solve{several}, {self.seconds * 1e3:.3g} ms"
        error = "below 1e-9" if self.error < 1e-9 else f"{self.error:.1e}"
        return f"force error {error}, {self.asked:.1e} asked: {self.setting}, {cost}"


# ----------------------------------------------------------------
# Frozen dataclasses whose fields are made when first asked for.

FieldMaker = Callable[[str], dict[str, Any]]


class DeferredFields:
    """Base of a dataclass without slots, most fields of which nobody reads. A default is an attribute of the class and
    found before anything is made, so that a field that is made later has none.

    Equality, repr, replace, copies and pickles ask for all fields, and find them.
    """

    @classmethod
    def with_deferred_fields(cls, make: FieldMaker, **known: Any) -> Self:
        """One with these fields; make(name) returns fields that are missing, `name` and what comes with it."""
        made = object.__new__(cls)
        made.__dict__.update(known, _make=make)
        return made

    if not TYPE_CHECKING:  # where any attribute would do, no checker would find a wrong one

        def __getattr__(self, name: str) -> Any:
            """A field that is not made yet. Two threads may both make it; either is right."""
            state, own = self.__dict__, type(self)
            if "_make" not in state or name not in own.__dataclass_fields__:
                raise AttributeError(f"{own.__name__!r} object has no attribute {name!r}", name=name, obj=self)
            state.update(state["_make"](name))
            return state[name]

    def __getstate__(self) -> dict[str, Any]:
        """All fields, and what was computed from them, but not what makes them."""
        state = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        return state | {name: value for name, value in self.__dict__.items() if name != "_make"}


# ----------------------------------------------------------------
# What a designer gets back: forces, slips, gaps, the object's motion, and how far each can be trusted.


@check_method_calls
@dataclass(frozen=True)
class GraspSolution(Record, DeferredFields):
    """The certified answer to a grasp. Arrays are read-only; n contacts; NaN where there is no answer.

    status : SOLVED where every residual is at most 1e-8 (`CERTIFY_TOLERANCE`); else what is proven, or UNDECIDED.
        Torque limits play no part (see `verdict`), unless `TorqueSaturation` makes them laws of the grasp.
    names : (n,) finger names, then those of the environment's contacts, which come last in every array.
    forces : (n, 3) N, force of each finger on the object in its contact axes (x, y tangents, z normal).
    forces_world : (n, 3) N, the same in world axes.
    gap : (n,) m between object and fingertip, ≥ 0.
    slip : (n, 2) m, tangential motion of the object relative to the fingertip, contact axes.
    object_displacement : (6,) m and rad, small motion (linear, angular) of the object about the grasp's reference.
    contact_state : (n,) "separated" | "sticking" | "sliding". A contact whose force is prescribed follows the object:
        no gap, no slip, "sticking".
    residuals : how far each law is missed, relative and SI.
    uniqueness : which object motions and forces the solution leaves free, and whether other equilibria exist, as far
        as that is known; None where there is no solution, or nobody knows: beside effects with unknowns of their own.
    certificate : the proof that nothing holds; None for SOLVED, whose proof is `residuals`. For NOT_HOLDABLE the (6,)
        motion about the reference in which the object escapes; for NO_EQUILIBRIUM where limits on the forces are what
        forbids it, the motion in which the object escapes while these give way.
    iterations : Kaczmarz steps of the stage that solved, 0 where Newton's method alone did, whose steps are in `trace`;
        of another solver its own. trace : one line per stage that ran.
    extra : unknowns of further effects by name, SI.
    torsion : (n,) N·m, moment of each finger on the object about its normal. spin : (n,) rad, how the object turns on
        the fingertip about it. Both zero but for soft fingers, and None where there are none.
    bounds : for NO_EQUILIBRIUM the forces [N] and motions [m] up to which it was proven; None otherwise. cause : what
        stands in the way, in words, where it is known. yielding : with a certificate, how far each limit gives way, by
        name, SI.
    accuracy : what was asked for with `solve(accuracy=...)`, and what was reached; None otherwise.
    advise : finds `required_preload`; None: nothing to find. spec, scene, reference, section : what was solved, with
        which friction cones, for `diagnosis` and `verdict`.
    """

    status: Status
    names: tuple[str, ...]
    forces: Array
    forces_world: Array
    gap: Array
    slip: Array
    object_displacement: Array
    contact_state: tuple[str, ...]
    residuals: Residuals
    uniqueness: Uniqueness | None
    certificate: Array | None
    iterations: int
    trace: tuple[str, ...]
    extra: dict[str, Array] = field(default_factory=dict)
    bounds: tuple[float, float] | None = None
    cause: str = ""
    yielding: dict[str, Array] = field(default_factory=dict)
    accuracy: Accuracy | None = None
    torsion: Array | None = None
    spin: Array | None = None
    advise: Callable[[], float | None] | None = field(default=None, repr=False, compare=False)
    scene: Scene | None = field(default=None, repr=False, compare=False)
    reference: Array | None = field(default=None, repr=False, compare=False)
    spec: GraspSpec | None = field(default=None, repr=False, compare=False)
    section: Section | None = field(default=None, repr=False, compare=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """After pickling, read-only again."""
        self.__dict__.update(
            freeze_arrays(state), extra=freeze_arrays(state["extra"]), yielding=freeze_arrays(state["yielding"])
        )

    @property
    def held(self) -> bool:
        """Whether a certified equilibrium of small motions exists, with squeeze and load applied together. Torque
        limits, links inside the object and large motions do not count: `verdict.ok`. Whether the hand closes, is loaded
        and
        keeps the object, is answered by `grasp.check()`.
        """
        return self.status is Status.SOLVED

    @cached_property
    def required_preload(self) -> float | None:
        """For NO_EQUILIBRIUM the smallest squeeze [m] on every finger that holds within the joints' torque limits, if a
        fifth of the grasp's size is enough: rounded up to two digits, and tried. Many solves, made when it is first
        asked for. None otherwise.
        """
        return None if self.advise is None else self.advise()

    @cached_property
    def diagnosis(self) -> str:
        """One sentence with the fingers' names: what slides, what is loose, how the object escapes, what would help."""
        from handlcp.grasp.solution.diagnosis import UNDECIDED_SENTENCE, DiagnosisText
        from handlcp.grasp.solution.verdict import solution_motions

        if self.scene is None or self.reference is None:
            return self.status.meaning
        faces = self.section.faces if isinstance(self.section, Pyramid) and self.section.inscribed else 0
        who = "finger" if self.spec is None else self.spec.who
        say = DiagnosisText(self.names, self.scene.positions, self.reference, self.scene.environment, faces, who)
        if self.held:
            text = say.describe_held(self.forces, contact_statuses(self.contact_state), self.uniqueness)
            if self.spec is not None and (moved := solution_motions(self)).too_large:
                return f"{text}; but {describe_large_motion(moved.values)}"
            return text
        if self.status is Status.NO_EQUILIBRIUM:
            squeeze = self.scene.offset[2 : 3 * self.scene.n : 3]
            if self.spec is not None and describe_missing_squeeze(self.spec):
                squeeze = np.maximum(squeeze, 0.0)
            return say.describe_no_equilibrium(squeeze, self.required_preload, self.cause, self.bounds is not None)
        return UNDECIDED_SENTENCE if self.certificate is None else say.describe_not_holdable(self.certificate)

    @cached_property
    def verdict(self) -> Verdict:
        """Does it hold? What this solution alone says: its status, its forces, and how far it goes beyond small
        motions. `grasp.check()` also follows the hand while it closes and is loaded.
        """
        from handlcp.grasp.solution.verdict import make_verdict, solution_reasons

        mechanism = None if self.spec is None else self.spec.mechanism
        return make_verdict((*(() if mechanism is None else mechanism.report.reasons(self)), *solution_reasons(self)))

    @property
    def normal_force(self) -> Array:
        """(n,) N, with which each finger presses along its contact's normal."""
        return self.forces[:, 2]

    @property
    def pressed(self) -> dict[str, float]:
        """The normal force of each contact by its name [N]."""
        return dict(zip(self.names, self.normal_force.tolist(), strict=True))

    @property
    def tangential_force(self) -> Array:
        """(n, 2) N, contact axes x, y."""
        return self.forces[:, :2]

    @cached_property
    def friction_used(self) -> Array:
        """(n,) share of its friction limit that each contact uses: 1 on the exact limit, |r_T| / (μ r_N) for Coulomb's
        law, with the half-axes and the moment of other laws. On a pyramid inside the cone a contact slides from
        cos(π / faces) on. NaN where a contact has no friction or no force, and where there is no answer.
        """
        from handlcp.grasp.solution.verdict import friction_used

        nothing = np.full(len(self.names), np.nan)
        if self.scene is None or not self.held:
            return read_only(nothing)
        pushes = self.normal_force > CERTIFY_TOLERANCE * self.residuals.force_scale
        return read_only(np.where(pushes, friction_used(self.scene, self.forces, self.torsion), nothing))

    @cached_property
    def friction_margin(self) -> Array:
        """(n,) N, how much more friction each contact would bear: μ r_N - |r_T|; 0 where it slides or has let go, NaN
        without friction and without an answer. Of a law with several coefficients, in units of the one called mu.
        """
        from handlcp.grasp.solution.verdict import friction_margin

        if self.scene is None or not self.held:
            return read_only(np.full(len(self.names), np.nan))
        margin, noise = (
            friction_margin(self.scene, self.forces, self.torsion),
            CERTIFY_TOLERANCE * self.residuals.force_scale,
        )
        return read_only(np.where(abs(margin) > noise, margin, 0.0 * margin))

    def sensitivity(self) -> Sensitivity:
        """Its derivatives by the load, squeeze, springs, pads, friction, places of contacts, posture and lengths of
        links, from the contact states at the answer: `s.sensitivity().forces_by_wrench` (n, 3, 6), and so on. Raises
        InputError for a solution that is not held.
        """
        from handlcp.grasp.derivatives.sensitivity import make_sensitivity

        return make_sensitivity(self)

    def force_bounds(
        self, pads: tuple[float, float] = (1.0, 1.0), friction: tuple[float, float] = (1.0, 1.0)
    ) -> ForceBounds:
        """The least and largest of every contact force and joint torque over all equilibria with these contact states:
        contacts that are separated stay so, those that stick stick, those that slide go on against the same faces of a
        pyramid or in the same direction on the cone; what touches without force may push, and then sticks if it did not
        slip there, or separate. Where forces are determined, both are the solution's.

        pads, friction : (least, largest) factors, 0 < least ≤ 1 ≤ largest. Every contact may then have any factor of
            its own on its coefficient of friction, and any of its own on what its pad gives way along each contact axis
            (all of E that is the contact's own and not the joints'). The command of the joints stays. The bounds hold
            for every equilibrium of every such grasp that keeps the states, slides in any direction included; they are
            outer ones: with pads between factors not every value between them is taken.

        Other equilibria with other contact states are not among them (`grasp.equilibria()`). Raises InputError for a
        solution that is not held, Unsupported beside effects with unknowns of their own that are no limits.
        """
        from handlcp.grasp.solution.force_bounds import find_force_bounds

        return find_force_bounds(self, pads, friction)

    def plot(self, path: Any = None, *, obj: Any = None, title: str = "", verdict: Any = None) -> Any:
        """The picture of the grasp: a matplotlib figure, or the file that it was written to.

        path : of a png, svg or pdf file; None: the figure itself, which a notebook shows. obj : what to draw as the
        object where the grasp knows none. verdict : of `grasp.check()`, and drawn is the end of the loading that it
        is about, where that is reached; None: what this solution alone says.
        Raises InputError for an unknown format or a missing folder, Unsupported without matplotlib.
        """
        from handlcp.viz import plot_solution  # answers pay for no picture that nobody draws

        return plot_solution(self, path, obj, title, verdict)

    def page(self, path: Any, *, obj: Any = None, title: str = "", verdict: Any = None, loading: Any = None) -> Path:
        """A page to turn the grasp on: one HTML file that needs no network. Returns the file.

        path : it ends in .html. obj : as in `plot`. loading : what `grasp.follow()` returned, which the page shows step
        by step; None: the loading that the verdict is about, if any. verdict : of `grasp.check()`; None: whether the
        loading reached its end, or without a loading what this solution alone says.
        Raises InputError for a file that cannot be written, Unsupported without trimesh, which brings the viewer.
        """
        from handlcp.viz import write_solution_page  # nor for a page

        return write_solution_page(self, path, obj, title, verdict, loading)

    def to_dict(self) -> dict[str, Any]:
        """The whole answer as plain data: SI units in the key names, None for what is not a finite number."""
        from handlcp.viz import solution_to_dict  # nor for data that nobody writes

        return solution_to_dict(self)

    def to_frame(self, of: str = "contacts") -> Any:
        """A pandas table, indexed by name. SI units in the names of the columns; NaN where there is no answer.

        of : "contacts": state, normal_N, friction_N, friction_used, friction_margin_N, slip_m, gap_m, the force in
        contact axes (x_N, y_N, z_N) and in world axes, and of soft fingers the moment about the normal. "joints":
        torque_Nm, limit_Nm, utilisation, margin_Nm, yield_rad.
        Raises InputError for anything else, and for joints without a hand; Unsupported without pandas.
        """
        tables = self._tables()
        if of not in tables:
            without = "" if "joints" in tables else " for a grasp without a hand"
            raise InputError("of", " or ".join(f'"{name}"' for name in tables) + without, repr(of))
        return make_data_frame(*tables[of])

    def _tables(self) -> dict[str, tuple[dict[str, Any], list[str]]]:
        """Columns and index of each table, by its name."""
        return {"contacts": (contact_data(self), words.number_duplicates(getattr(self, "names")))}  # noqa: B009

    def _repr_html_(self) -> str:
        """What a notebook shows: the verdict, the contacts, the joints."""
        from handlcp.viz import solution_html  # for notebooks alone

        return solution_html(self)

    def __str__(self) -> str:
        return format_solution(self, ())
