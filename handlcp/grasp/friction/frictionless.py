"""No friction: the contact pushes along its normal only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from handlcp.grasp.friction.coulomb import Coulomb
from handlcp.grasp.friction.law import FrictionLaw
from handlcp.keywords import helped_init, helped_methods


@helped_init()
@helped_methods
@dataclass(frozen=True, slots=True)
class Frictionless(FrictionLaw):
    """No tangential force, and therefore no tangential unknowns at all."""

    call: ClassVar[str] = "Frictionless()"
    mu = 0.0

    def with_mu(self, mu: float) -> Coulomb:
        return Coulomb(mu)

    def to_file(self) -> str:
        return "frictionless"
