"""`EnvelopeQuestion`: the limits of one grasp along many directions, asked for in pieces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, check_array, check_number, read_only
from handlcp.contact.friction import Section
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.grasp.failure.failure_mode import OBJECT, UNDECIDED, FailureMode
from handlcp.grasp.limits.load_limit import limits_of
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.validate import height_above
from handlcp.grasp.path.watch import read_max_slip
from handlcp.grasp.verify.static_load_bound import static_load_bounds
from handlcp.hand import HandGrasp
from handlcp.lcp.compiler.compile_policy import compile_in_background
from handlcp.progress import Progress, track_progress
from handlcp.studies.envelope.direction import BindingCauses

# ----------------------------------------------------------------
# What an envelope loads the object with: a force, a torque, its weight in any orientation of the hand, or wrenches.

FORCE, TORQUE, GRAVITY, WRENCH = "force", "torque", "gravity", "wrench"
_LOAD_UNITS = {FORCE: "N", TORQUE: "N·m", GRAVITY: "kg", WRENCH: ""}
_STANDARD_GRAVITY = 9.81  # [m/s²] where the grasp knows no gravity


@dataclass(frozen=True, slots=True)
class DirectionalLoad:
    """A load in any direction d, beside what the grasp bears anyway.

    kind : "force", "torque", "gravity", "wrench".
    grasp : the one that is loaded; without its object's weight where that is what is asked for.
    at (3,) : where a force, or the weight, acts [m], world axes; NaN for torques and wrenches.
    gravity : acceleration of gravity [m/s²]; 0 where that is not what is asked for.
    mass : of the object [kg]; 0 where it has none.
    """

    kind: str
    grasp: Grasp
    at: Array
    gravity: float
    mass: float

    @property
    def unit(self) -> str:
        """The unit of the factors: N, N·m, kg, or "" for multiples of a wrench."""
        return _LOAD_UNITS[self.kind]

    def wrenches(self, directions: Array) -> Array:
        """(m, 6) for a factor of 1, about the grasp's reference: 1 N, 1 N·m, or the weight of 1 kg."""
        none = np.zeros_like(directions)
        if self.kind == TORQUE:
            return np.concatenate([none, directions], axis=1)
        force = directions * (self.gravity if self.kind == GRAVITY else 1.0)
        return np.concatenate([force, np.cross(self.at - self.grasp.reference, force)], axis=1)

    def specs(self, directions: Array) -> Iterator[tuple[GraspSpec, Bools]]:
        """Specifications, each with the (m,) directions that it is loaded in: one for all, or one for each where the
        fingers weigh something and gravity turns.
        """
        grasp = self.grasp
        if self.kind == GRAVITY and isinstance(grasp, HandGrasp) and grasp.finger_weight:
            for k, d in enumerate(directions):
                yield grasp.replace(gravity=self.gravity * d).spec, np.arange(len(directions)) == k
        else:
            yield grasp.spec, np.ones(len(directions), dtype=bool)


def read_load(grasp: Grasp, of: Any, at: Any) -> DirectionalLoad:
    """Check what an envelope loads a grasp with. of, at : as in `envelope`. Raises InputError."""
    if not isinstance(of, str) or of not in _LOAD_UNITS:
        raise InputError("of", '"force", "torque" or "gravity"', repr(of)[:80])
    if at is not None and of != FORCE:
        raise InputError("at", f"None beside of={of!r}: only a force acts at a point that is chosen", repr(at)[:80])
    target = getattr(grasp, "target", None)
    mass = 0.0 if target is None else float(target.mass)
    spec, g = grasp.spec, 0.0
    above = np.zeros(3) if spec.plane is None else spec.plane * height_above(spec.positions, spec.reference, spec.plane)
    point = spec.reference + above if at is None else check_array("at", at, (3,), what="a point [m]")
    if of == GRAVITY:
        given = float(np.linalg.norm(grasp.given_gravity)) if isinstance(grasp, HandGrasp) else 0.0
        g = given or _STANDARD_GRAVITY
        point = point if target is None else target.center_of_mass
        grasp = grasp.replace(mass=0.0) if mass else grasp  # type: ignore[call-arg]  # it is a hand's
    where = np.array(point) if of in (FORCE, GRAVITY) else np.full(3, np.nan)
    return DirectionalLoad(of, grasp, read_only(where), g, mass)


