"""Cables in space: through sites of the links and around cylinders and balls on them.

The moment arms of such a tendon change with the posture; `Tendons` takes those of one.

L(q) = Σ_branches (1/d) Σ (straight pieces + arcs),    arms = -∂L/∂q

A taut path is the shortest of its kind, so where it meets and leaves a round body changes its length in second order
only: for ∂L/∂q these points move with the body's link. Then arcs keep their length, and each straight piece from a to b
along the unit vector u lengthens by u · (ṗ_b - ṗ_a). A joint with the world velocity field v + ω × p that moves b and
not a brings

∂|b - a|/∂q = u · v + (p × u) · ω,    p any point of the line

with the other sign where it moves a and not b, and nothing where it moves both or none.
Source: Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation (1994), section 6.4, for arms as
derivatives of the length; MuJoCo's XML reference, tendon/spatial, for sites, side sites and pulleys.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError, UnknownName
from handlcp.hand.elasticity.wrapping import ROUNDING, Around, RoundBody, cross, link_name

_PLACES = "a sequence of Site, Around and Pulley, at least two of them"

# ---------------------------------------------------------------- What a tendon passes.


@dataclass(frozen=True, eq=False)
class Site:
    """A hole that the cable runs through, or an end that is knotted. link : that carries it. point : (3,) in the link's
    frame [m]. Raises InputError.
    """

    link: str
    point: Any

    def __post_init__(self) -> None:
        link_name("Site.link", self.link)
        object.__setattr__(self, "point", array("Site.point", self.point, (3,), what="metres in the link's frame"))

    def moved(self, point: Callable[[str, Array], Array]) -> Site:
        """Where the link's lengths are others; point : of the name of a link and a point of it (3,), where that is."""
        return replace(self, point=point(self.link, self.point))


@dataclass(frozen=True, eq=False)
class Pulley:
    """A loose pulley, from which a branch of its own begins. divisor : > 0, of the branch's length and tension: 2 for
    each of two branches that one cable pulls, a differential. Raises InputError.
    """

    divisor: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "divisor", number("Pulley.divisor", self.divisor, above=0.0))


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

    @property
    def arounds(self) -> tuple[int, ...]:
        """The numbers of the round bodies among the places."""
        return tuple(i for i, place in enumerate(self.places) if isinstance(place, Around))

    def bound(self, kinematics: Moving, argument: str = "route") -> BoundRoute:
        """The route on the links of a hand. argument : what errors call it. Raises UnknownName."""
        numbers = {f.name: i for i, f in enumerate(kinematics.model.frames) if f.name != "universe"}
        frames = list[int]()
        for i, place in enumerate(self.places):
            link = "" if isinstance(place, Pulley) else place.link
            if link and link not in numbers:
                raise UnknownName(f"{argument}.places[{i}].link", "a link", [link], numbers)
            frames.append(numbers.get(link, 0))
        return BoundRoute(self, kinematics, tuple(frames), argument)


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
class BoundRoute:
    """A route on the links of one hand.

    frames : a number of Pinocchio's frames for each place; 0 for a pulley, which is on no link. argument : what errors
    call the route. support : (places, joints) 1 where a joint moves a place.
    """

    route: Route
    kinematics: Moving
    frames: tuple[int, ...]
    argument: str
    support: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        model = self.kinematics.model
        support = np.zeros((len(self.frames), model.nv))
        for row, frame in zip(support, self.frames, strict=True):
            row[[model.joints[j].idx_v for j in model.supports[model.frames[frame].parentJoint] if j]] = 1.0
        object.__setattr__(self, "support", read_only(support))

    def at(self, q: Any) -> TendonPath:
        """Length, arms and wraps at q (nv,) [rad, m], or a mapping of joint names. Raises InputError: also where a site
        is inside a body that the cable goes round.
        """
        q = self.kinematics.posture("q", q)
        placements, J = self.kinematics.frames_at(q, self.frames)
        length, angles, pieces = 0.0, dict.fromkeys(self.route.arounds, 0.0), list[Piece]()
        for n, leg in enumerate(self.route.legs):
            whole, turned, more = self._leg(n, q, placements, J)
            length += whole / leg.divisor
            pieces += more
            if leg.body is not None:
                angles[leg.body] = turned
        arms = np.sum([piece.arms for piece in pieces], axis=0)
        return TendonPath(length, read_only(arms), read_only(np.array([*angles.values()])), tuple(pieces))

    def slope(self, q: Any, step: float = 1e-6) -> Array:
        """(nv, nv) ∂arms/∂q [m/rad²], symmetric, by central differences of the arms over ±`step` [rad, m].

        It is -∂²L/∂q², with which the tension T of a tendon adds -T slope to the joints' stiffness. At a posture where
        a wrap comes or goes it is the mean over both sides.
        """
        q = self.kinematics.posture("q", q)
        rows = [(self.at(q + d).arms - self.at(q - d).arms) / (2 * step) for d in step * np.eye(len(q))]
        H = np.array(rows).reshape(len(q), len(q))
        return read_only((H + H.T) / 2)

    def _leg(self, n: int, q: Array, placements: Array, J: Array) -> tuple[float, float, list[Piece]]:
        """Length [m] of a leg from site to site, the angle on the body between [rad], and the straight pieces."""
        leg = self.route.legs[n]
        a, b = self._point(leg.first, placements), self._point(leg.last, placements)
        bend = None if leg.body is None else self._body(leg, q, placements, a, b).bend(a, b)
        if leg.body is None or bend is None:
            length = float(np.linalg.norm(b - a))
            along = (b - a) / length if length > 0.0 else np.zeros(3)
            return length, 0.0, [Piece(a, b, self._arms(leg.first, leg.last, a, along / leg.divisor, J), 0.0, n)]
        before = self._arms(leg.first, leg.body, a, bend.before / leg.divisor, J)
        after = self._arms(leg.body, leg.last, b, bend.after / leg.divisor, J)
        pieces = [Piece(a, bend.start, before, 0.0, n), Piece(bend.end, b, after, bend.angle, n)]
        return bend.length, bend.angle, pieces

    def _point(self, i: int, placements: Array) -> Array:
        """(3,) of a site, world axes."""
        site = self.route.places[i]
        assert isinstance(site, Site)
        return np.asarray(placements[i, :3, :3] @ site.point + placements[i, :3, 3])

    def _body(self, leg: _Leg, q: Array, placements: Array, a: Array, b: Array) -> RoundBody:
        """What the cable goes round between a and b (3,), world axes. Raises InputError for a site inside."""
        assert leg.body is not None
        around = self.route.places[leg.body]
        assert isinstance(around, Around)
        body = around.in_frame(placements[leg.body])
        for site, point in ((leg.first, a), (leg.last, b)):
            depth = -body.outside(point)
            if depth > ROUNDING * around.radius:
                expected = f"a site outside the {around.shape} that it leads to, places[{leg.body}] on {around.link!r}"
                came = f"one {1e3 * depth:.3g} mm inside it at q = {np.round(q, 4).tolist()}"
                raise InputError(f"{self.argument}.places[{site}]", expected, came)
        return body

    def _arms(self, first: int, last: int, point: Array, along: Array, J: Array) -> Array:
        """(nv,) of a straight piece from one place to another, through a point (3,), along (3,) unit / divisor."""
        wrench = np.concatenate([along, cross(point, along)])
        arms = (self.support[first] - self.support[last]) * (wrench @ J)
        C = self.kinematics.coupling
        return read_only(arms if C is None else arms @ C)


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
