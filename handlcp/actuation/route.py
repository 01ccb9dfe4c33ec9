"""`Route`: the places that a cable passes, which are sites of links, round bodies on them, and pulleys."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
import pinocchio as pin

from handlcp.check import (
    Array,
    check_array,
    check_init_call,
    check_number,
    check_sequence,
    check_unit_vector,
    count_dimensions,
    read_only,
)
from handlcp.errors import InputError, UnknownName, Unsupported, shorten_repr
from handlcp.kinematics.cable_kinematics import (
    SURFACE_ROUNDING,
    CablePaths,
    CablePosture,
    PackedRoutes,
    RoutedTendons,
    TendonArms,
    lay_tendons,
    tendon_arm_rates,
)

CYLINDER, SPHERE = "cylinder", "sphere"

_IN_LINK = "metres in the link's frame"
_PLACEMENT_EXPECTED = (
    "a pin.SE3 whose z is the axis, a point and a unit axis ((3,), (3,)), or of a sphere its centre (3,)"
)


@check_init_call("link")
@dataclass(frozen=True, eq=False)
class Site:
    """A hole that the cable runs through, or an end that is knotted. link : that carries it. point : (3,) in the link's
    frame [m]. Raises InputError.
    """

    link: str
    point: Any

    def __post_init__(self) -> None:
        check_link_name("Site.link", self.link)
        object.__setattr__(self, "point", check_array("Site.point", self.point, (3,), what=_IN_LINK))

    def moved(self, point: Callable[[str, Array], Array]) -> Site:
        """Where the link's lengths are others; point : of the name of a link and a point of it (3,), where that is."""
        return replace(self, point=point(self.link, self.point))


@check_init_call()
@dataclass(frozen=True, eq=False)
class Pulley:
    """A loose pulley, from which a branch of its own begins. divisor : > 0, of the branch's length and tension: 2 for
    each of two branches that one cable pulls, a differential. Raises InputError.
    """

    divisor: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "divisor", check_number("Pulley.divisor", self.divisor, above=0.0))


@check_init_call()
@dataclass(frozen=True, eq=False)
class Around:
    """A round body that the cable lies on where it is in the way, between two sites outside it. No friction.

    link : that carries it. placement : in the link's frame [m], a pin.SE3 whose z is the axis, or a point and the axis,
    or the centre of a sphere; kept as (centre (3,), axis (3,)). radius : [m]. shape : "cylinder", without ends, or
    "sphere". side : (3,) a point in the link's frame [m], an MJCF file's side site: the cable passes the centre on this
    side, and goes round the body also where a straight line would miss it on the other. Its direction counts, seen
    along a cylinder's axis or in the plane of the cable and a sphere's centre. None: it goes round where that is
    shorter. Pass the side of a body that the cable lies on in all postures that matter.

    Where the body is not in its way the cable is straight, and leaves it. It changes to the other side where both ways
    are as long, without a side, or where a site passes behind the body, seen from the side. No real cable does: one
    posture has the way that it has, but a loading that is followed is given up there, so that `check()` says UNDECIDED.

    Raises InputError, in a posture also for a site inside the body; Unsupported for a side closer to the centre than
    the radius, with which an MJCF file asks for a cable through the inside.
    """

    link: str
    placement: Any
    radius: float
    shape: str = CYLINDER
    side: Any = None

    def __post_init__(self) -> None:
        check_link_name("Around.link", self.link)
        if self.shape not in (CYLINDER, SPHERE):
            raise InputError("Around.shape", f'"{CYLINDER}" or "{SPHERE}"', repr(self.shape))
        object.__setattr__(self, "radius", check_number("Around.radius", self.radius, above=0.0))
        object.__setattr__(self, "placement", _read_placement(self.placement, self.shape))
        if self.side is not None:
            object.__setattr__(self, "side", check_array("Around.side", self.side, (3,), what=_IN_LINK))
            centre, axis = self.placement
            away = self.side - centre
            if np.linalg.norm(away) < (1.0 - SURFACE_ROUNDING) * self.radius:
                raise Unsupported(
                    f"Around.side: {self.side.tolist()} is inside the {self.shape}, which asks for a cable through the "
                    "inside; here cables go round the outside: move the side out"
                )
            if self.shape == CYLINDER and np.linalg.norm(np.cross(axis, away)) <= SURFACE_ROUNDING * self.radius:
                came = f"{self.side.tolist()} on it"
                raise InputError("Around.side", "a point beside the axis of the cylinder", came)

    def moved(self, point: Callable[[str, Array], Array]) -> Around:
        """The same body where the link's lengths are others; point : as of `Site.moved`."""
        centre, axis = self.placement
        there = point(self.link, centre)
        side = None if self.side is None else self.side + (there - centre)
        return replace(self, placement=(there, axis), side=side)