# ----------------------------------------------------------------

FIXED_GEOMETRY, FOLLOWED_GEOMETRY = "fixed", "followed"
_DIRECTIONS_PER_CALL = {FIXED_GEOMETRY: 64, FOLLOWED_GEOMETRY: 16}  # directions that are asked for at once


@dataclass(frozen=True, slots=True)
class EnvelopeQuestion:
    """The question for the largest factor of a load, which is the same along every direction.

    load : what the object is loaded with. section : of the friction limits. geometry, motion, turn, accuracy, max_slip
    : as in `envelope`.
    """

    load: DirectionalLoad
    section: Section
    geometry: str
    motion: float | None
    turn: float | None
    accuracy: float | None
    max_slip: Array

    @classmethod
    def read(
        cls, load: DirectionalLoad, names: tuple[str, ...], section: Section, geometry: str, motion: Any, turn: Any,
        accuracy: Any, max_slip: Any,
    ) -> EnvelopeQuestion:  # fmt: skip
        """The question with its limits checked. names : of the contacts. Raises InputError, UnknownName."""
        asked = {"motion": motion, "turn": turn, "accuracy": accuracy}
        far, wide, near = (None if x is None else check_number(name, x, above=0.0) for name, x in asked.items())
        return cls(load, section, geometry, far, wide, near, read_max_slip(max_slip, names))

    def wrenches(self, directions: Array, given: Array | None) -> Array:
        """(m, 6) for a factor of 1. given : in place of those of the directions."""
        return self.load.wrenches(directions) if given is None else given

    def find_factors(
        self, directions: Array, given: Array | None, progress: Progress = None
    ) -> tuple[Array, tuple[BindingCauses, ...], Array]:
        """(m,) factors, and for each what binds, () where nothing does, and its estimated error. progress : as in
        `envelope`.

        No load that friction and torque limits alone bound is held without end: where a path found no limit although
        there is such a bound, the factor is NaN.
        """
        wrenches, m = self.wrenches(directions, given), len(directions)
        factors, binds, off = np.empty(m), list[BindingCauses]([()] * m), np.empty(m)
        size, asked = _DIRECTIONS_PER_CALL[self.geometry], (self.motion, self.turn, self.accuracy, self.max_slip)
        with track_progress("directions", m, progress) as done, compile_in_background(m):
            done(0)
            for spec, where in self.load.specs(directions):
                every = np.flatnonzero(where)
                for here in (every[start : start + size] for start in range(0, len(every), size)):
                    found = limits_of(spec, self.section, wrenches[here], self.geometry, *asked)
                    factors[here], off[here] = found.factors, found.accuracy
                    for k, some in zip(here.tolist(), found.binds, strict=True):
                        binds[k] = some
                    if len(endless := here[np.isinf(found.factors)]):
                        known = static_load_bounds(spec, self.section, wrenches[endless]).factors
                        for k in endless[np.isfinite(known)].tolist():
                            factors[k], binds[k] = np.nan, (FailureMode(UNDECIDED, OBJECT),)
                    done(len(here))
        return factors, tuple(binds), off

    def find_bound_factors(self, directions: Array, given: Array | None) -> Array:
        """(m,) the largest factors that any forces within friction and torque limits balance."""
        wrenches, found = self.wrenches(directions, given), np.empty(len(directions))
        for spec, where in self.load.specs(directions):
            found[where] = static_load_bounds(spec, self.section, wrenches[where]).factors
        return found
