"""Cables in space: through sites of the links and around cylinders and balls on them.

The moment arms of such a tendon change with the posture; `Tendons` takes those of one. `strung` has the formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.errors import InputError, UnknownName
from handlcp.hand.elasticity.places import CYLINDER, Around, Pulley, Site
from handlcp.hand.elasticity.strung import Posed, Strands, Strung, strung, turning
from handlcp.keywords import helped_init

_PLACES = "a sequence of Site, Around and Pulley, at least two of them"

# ---------------------------------------------------------------- The way of a tendon.


class Moving(Protocol):
    """What of `handlcp.hand.robot.kinematics.Kinematics` a route asks for."""

    model: Any
    nv: int
    coupling: Array | None

    def posture(self, argument: str, q: Any) -> Array:
        """(nv,) checked."""

    def frames_at(self, q: Array, frames: Sequence[int]) -> tuple[Array, Array]:
        """Placements (n, 4, 4) and the Jacobian (6, joints)."""


class _Leg(NamedTuple):
    """From one site to the next. first, last, body : numbers of places; body None: straight."""

    first: int
    last: int
    body: int | None
    divisor: float


@helped_init()
@dataclass(frozen=True, eq=False)
class Route:
    """The places that a tendon passes, in their order.

    places : Site, Around and Pulley. A pulley begins a new branch. Each branch begins and ends with a Site, and an
    Around stands between two of them. legs : the ways from one site to the next.
    Raises InputError.
    """

    places: Sequence[Site | Around | Pulley]
    legs: tuple[_Leg, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        places = self.places
        listed = isinstance(places, Sequence) and all(isinstance(p, (Site, Around, Pulley)) for p in places)
        if not listed or not places:
            raise InputError("Route.places", _PLACES, repr(places)[:80])
        object.__setattr__(self, "places", tuple(places))
        object.__setattr__(self, "legs", tuple(_legs(places)))

    def moved(self, point: Callable[[str, Array], Array]) -> Route:
        """Through the same places of links whose lengths are others; point : as of `Site.moved`."""
        return Route([place if isinstance(place, Pulley) else place.moved(point) for place in self.places])

    def bound(self, kinematics: Moving, argument: str = "route") -> BoundRoute:
        """The route on the links of a hand. argument : what errors call it. Raises UnknownName."""
        return BoundRoute(self, BoundRoutes((self,), kinematics, (argument,)))


# ---------------------------------------------------------------- In a posture.


class Piece(NamedTuple):
    """A straight piece of a tendon.

    start, end : (3,) [m], world axes. arms : (nv,) its share of the tendon's arms, the divisor included [m/rad].
    turned : [rad] by which the cable turns on a body before this piece; 0 where the piece begins at a site. leg : how
    many legs, from a site to the next, come before.
    """

    start: Array
    end: Array
    arms: Array
    turned: float
    leg: int


@dataclass(frozen=True, slots=True, eq=False)
class TendonPath:
    """A tendon in one posture.

    length : L [m]. arms : (nv,) -∂L/∂q [m/rad, m/m]; positive: pulling the tendon turns the joint to larger angles.
    angles : of each Around of the route, in their order, the angle over which the cable lies on it [rad]; 0: it does
    not touch. On a cylinder it is the angle about the axis times the cosine of the cable's slope along it, with which
    the capstan equation holds. pieces : the straight pieces in their order.
    """

    length: float
    arms: Array
    angles: Array
    pieces: tuple[Piece, ...]


@dataclass(frozen=True, eq=False)
class BoundRoutes:
    """The routes of t tendons on the links of one hand. arguments : what errors call them. frames : numbers of
    Pinocchio's frames of their links. Raises UnknownName.
    """

    routes: tuple[Route, ...]
    kinematics: Moving
    arguments: tuple[str, ...]
    frames: tuple[int, ...] = field(init=False, repr=False)
    strands: Strands = field(init=False, repr=False)

    def __post_init__(self) -> None:
        model, links = self.kinematics.model, list[str]()
        numbers = {f.name: i for i, f in enumerate(model.frames) if f.name != "universe"}
        for route, argument in zip(self.routes, self.arguments, strict=True):
            for i, place in enumerate(route.places):
                links.append("" if isinstance(place, Pulley) else place.link)
                if links[-1] and links[-1] not in numbers:
                    raise UnknownName(f"{argument}.places[{i}].link", "a link", [links[-1]], numbers)
        on = [numbers.get(link, 0) for link in links]  # 0: a pulley, which is on no link
        frames = sorted(set(on))
        support = np.zeros((len(on), model.nv))
        for row, frame in zip(support, on, strict=True):
            row[[model.joints[j].idx_v for j in model.supports[model.frames[frame].parentJoint] if j]] = 1.0
        object.__setattr__(self, "frames", tuple(frames))
        object.__setattr__(self, "strands", _strands(self.routes, [frames.index(frame) for frame in on], support))

    def posed(self, q: Array) -> Posed:
        """With joints at q (nv,)."""
        placements, J = self.kinematics.frames_at(q, self.frames)
        return Posed(placements, J.T.copy())

    def at(self, q: Array) -> tuple[Strung, Posed]:
        """Lengths, arms and wraps with joints at q (nv,), over the independent joints, and that posture. Raises
        InputError where a site is inside a body that the cable goes round.
        """
        posed = self.posed(q)
        t, legs, joints = len(self.routes), len(self.strands.divisors), len(posed.columns)
        out = Strung(
            np.zeros(t), np.zeros((t, joints)), np.zeros(legs), np.zeros((legs, 2, joints)), np.zeros((legs, joints)),
            np.zeros((legs, 4, 3)), np.zeros((legs, 3)),
        )  # fmt: skip
        wrong, depth = strung(self.strands, posed, out)
        if wrong >= 0:
            raise self._inside(int(wrong), float(depth), q)
        C = self.kinematics.coupling
        if C is not None:
            out = out._replace(arms=out.arms @ C, pieces=out.pieces @ C, beyond=out.beyond @ C)
        return out, posed

    def turning(self, posed: Posed, which: Ints, tension: Array) -> Array:
        """(nv, nv) Σ T ∂arms/∂q [N·m/rad], symmetric; which (t,) : numbers of the tendons among their tensions T."""
        H, C = np.zeros((len(posed.columns),) * 2), self.kinematics.coupling
        turning(self.strands, posed, tension[which], H)
        return H if C is None else np.asarray(C.T @ H @ C)

    def _inside(self, wrong: int, depth: float, q: Array) -> InputError:
        tendon, first, last, body = self.strands.legs[wrong // 2].tolist()
        begins = sum([len(route.places) for route in self.routes[:tendon]])
        around = self.routes[tendon].places[body - begins]
        assert isinstance(around, Around)
        site = (last if wrong % 2 else first) - begins
        expected = f"a site outside the {around.shape} that it leads to, places[{body - begins}] on {around.link!r}"
        came = f"one {1e3 * depth:.3g} mm inside it at q = {np.round(q, 4).tolist()}"
        return InputError(f"{self.arguments[tendon]}.places[{site}]", expected, came)


@dataclass(frozen=True, eq=False)
class BoundRoute:
    """A route on the links of one hand, alone. routes : it."""

    route: Route
    routes: BoundRoutes

    def at(self, q: Any) -> TendonPath:
        """Length, arms and wraps at q (nv,) [rad, m], or a mapping of joint names. Raises InputError: also where a site
        is inside a body that the cable goes round.
        """
        (found, _), pieces = self.routes.at(self._posture(q)), list[Piece]()
        for n, (turned, ends, arms) in enumerate(zip(found.turned.tolist(), found.ends, found.pieces, strict=True)):
            pieces.append(Piece(ends[0], ends[1], read_only(arms[0]), 0.0, n))
            if turned > 0.0:
                pieces.append(Piece(ends[2], ends[3], read_only(arms[1]), turned, n))
        wraps = [leg.body is not None for leg in self.route.legs]
        return TendonPath(
            float(found.lengths[0]), read_only(found.arms[0]), read_only(found.turned[wraps]), tuple(pieces)
        )

    def slope(self, q: Any) -> Array:
        """(nv, nv) ∂arms/∂q [m/rad²], symmetric.

        It is -∂²L/∂q², with which the tension T of a tendon adds -T slope to the joints' stiffness. At a posture where
        a wrap comes or goes it is the mean over both sides.
        """
        posed, first = self.routes.posed(self._posture(q)), np.zeros(1, dtype=np.int64)
        return read_only(self.routes.turning(posed, first, np.ones(1)))

    def _posture(self, q: Any) -> Array:
        return self.routes.kinematics.posture("q", q)


def _strands(routes: Sequence[Route], at: list[int], support: Array) -> Strands:
    """As compiled code reads them. at (p,), support (p, joints) : of all places."""
    n, legs = len(at), list[tuple[int, ...]]()
    s = Strands(
        np.array(at, dtype=np.int64), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), support,
        np.zeros((0, 4), dtype=np.int64), np.array([leg.divisor for route in routes for leg in route.legs]),
    )  # fmt: skip
    begins = 0
    for t, route in enumerate(routes):
        for i, place in enumerate(route.places, begins):
            if isinstance(place, Site):
                s.points[i] = place.point
            elif isinstance(place, Around):
                s.points[i], axis = place.placement
                s.axes[i], s.radii[i] = axis if place.shape == CYLINDER else 0.0, place.radius
                s.sides[i] = s.points[i] if place.side is None else place.side
        for leg in route.legs:
            body = -1 if leg.body is None else leg.body + begins
            legs.append((t, leg.first + begins, leg.last + begins, body))
        begins += len(route.places)
    return s._replace(legs=np.array(legs, dtype=np.int64))


# ---------------------------------------------------------------- Checks.


def _legs(places: Sequence[Site | Around | Pulley]) -> list[_Leg]:
    """From site to site. Raises InputError."""
    legs, divisor, last = list[_Leg](), 1.0, -1  # last: the site before in the same branch
    for i, place in enumerate(places):
        _check_neighbours(i, places)
        if isinstance(place, Pulley):
            divisor, last = place.divisor, -1
        elif isinstance(place, Site):
            if last >= 0:
                legs.append(_Leg(last, i, i - 1 if last < i - 1 else None, divisor))
            last = i
    return legs


def _check_neighbours(i: int, places: Sequence[Site | Around | Pulley]) -> None:
    before, after = (type(places[j]) if 0 <= j < len(places) else None for j in (i - 1, i + 1))
    came = " and ".join(f"{kind.__name__ if kind else 'nothing'} {where} it"
                        for kind, where in ((before, "before"), (after, "after")))  # fmt: skip
    if isinstance(places[i], Around) and not before is after is Site:
        raise InputError(f"Route.places[{i}]", "an Around between two Sites", came)
    if isinstance(places[i], Pulley) and after is not Site:
        raise InputError(f"Route.places[{i}]", "a Pulley that a Site follows", came)
    if isinstance(places[i], Site) and before in (None, Pulley) and after in (None, Pulley):
        raise InputError(f"Route.places[{i}]", "a branch of at least two Sites", f"one Site alone, {came}")