# ---------------------------------------------------------------- Checks.


def check_link_name(argument: str, value: Any) -> str:
    """The name of a link, whichever: a route is bound to a hand later. Raises InputError."""
    if not isinstance(value, str) or not value:
        raise InputError(argument, "the name of a link", repr(value))
    return value


def _read_placement(value: Any, shape: str) -> tuple[Array, Array]:
    """Read the centre (3,) [m] and the axis (3,) of a round body, in its link's frame. Raises InputError."""
    name = "Around.placement"
    if isinstance(value, pin.SE3):
        return check_array(name, value.translation, (3,)), check_unit_vector(name, value.rotation[:, 2], (3,))
    if shape == SPHERE and count_dimensions(value) == 1:
        return check_array(name, value, (3,), what=_IN_LINK), read_only(np.array([0.0, 0.0, 1.0]))
    value = check_sequence(name, value, _PLACEMENT_EXPECTED)
    if len(value) != 2:
        raise InputError(name, _PLACEMENT_EXPECTED, shorten_repr(value))
    centre = check_array(f"{name}[0]", value[0], (3,), what=_IN_LINK)
    return centre, check_unit_vector(f"{name}[1]", value[1], (3,))


# ----------------------------------------------------------------
# Cables in space: through sites of the links and around cylinders and balls on them.
#
# The moment arms of such a tendon change with the posture; `Tendons` takes those of one. `cable_kinematics.py` has the
# formulas.


_PLACES_EXPECTED = "a sequence of Site, Around and Pulley, at least two of them"

# ---------------------------------------------------------------- The way of a tendon.


class RouteKinematics(Protocol):
    """What of `handlcp.robot.kinematics.Kinematics` a route asks for."""

    model: Any
    nv: int
    coupling: Array | None

    def read_posture(self, argument: str, q: Any) -> Array:
        """Check a posture and return it as an array (nv,) of the independent joints [rad, m]."""

    def frames_at(self, q: Array, frames: Sequence[int]) -> tuple[Array, Array]:
        """Placements (n, 4, 4) and the Jacobian (6, joints)."""


class _Leg(NamedTuple):
    """From one site to the next. first, last, body : numbers of places; body None: straight."""

    first: int
    last: int
    body: int | None
    divisor: float


@check_init_call()
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
            raise InputError("Route.places", _PLACES_EXPECTED, repr(places)[:80])
        object.__setattr__(self, "places", tuple(places))
        object.__setattr__(self, "legs", tuple(_split_legs(places)))

    def moved(self, point: Callable[[str, Array], Array]) -> Route:
        """Through the same places of links whose lengths are others; point : as of `Site.moved`."""
        return Route([place if isinstance(place, Pulley) else place.moved(point) for place in self.places])

    def bound(self, kinematics: RouteKinematics, argument: str = "route") -> BoundRoute:
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


