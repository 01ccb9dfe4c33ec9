"""Friction laws: what a contact can transmit in its tangent plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from handlcp.check import number

__all__ = ["Coulomb", "Friction", "Frictionless"]


@dataclass(frozen=True, slots=True)
class Coulomb:
    """Dry friction, |r_T| ≤ μ r_N; a sliding contact is on the limit and pulls against its slip.

    `mu`: coefficient ≥ 0 [-]. With μ = 0 the contact is frictionless and gets no tangential unknowns.
    Raises InputError for anything but a finite number ≥ 0.
    """

    mu: float

    def __post_init__(self) -> None:
        """Check μ."""
        object.__setattr__(self, "mu", number("Coulomb.mu", self.mu, minimum=0.0))


@dataclass(frozen=True, slots=True)
class Frictionless:
    """No tangential force, and therefore no tangential unknowns at all."""

    @property
    def mu(self) -> float:
        """Zero: the coefficient of a contact without friction [-]."""
        return 0.0


Friction: TypeAlias = Coulomb | Frictionless
