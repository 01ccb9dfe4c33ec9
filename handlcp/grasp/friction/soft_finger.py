"""Soft fingers: a patch that bears a moment about its normal besides the tangential force.

|r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²,    (v_T, ω_n) along minus the ellipsoid's normal on the limit
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from handlcp.check import number
from handlcp.errors import InputError
from handlcp.grasp.friction.law import FrictionLaw
from handlcp.keywords import helped_init, helped_methods
from handlcp.tolerances import STEEPEST


@helped_init()
@helped_methods
@dataclass(frozen=True, slots=True)
class SoftFinger(FrictionLaw):
    """A patch instead of a point: it bears a moment r_τ about the normal as well, |r_T|²/μ² + r_τ²/μ_τ² ≤ r_N².

    mu : coefficient of the tangential force [-], > 0 and ≤ 1e4, or anything ≥ 0 where mu_torsion is 0. mu_torsion : of
    the moment, N·m per N of normal force, ≥ 0 [m]; 0 is Coulomb's law. A grasp refuses mu_torsion / mu beyond 1000
    times its own size.
    torsional_flexibility : of the pad about the normal [rad/(N·m)], besides what the joints give way.

    A planar scene has no moment about a normal in its plane: there it is Coulomb's law. Raises InputError.
    """

    mu: float
    mu_torsion: float
    torsional_flexibility: float = 0.0

    call: ClassVar[str] = "SoftFinger(mu, mu_torsion)"
    file_keys: ClassVar[tuple[dict[str, str], dict[str, str]]] = (
        {"mu": "mu", "mu_torsion_m": "mu_torsion"},
        {"torsional_flexibility_rad_per_Nm": "torsional_flexibility"},
    )

    def __post_init__(self) -> None:
        for name in ("mu", "mu_torsion", "torsional_flexibility"):
            object.__setattr__(self, name, number(f"SoftFinger.{name}", getattr(self, name), minimum=0.0))
        if self.mu_torsion > 0.0 and not 0.0 < self.mu <= STEEPEST:
            raise InputError("SoftFinger.mu", f"a number > 0 and ≤ {STEEPEST:g} beside mu_torsion > 0", self.mu)

    @property
    def lever(self) -> float:
        """μ_τ/μ [m]."""
        return self.mu_torsion / self.mu if self.mu > 0.0 else 0.0

    @property
    def pad_torsion(self) -> float:
        return self.torsional_flexibility

    def with_mu(self, mu: float) -> SoftFinger:
        """The same lever with another coefficient."""
        mu = number("mu", mu, minimum=0.0)
        return SoftFinger(mu, mu * self.lever, self.torsional_flexibility)