class BoundRoutes:
    """The routes of t tendons on the links of one hand. arguments : what errors call them. Raises UnknownName."""

    def __init__(self, routes: tuple[Route, ...], kinematics: RouteKinematics, arguments: tuple[str, ...]) -> None:
        self.routes, self.kinematics, self.arguments = routes, kinematics, arguments
        model, links = kinematics.model, list[str]()
        numbers = {f.name: i for i, f in enumerate(model.frames) if f.name != "universe"}
        for route, argument in zip(routes, arguments, strict=True):
            for i, place in enumerate(route.places):
                links.append("" if isinstance(place, Pulley) else place.link)
                if links[-1] and links[-1] not in numbers:
                    raise UnknownName(f"{argument}.places[{i}].link", "a link", [links[-1]], numbers)
        on = [numbers.get(link, 0) for link in links]  # 0: a pulley, which is on no link
        frames = sorted(set(on))
        support = np.zeros((len(on), model.nv))
        for row, frame in zip(support, on, strict=True):
            row[[model.joints[j].idx_v for j in model.supports[model.frames[frame].parentJoint] if j]] = 1.0
        self.frames = tuple(frames)  # of Pinocchio, of the links
        C, count = kinematics.coupling, len(routes)
        nv, none = model.nv if C is None else C.shape[1], np.zeros(0)
        self.tendons = RoutedTendons(
            _pack_routes(routes, [frames.index(frame) for frame in on], support),
            np.arange(count),
            np.zeros((0, 0)) if C is None else np.ascontiguousarray(C),
            np.ones(nv, dtype=bool),
            TendonArms(np.zeros((count, nv)), np.zeros(count), none, np.zeros((0, nv))),
            np.zeros(0, dtype=np.int64),
        )

    def pose_links(self, q: Array) -> CablePosture:
        """With joints at q (nv,)."""
        placements, J = self.kinematics.frames_at(q, self.frames)
        return CablePosture(placements, J.T.copy())

    def lay_tendons(self, tendons: RoutedTendons, q: Array) -> tuple[TendonArms, CablePaths, CablePosture]:
        """Tendons of which some run along these routes, with joints at q (nv,): arms, paths, and that posture. Raises
        InputError where a site is inside a body that the cable goes round.
        """
        posed = self.pose_links(q)
        laid, paths, wrong, depth = lay_tendons(tendons, posed, q)
        if wrong >= 0:
            raise self._inside_error(int(wrong), float(depth), q)
        return laid, paths, posed

    def _inside_error(self, wrong: int, depth: float, q: Array) -> InputError:
        tendon, first, last, body = self.tendons.routes.legs[wrong // 2].tolist()
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
        posture, pieces = self.routes.kinematics.read_posture("q", q), list[Piece]()
        _, found, _ = self.routes.lay_tendons(self.routes.tendons, posture)
        legs = zip(found.wrap_angles.tolist(), found.piece_ends, found.piece_arms, strict=True)
        for n, (turned, ends, arms) in enumerate(legs):
            pieces.append(Piece(ends[0], ends[1], read_only(arms[0]), 0.0, n))
            if turned > 0.0:
                pieces.append(Piece(ends[2], ends[3], read_only(arms[1]), turned, n))
        wraps = [leg.body is not None for leg in self.route.legs]
        angles = read_only(found.wrap_angles[wraps])
        return TendonPath(float(found.lengths[0]), read_only(found.arms[0]), angles, tuple(pieces))

    def slope(self, q: Any) -> Array:
        """How fast the moment arms change with the joints, ∂arms/∂q (nv, nv) [m/rad²], symmetric.

        It is -∂²L/∂q², with which the tension T of a tendon adds -T slope to the joints' stiffness. At a posture where
        a wrap comes or goes it is the mean over both sides.
        """
        posed = self.routes.pose_links(self.routes.kinematics.read_posture("q", q))
        return read_only(tendon_arm_rates(self.routes.tendons, posed)[0])


def _pack_routes(routes: Sequence[Route], at: list[int], support: Array) -> PackedRoutes:
    """As compiled code reads them. at (p,), support (p, joints) : of all places."""
    n, legs = len(at), list[tuple[int, ...]]()
    points, axes, sides = np.zeros((3, n, 3))
    divisors = np.array([leg.divisor for route in routes for leg in route.legs])
    none = np.zeros((0, 4), dtype=np.int64)
    s = PackedRoutes(np.array(at, dtype=np.int64), points, axes, sides, np.zeros(n), support, none, divisors)
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


def _split_legs(places: Sequence[Site | Around | Pulley]) -> list[_Leg]:
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
    names = (kind.__name__ if kind else "nothing" for kind in (before, after))
    came = "{} before it and {} after it".format(*names)
    if isinstance(places[i], Around) and not before is after is Site:
        raise InputError(f"Route.places[{i}]", "an Around between two Sites", came)
    if isinstance(places[i], Pulley) and after is not Site:
        raise InputError(f"Route.places[{i}]", "a Pulley that a Site follows", came)
    if isinstance(places[i], Site) and before in (None, Pulley) and after in (None, Pulley):
        raise InputError(f"Route.places[{i}]", "a branch of at least two Sites", f"one Site alone, {came}")
