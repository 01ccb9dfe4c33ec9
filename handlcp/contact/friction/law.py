"""`FrictionLaw`: what a contact can transmit along its tangents and about its normal; `Coulomb` and the other laws.

Each law is a ball in coordinates of its own. With r = S r̂ for a diagonal S, the `scale`, force and slip obey

    |r̂_t| ≤ μ r_N,    v̂_t = S v_t = -α r̂_t, α ≥ 0 on the limit

S keeps the power, r·v = r̂·v̂, and therefore maximum dissipation. A solver takes the ball itself, or a polygon or
polyhedron in its place (`section`, `limit_set`). Source: Goyal, Ruina & Papadopoulos, Wear 143 (1991), limit surfaces;
Howe & Cutkosky, Int. J. Robotics Research 15 (1996), their ellipsoid.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from handlcp.check import check_array, check_init_call, check_keys, check_method_calls, check_number
from handlcp.errors import InputError, shorten_repr
from handlcp.tolerances import MAX_SOFT_FINGER_FRICTION

_LAWS: dict[tuple[str, str], type[FrictionLaw]] = {}


@check_method_calls
class FrictionLaw:
    """Friction of a point contact that is alike in all directions, unless a subclass says otherwise.

    The set grows in proportion to r_N: a friction cone. A bound that does not is an effect, made of `Limit`s.
    Subclasses have `mu`, the coefficient [-] along an axis whose scale is 1, and

    call : how a user writes the law, for refusals. file_keys : of a scene file's friction table, which of them are
    needed and which may stand beside them, each with the argument that it becomes; no keys: no table is this law.
    """

    call: ClassVar[str]
    file_keys: ClassVar[tuple[dict[str, str], dict[str, str]]] = ({}, {})

    __slots__ = ()

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        # By name: dataclass(slots=True) makes a class a second time
        _LAWS[cls.__module__, cls.__qualname__] = cls

    @property
    def scale(self) -> tuple[float, float]:
        """Diagonal of S for the two tangents [-]."""
        return _UNIT_SCALE

    @property
    def lever(self) -> float:
        """S for the moment about the normal: what turns it into a force r̂_τ = r_τ / lever [m]; 0: it bears none."""
        return 0.0

    @property
    def pad_torsion(self) -> float:
        """Flexibility of the pad about the normal, besides what the joints give way [rad/(N·m)]."""
        return 0.0

    @property
    def x_axis(self) -> Any:
        """(3,) the direction of the contact's x axis where the contact itself says nothing; None: any will do."""
        return None

    @property
    def plain(self) -> bool:
        """Whether the law is a disc in contact axes."""
        return self.lever == 0.0 and self.scale == _UNIT_SCALE

    def toward(self, x: float, y: float) -> float:
        """The coefficient along a direction of the tangents, a unit vector (x, y): in a plane there is only one."""
        sx, sy = self.scale
        return float(self.mu / ((x / sx) ** 2 + (y / sy) ** 2) ** 0.5)

    def with_mu(self, mu: float) -> FrictionLaw:
        """The same law, grown or shrunk until its coefficient is `mu`."""
        raise NotImplementedError

    @classmethod
    def from_file(cls, table: dict[str, Any]) -> Self:
        """The law of a scene file's table, which has the keys that `file_keys` says."""
        names = cls.file_keys[0] | cls.file_keys[1]
        return cls(**{names[key]: value for key, value in table.items()})

    def to_file(self) -> Any:
        """What a scene file says of the law: its table, or for one without keys of its own its coefficient."""
        names = self.file_keys[0] | self.file_keys[1]
        table = {key: value for key, argument in names.items() if (value := getattr(self, argument)) is not None}
        return table or self.mu

    mu: float


_UNIT_SCALE = (1.0, 1.0)


def friction_laws() -> tuple[type[FrictionLaw], ...]:
    """All laws there are, in the order in which they were defined."""
    return tuple(_LAWS.values())


# ----------------------------------------------------------------
# Coulomb's law: dry friction, alike in all directions.
#
# |r_T| ≤ μ r_N,    v_T = -α r_T, α ≥ 0 on the limit


@check_init_call()
@check_method_calls
@dataclass(frozen=True, slots=True)
class Coulomb(FrictionLaw):
    """Dry friction, |r_T| ≤ μ r_N; a sliding contact is on the limit and pulls against its slip.

    `mu`: coefficient ≥ 0 [-]. With μ = 0 the contact is frictionless and gets no tangential unknowns.
    Raises InputError for anything but a finite number ≥ 0.
    """

    mu: float

    call: ClassVar[str] = "Coulomb(mu)"

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", check_number("Coulomb.mu", self.mu, minimum=0.0))

    def with_mu(self, mu: float) -> Coulomb:
        return Coulomb(mu)


