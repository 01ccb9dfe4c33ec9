"""What an envelope loads the object with: a force, a torque, its weight in any orientation of the hand, or wrenches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, array, read_only
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.validate import lift
from handlcp.hand import HandGrasp

FORCE, TORQUE, GRAVITY, WRENCH = "force", "torque", "gravity", "wrench"
_UNITS = {FORCE: "N", TORQUE: "N·m", GRAVITY: "kg", WRENCH: ""}
_G = 9.81  # [m/s²] where the grasp knows no gravity


@dataclass(frozen=True, slots=True)
class Load:
    """A load in any direction d, beside what the grasp bears anyway.

    of : "force", "torque", "gravity", "wrench". unit : of the factors. grasp : the one that is loaded; without its
    object's weight where that is what is asked for. at (3,) : where a force acts [m]; NaN for the others but gravity.
    g : [m/s²] of gravity; 0 for others. mass : of the object [kg]; 0 where it has none.
    """

    of: str
    grasp: Grasp
    at: Array
    g: float
    mass: float

    @property
    def unit(self) -> str:
        """Of the factors: N, N·m, kg, or "" for multiples of a wrench."""
        return _UNITS[self.of]

    def wrenches(self, directions: Array) -> Array:
        """(m, 6) for a factor of 1, about the grasp's reference: 1 N, 1 N·m, or the weight of 1 kg."""
        none = np.zeros_like(directions)
        if self.of == TORQUE:
            return np.concatenate([none, directions], axis=1)
        force = directions * (self.g if self.of == GRAVITY else 1.0)
        return np.concatenate([force, np.cross(self.at - self.grasp.reference, force)], axis=1)

    def specs(self, directions: Array) -> Iterator[tuple[GraspSpec, Bools]]:
        """Specifications, each with the (m,) directions that it is loaded in: one for all, or one for each where the
        fingers weigh something and gravity turns.
        """
        grasp = self.grasp
        if self.of == GRAVITY and isinstance(grasp, HandGrasp) and grasp.finger_weight:
            for k, d in enumerate(directions):
                yield grasp.replace(gravity=self.g * d).spec, np.arange(len(directions)) == k
        else:
            yield grasp.spec, np.ones(len(directions), dtype=bool)


def load_of(grasp: Grasp, of: Any, at: Any) -> Load:
    """See `envelope`. Raises InputError."""
    if not isinstance(of, str) or of not in _UNITS:
        raise InputError("of", '"force", "torque" or "gravity"', repr(of)[:80])
    if at is not None and of != FORCE:
        raise InputError("at", f"None beside of={of!r}: only a force acts at a point that is chosen", repr(at)[:80])
    target = getattr(grasp, "target", None)
    mass = 0.0 if target is None else float(target.mass)
    spec, g = grasp.spec, 0.0
    above = np.zeros(3) if spec.plane is None else spec.plane * lift(spec.positions, spec.reference, spec.plane)
    point = spec.reference + above if at is None else array("at", at, (3,), what="a point [m]")
    if of == GRAVITY:
        given = float(np.linalg.norm(grasp.given_gravity)) if isinstance(grasp, HandGrasp) else 0.0
        g = given or _G
        point = point if target is None else target.center_of_mass
        grasp = grasp.replace(mass=0.0) if mass else grasp  # type: ignore[call-arg]  # it is a hand's
    return Load(of, grasp, read_only(np.array(point if of in (FORCE, GRAVITY) else np.full(3, np.nan))), g, mass)
