"""Coulomb's law: dry friction, alike in all directions.

|r_T| ≤ μ r_N,    v_T = -α r_T, α ≥ 0 on the limit
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from handlcp.check import number
from handlcp.grasp.friction.law import FrictionLaw
from handlcp.keywords import helped_init, helped_methods


@helped_init()
@helped_methods
@dataclass(frozen=True, slots=True)
class Coulomb(FrictionLaw):
    """Dry friction, |r_T| ≤ μ r_N; a sliding contact is on the limit and pulls against its slip.

    `mu`: coefficient ≥ 0 [-]. With μ = 0 the contact is frictionless and gets no tangential unknowns.
    Raises InputError for anything but a finite number ≥ 0.
    """

    mu: float

    call: ClassVar[str] = "Coulomb(mu)"

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", number("Coulomb.mu", self.mu, minimum=0.0))

    def with_mu(self, mu: float) -> Coulomb:
        return Coulomb(mu)
