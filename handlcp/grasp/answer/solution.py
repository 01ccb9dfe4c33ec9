"""What a designer gets back: forces, slips, gaps, the object's motion, and how far each can be trusted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from handlcp.check import Array, read_only, sealed
from handlcp.grasp.answer.printed import Shown
from handlcp.grasp.effects.joint_offset import unsqueezed
from handlcp.grasp.friction import Pyramid, Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.verify.judge import Residuals
from handlcp.keywords import helped_methods
from handlcp.lcp.problem import Status
from handlcp.record import Record
from handlcp.tolerances import CERTIFY

if TYPE_CHECKING:
    from handlcp.grasp.answer.force_bounds import ForceBounds
    from handlcp.grasp.answer.small_motions import Motions
    from handlcp.grasp.answer.uniqueness import Uniqueness
    from handlcp.grasp.answer.verdict import Verdict
    from handlcp.grasp.sensitivity.sensitivity import Sensitivity


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

Maker = Callable[[str], dict[str, Any]]


class Deferred:
    """Base of a dataclass without slots, most fields of which nobody reads. A default is an attribute of the class and
    found before anything is made, so that a field that is made later has none.

    Equality, repr, replace, copies and pickles ask for all fields, and find them.
    """

    @classmethod
    def deferred(cls, make: Maker, **known: Any) -> Self:
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


@helped_methods
@dataclass(frozen=True)
class GraspSolution(Shown, Deferred):
    """The certified answer to a grasp. Arrays are read-only; n contacts; NaN where there is no answer.

    status : the certifier's verdict.
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
    certificate : for NOT_HOLDABLE the (6,) motion about the reference in which the object escapes; for NO_EQUILIBRIUM
        where limits on the forces are what forbids it, the motion in which the object escapes while these give way.
    iterations : steps of the method that gave the answer. trace : one line per stage that ran.
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
        self.__dict__.update(sealed(state), extra=sealed(state["extra"]), yielding=sealed(state["yielding"]))

    @property
    def held(self) -> bool:
        """Whether a certified equilibrium of small motions exists, with squeeze and load applied together. A designer's
        question, whether the hand closes, is loaded and keeps the object, is answered by `grasp.check()`.
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
        from handlcp.grasp.answer.diagnosis import UNDECIDED, Sentences

        if self.scene is None or self.reference is None:
            return self.status.meaning
        faces = self.section.faces if isinstance(self.section, Pyramid) and self.section.inscribed else 0
        who = "finger" if self.spec is None else self.spec.who
        say = Sentences(self.names, self.scene.positions, self.reference, self.scene.environment, faces, who)
        if self.held:
            text, moved = say.held(self.forces, self.contact_state, self.uniqueness), self._motions
            return f"{text}; but {moved.sentence}" if moved is not None and moved.too_large else text
        if self.status is Status.NO_EQUILIBRIUM:
            squeeze = self.scene.offset[2 : 3 * self.scene.n : 3]
            if self.spec is not None and unsqueezed(self.spec):
                squeeze = np.maximum(squeeze, 0.0)
            return say.no_equilibrium(squeeze, self.required_preload, self.cause, self.bounds is not None)
        return UNDECIDED if self.certificate is None else say.not_holdable(self.certificate)

    @cached_property
    def verdict(self) -> Verdict:
        """Does it hold? What this solution alone says: its status, its forces, and how far it goes beyond small
        motions. `grasp.check()` also follows the hand while it closes and is loaded.
        """
        from handlcp.grasp.answer.reasons import reasons_of
        from handlcp.grasp.answer.verdict import verdict_of

        mechanism = None if self.spec is None else self.spec.mechanism
        return verdict_of((*(() if mechanism is None else mechanism.reasons(self)), *reasons_of(self)))

    @property
    def _motions(self) -> Motions | None:
        """How far an answer goes beyond small motions; None where it is not known what was solved."""
        from handlcp.grasp.answer.small_motions import motions

        return None if self.spec is None else motions(self)

    @property
    def normal_force(self) -> Array:
        """(n,) N."""
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
        from handlcp.grasp.answer.reasons import friction_used

        nothing = np.full(len(self.names), np.nan)
        if self.scene is None or not self.held:
            return read_only(nothing)
        pushes = self.normal_force > CERTIFY * self.residuals.force_scale
        return read_only(np.where(pushes, friction_used(self.scene, self.forces, self.torsion), nothing))

    @cached_property
    def friction_margin(self) -> Array:
        """(n,) N, how much more friction each contact would bear: μ r_N - |r_T|; 0 where it slides or has let go, NaN
        without friction and without an answer. Of a law with several coefficients, in units of the one called mu.
        """
        from handlcp.grasp.answer.reasons import friction_margin

        if self.scene is None or not self.held:
            return read_only(np.full(len(self.names), np.nan))
        margin, noise = friction_margin(self.scene, self.forces, self.torsion), CERTIFY * self.residuals.force_scale
        return read_only(np.where(abs(margin) > noise, margin, 0.0 * margin))

    def sensitivity(self) -> Sensitivity:
        """Its derivatives by the load, squeeze, springs, pads, friction, places of contacts, posture and lengths of
        links, from the contact states at the answer: `s.sensitivity().forces_by_wrench` (n, 3, 6), and so on. Raises
        InputError for a solution that is not held.
        """
        from handlcp.grasp.sensitivity.sensitivity import sensitivity_of

        return sensitivity_of(self)

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
        from handlcp.grasp.answer.force_bounds import force_bounds_of

        return force_bounds_of(self, pads, friction)

    def __str__(self) -> str:
        from handlcp.grasp.answer.printed import printed

        return printed(self, ())