# ----------------------------------------------------------------
# Anisotropic friction: a contact that holds better one way than the other, such as ribbed rubber.
#
# (r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²,    v_T = -α (r_x/μ_x², r_y/μ_y²), α ≥ 0 on the limit


@check_init_call()
@check_method_calls
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
            object.__setattr__(self, name, check_number(f"AnisotropicCoulomb.{name}", value, above=0.0))
        object.__setattr__(self, "mu", max(self.mu_x, self.mu_y))  # which the other is measured by
        given = None if along is None else check_array("AnisotropicCoulomb.along", along, (3,), (2,))
        object.__setattr__(self, "along", None if given is None else tuple(given.tolist()))

    @property
    def scale(self) -> tuple[float, float]:
        """The coefficients over their common one, (μ_x, μ_y) / μ [-]."""
        return self.mu_x / self.mu, self.mu_y / self.mu

    @property
    def x_axis(self) -> Any:
        return self.along

    def with_mu(self, mu: float) -> FrictionLaw:
        """The same ellipse, grown or shrunk until its larger half-axis is `mu`."""
        mu, (x, y) = check_number("mu", mu, minimum=0.0), self.scale
        return AnisotropicCoulomb(mu * x, mu * y, self.along) if mu * min(x, y) > 0.0 else Coulomb(0.0)

    def __repr__(self) -> str:
        along = "" if self.along is None else f", along={self.along}"
        return f"AnisotropicCoulomb({self.mu_x!r}, {self.mu_y!r}{along})"


# ----------------------------------------------------------------
# No friction: the contact pushes along its normal only.


@check_init_call()
@check_method_calls
@dataclass(frozen=True, slots=True)
class Frictionless(FrictionLaw):
    """No tangential force, and therefore no tangential unknowns at all."""

    call: ClassVar[str] = "Frictionless()"
    mu = 0.0

    def with_mu(self, mu: float) -> Coulomb:
        return Coulomb(mu)

    def to_file(self) -> str:
        return "frictionless"


# ----------------------------------------------------------------
# Soft fingers: a patch that bears a moment about its normal besides the tangential force.
#
# |r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²,    (v_T, ω_n) along minus the ellipsoid's normal on the limit


@check_init_call()
@check_method_calls
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
            object.__setattr__(self, name, check_number(f"SoftFinger.{name}", getattr(self, name), minimum=0.0))
        if self.mu_torsion > 0.0 and not 0.0 < self.mu <= MAX_SOFT_FINGER_FRICTION:
            raise InputError(
                "SoftFinger.mu", f"a number > 0 and ≤ {MAX_SOFT_FINGER_FRICTION:g} beside mu_torsion > 0", self.mu
            )

    @property
    def lever(self) -> float:
        """The length of the torsional friction's lever, μ_τ/μ [m]."""
        return self.mu_torsion / self.mu if self.mu > 0.0 else 0.0

    @property
    def pad_torsion(self) -> float:
        return self.torsional_flexibility

    def with_mu(self, mu: float) -> SoftFinger:
        """The same lever with another coefficient."""
        mu = check_number("mu", mu, minimum=0.0)
        return SoftFinger(mu, mu * self.lever, self.torsional_flexibility)


# ----------------------------------------------------------------
# What users pass where a friction law is meant: the law, or a number for Coulomb's.


_MAX_COEFFICIENT = 10.0  # of a coefficient that is given as a number: soft rubber has 3, and sticky pads little more


def as_law(value: Any, argument: str = "friction", instead: str = "") -> FrictionLaw:
    """A law as it is; a number from 0 to 10 as `Coulomb` with that coefficient. instead : what else it may be, for the
    InputError that it raises.
    """
    if isinstance(value, FrictionLaw):
        return value
    try:
        mu = check_number(argument, value, minimum=0.0)
    except InputError:
        *calls, last = [law.call for law in _LAWS.values()]
        expected = f"a coefficient ≥ 0, {', '.join(calls)} or {last}{instead}"
        raise InputError(argument, expected, shorten_repr(value)) from None
    if mu > _MAX_COEFFICIENT:
        expected = f"a coefficient of at most {_MAX_COEFFICIENT:g}, or Coulomb({mu:g}) where that is meant"
        raise InputError(argument, expected, f"{mu:g} (per cent? {mu / 100:g})")
    return Coulomb(mu)


def laws_by_name(value: Any, names: Sequence[str], others: Sequence[FrictionLaw]) -> list[FrictionLaw]:
    """A law for each of `names`: one for all, or a mapping by fingertip in which those not named have that of `others`.

    Raises InputError, UnknownName.
    """
    if not isinstance(value, Mapping):
        return [as_law(value, instead=", or a mapping of fingertips to them")] * len(names)
    given = check_keys("friction", value, names, "a fingertip")
    return [
        as_law(given[name], f"friction[{name!r}]") if name in given else law
        for name, law in zip(names, others, strict=True)
    ]
