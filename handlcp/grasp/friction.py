"""Friction laws: what a contact can transmit in its tangent plane, and about its normal.

Each law is a ball in coordinates of its own. With r = S r̂ for a diagonal S, the `scale`, force and slip obey

    |r̂_t| ≤ μ r_N,    v̂_t = S v_t = -α r̂_t, α ≥ 0 on the limit

S keeps the power, r·v = r̂·v̂, and therefore maximum dissipation. Source: Goyal, Ruina & Papadopoulos, Wear 143 (1991),
limit surfaces; Howe & Cutkosky, Int. J. Robotics Research 15 (1996), their ellipsoid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias, get_args

from handlcp.check import array, number
from handlcp.errors import InputError

__all__ = ["LAW", "LAWS", "AnisotropicCoulomb", "Coulomb", "Friction", "Frictionless", "SoftFinger"]

_ALIKE = (1.0, 1.0)


class _Law:
    """Friction of a point that is alike in all directions, unless a law says otherwise."""

    __slots__ = ()

    @property
    def scale(self) -> tuple[float, float]:
        """Of the two tangents: one."""
        return _ALIKE

    @property
    def lever(self) -> float:
        """Of the torsional moment: there is none [m]."""
        return 0.0

    def with_mu(self, mu: float) -> Friction:
        """The same law with another coefficient."""
        return Coulomb(mu)


@dataclass(frozen=True, slots=True)
class Coulomb(_Law):
    """Dry friction, |r_T| ≤ μ r_N; a sliding contact is on the limit and pulls against its slip.

    `mu`: coefficient ≥ 0 [-]. With μ = 0 the contact is frictionless and gets no tangential unknowns.
    Raises InputError for anything but a finite number ≥ 0.
    """

    mu: float

    def __post_init__(self) -> None:
        """Check μ."""
        object.__setattr__(self, "mu", number("Coulomb.mu", self.mu, minimum=0.0))


@dataclass(frozen=True, slots=True)
class Frictionless(_Law):
    """No tangential force, and therefore no tangential unknowns at all."""

    @property
    def mu(self) -> float:
        """Zero: the coefficient of a contact without friction [-]."""
        return 0.0


@dataclass(frozen=True, init=False)
class AnisotropicCoulomb(_Law):
    """Dry friction that differs with the direction, (r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²; a sliding contact is on the ellipse
    and its slip along minus the ellipse's normal (maximum dissipation), which is not against the force in general.

    mu_x, mu_y : coefficients > 0 along the contact's x and y axes [-]; equal ones are Coulomb's law.
    along : (3,) direction of x, world axes, projected on the tangent plane of a contact whose `tangent` is not given;
        None: the contact's own choice, which is another one from finger to finger where contacts are detected. With
        "faces" the polygon is Coulomb's, stretched.

    Raises InputError.
    """

    mu_x: float
    mu_y: float
    along: tuple[float, ...] | None

    def __init__(self, mu_x: float, mu_y: float, along: Any = None) -> None:
        for name, value in (("mu_x", mu_x), ("mu_y", mu_y)):
            object.__setattr__(self, name, number(f"AnisotropicCoulomb.{name}", value, above=0.0))
        given = None if along is None else array("AnisotropicCoulomb.along", along, (3,), (2,))
        object.__setattr__(self, "along", None if given is None else tuple(given.tolist()))

    @property
    def mu(self) -> float:
        """The larger of the two, which the other is measured by [-]."""
        return max(self.mu_x, self.mu_y)

    @property
    def scale(self) -> tuple[float, float]:
        """(μ_x, μ_y) / μ."""
        return self.mu_x / self.mu, self.mu_y / self.mu

    def toward(self, x: float, y: float) -> float:
        """The coefficient along a direction of the contact's axes, a unit vector (x, y)."""
        return 1.0 / math.hypot(x / self.mu_x, y / self.mu_y)

    def with_mu(self, mu: float) -> Friction:
        """The same ellipse, grown or shrunk until its larger half-axis is `mu`."""
        x, y = self.scale
        return AnisotropicCoulomb(mu * x, mu * y, self.along) if mu * min(x, y) > 0.0 else Coulomb(0.0)

    def __repr__(self) -> str:
        along = "" if self.along is None else f", along={self.along}"
        return f"AnisotropicCoulomb({self.mu_x!r}, {self.mu_y!r}{along})"


@dataclass(frozen=True, slots=True)
class SoftFinger(_Law):
    """A patch instead of a point: it bears a moment r_τ about the normal as well, |r_T|²/μ² + r_τ²/μ_τ² ≤ r_N².

    mu : coefficient > 0 of the tangential force [-]. mu_torsion : of the moment, N·m per N of normal force, > 0 [m]; 0
    is Coulomb's law. torsional_flexibility : of the pad about the normal [rad/(N·m)], besides what the joints give way.

    A planar scene has no moment about a normal in its plane: there it is Coulomb's law. Raises InputError.
    """

    mu: float
    mu_torsion: float
    torsional_flexibility: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("mu", "mu_torsion", "torsional_flexibility"):
            object.__setattr__(self, name, number(f"SoftFinger.{name}", getattr(self, name), minimum=0.0))
        if self.mu == 0.0 and self.mu_torsion > 0.0:
            raise InputError("SoftFinger.mu", "a number > 0 beside mu_torsion > 0", self.mu)

    @property
    def lever(self) -> float:
        """μ_τ/μ, which turns the moment into a force r̂_τ = r_τ/lever [m]; 0: no moment."""
        return self.mu_torsion / self.mu if self.mu > 0.0 else 0.0

    def with_mu(self, mu: float) -> Friction:
        """The same lever with another coefficient."""
        return SoftFinger(mu, mu * self.lever, self.torsional_flexibility)


Friction: TypeAlias = Coulomb | Frictionless | AnisotropicCoulomb | SoftFinger

LAWS: tuple[type, ...] = get_args(Friction)
LAW = "Coulomb(mu), Frictionless(), AnisotropicCoulomb(mu_x, mu_y) or SoftFinger(mu, mu_torsion)"  # for refusals
