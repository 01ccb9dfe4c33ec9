"""What a friction law is: what a contact can transmit along its tangents and about its normal.

Each law is a ball in coordinates of its own. With r = S r̂ for a diagonal S, the `scale`, force and slip obey

    |r̂_t| ≤ μ r_N,    v̂_t = S v_t = -α r̂_t, α ≥ 0 on the limit

S keeps the power, r·v = r̂·v̂, and therefore maximum dissipation. A solver takes the ball itself, or a polygon or
polyhedron in its place (`sections`, `limit_set`). Source: Goyal, Ruina & Papadopoulos, Wear 143 (1991), limit surfaces;
Howe & Cutkosky, Int. J. Robotics Research 15 (1996), their ellipsoid.
"""

from __future__ import annotations

from typing import Any, ClassVar, Self

from handlcp.keywords import helped_methods

_LAWS: dict[tuple[str, str], type[FrictionLaw]] = {}


@helped_methods
class FrictionLaw:
    """Friction of a point contact that is alike in all directions, unless a subclass says otherwise.

    Subclasses have `mu`, the coefficient [-], and

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
        return _ALIKE

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
        return self.lever == 0.0 and self.scale == _ALIKE

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


_ALIKE = (1.0, 1.0)


def friction_laws() -> tuple[type[FrictionLaw], ...]:
    """All laws there are, in the order in which they were defined."""
    return tuple(_LAWS.values())


def law_words() -> str:
    """How to write each of them, for refusals."""
    calls = [law.call for law in _LAWS.values()]
    return f"{', '.join(calls[:-1])} or {calls[-1]}"
