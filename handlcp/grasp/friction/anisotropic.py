"""Anisotropic friction: a contact that holds better one way than the other, such as ribbed rubber.

(r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²,    v_T = -α (r_x/μ_x², r_y/μ_y²), α ≥ 0 on the limit
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from handlcp.check import array, number
from handlcp.grasp.friction.coulomb import Coulomb
from handlcp.grasp.friction.law import FrictionLaw
from handlcp.keywords import helped_init, helped_methods


@helped_init()
@helped_methods
@dataclass(frozen=True, init=False)
class AnisotropicCoulomb(FrictionLaw):
    """Dry friction that differs with the direction, (r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²; a sliding contact is on the ellipse
    and its slip along minus the ellipse's normal (maximum dissipation), which is not against the force in general.

    mu_x, mu_y : coefficients > 0 along the contact's x and y axes [-]; equal ones are Coulomb's law.
    along : (3,) direction of x, world axes, projected on the tangent plane of a contact whose `tangent` is not given;
        None: the contact's own choice, which differs from finger to finger where contacts are detected. With "faces"
        the polygon is Coulomb's, stretched.

    Raises InputError.
    """

    mu_x: float
    mu_y: float
    along: tuple[float, ...] | None

    call: ClassVar[str] = "AnisotropicCoulomb(mu_x, mu_y)"
    file_keys: ClassVar[tuple[dict[str, str], dict[str, str]]] = ({"mu_x": "mu_x", "mu_y": "mu_y"}, {"along": "along"})

    def __init__(self, mu_x: float, mu_y: float, along: Any = None) -> None:
        for name, value in (("mu_x", mu_x), ("mu_y", mu_y)):
            object.__setattr__(self, name, number(f"AnisotropicCoulomb.{name}", value, above=0.0))
        object.__setattr__(self, "mu", max(self.mu_x, self.mu_y))  # which the other is measured by
        given = None if along is None else array("AnisotropicCoulomb.along", along, (3,), (2,))
        object.__setattr__(self, "along", None if given is None else tuple(given.tolist()))

    @property
    def scale(self) -> tuple[float, float]:
        """(μ_x, μ_y) / μ."""
        return self.mu_x / self.mu, self.mu_y / self.mu

    @property
    def x_axis(self) -> Any:
        return self.along

    def with_mu(self, mu: float) -> FrictionLaw:
        """The same ellipse, grown or shrunk until its larger half-axis is `mu`."""
        mu, (x, y) = number("mu", mu, minimum=0.0), self.scale
        return AnisotropicCoulomb(mu * x, mu * y, self.along) if mu * min(x, y) > 0.0 else Coulomb(0.0)

    def __repr__(self) -> str:
        along = "" if self.along is None else f", along={self.along}"
        return f"AnisotropicCoulomb({self.mu_x!r}, {self.mu_y!r}{along})"
