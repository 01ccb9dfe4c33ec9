"""`CableRouting`: how tendons lie in a posture: their arms, and the posts that they rub on.

Arms of a tendon are given, or those of its route there. Of a route each round body that the cable lies on is a post,
whose wrap changes with the posture.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from handlcp.actuation.route import Around, BoundRoutes, Pulley, Route
from handlcp.check import Array, Bools, Ints, check_array, check_keys, check_number, count_dimensions, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.mechanism import Cables
from handlcp.kinematics.cable_kinematics import RoutedTendons, TendonArms, tendon_arm_rates

Arms = dict[str, dict[str, float]]
_FRICTION_ARGUMENT = "Tendons.friction"
_read_friction = partial(check_number, minimum=0.0)


class _Posts(NamedTuple):
    """m posts, those of a tendon in their order. post_tendon (m,), arms_beyond (m, nv) : as `Cables` has them, 0 of
    routes. friction (m,) : μθ; of a route μ. legs (m,) : number of the leg that goes round it, among those of all
    routes; -1: of a tendon without.
    """

    post_tendon: Ints
    friction: Array
    arms_beyond: Array
    legs: Ints


@dataclass(frozen=True, eq=False)
class CableRouting:
    """Of t tendons over nv joints. arms (t, nv) : as they were given, 0 of those with routes. order : of each tendon,
    the joints in the order in which it passes them. friction : μθ at each joint (nv,); of a route μ, which `lay_out`
    multiplies by its wrap angle. routes : by number of the tendon.
    """

    arms: Array
    order: list[list[int]]
    friction: list[Array | float]
    routes: dict[int, Route]

    @cached_property
    def posts(self) -> _Posts:
        """One for each joint with friction and each round body of a route with friction: as many in every posture."""
        nv, none, leg = self.arms.shape[1], np.zeros(self.arms.shape[1]), 0
        posts = list[tuple[int, float, Array, int]]()
        for i, (order, friction) in enumerate(zip(self.order, self.friction, strict=True)):
            if i in self.routes:
                legs, most = self.routes[i].legs, float(np.max(friction))
                around = [leg + k for k, one in enumerate(legs) if one.body is not None and most > 0.0]
                posts += [(i, most, none, k) for k in around]
                leg += len(legs)
            else:
                own = np.asarray(friction)  # beyond a post the tendon moves the joints that it passes from there on
                beyond = [np.where(np.isin(np.arange(nv), order[k:]), self.arms[i], 0.0) for k in range(len(order))]
                posts += [(i, float(own[j]), beyond[k], -1) for k, j in enumerate(order) if own[j] > 0.0]
        return _Posts(
            np.array([p[0] for p in posts], dtype=np.int64),
            read_only(np.array([p[1] for p in posts])),
            read_only(np.array([p[2] for p in posts]).reshape(-1, nv)),
            np.array([p[3] for p in posts], dtype=np.int64),
        )

    def remap_points(self, point: Callable[[str, Array], Array]) -> CableRouting:
        """Along routes whose places are elsewhere on their links; point : as of `Site.moved`."""
        return replace(self, routes={i: route.moved(point) for i, route in self.routes.items()})

    def bind(self, bound: BoundRoutes, given: Cables, elastic: Bools) -> RoutedTendons:
        """As compiled code reads it, with its routes on the links of a hand; arguments as in `lay_out`."""
        posts = TendonArms(given.arms, given.shift, given.wrap_friction, given.arms_beyond)
        routed = np.array([*self.routes], dtype=np.int64)
        return bound.tendons._replace(numbers=routed, elastic=elastic, given=posts, post_legs=self.posts.legs)

    def lay_out(self, bound: BoundRoutes | None, q: Array, given: Cables, elastic: Bools) -> tuple[Cables, Array]:
        """Cables with joints at q (nv,), from those with the arms that were given, and arms (t, nv) of all joints,
        rigid ones included. elastic (nv,) : joints that are not rigid. Raises as `BoundRoutes.lay_tendons`.
        """
        if bound is None:
            return given, self.arms
        tendons = self.bind(bound, given, elastic)
        laid, paths, posed = bound.lay_tendons(tendons, q)
        arms, wrapping = (
            self.arms.copy(),
            [leg.body is not None for route in self.routes.values() for leg in route.legs],
        )
        arms[tendons.numbers] = paths.arms
        cables = given._replace(
            arms=read_only(laid.arms),
            shift=read_only(laid.shift),
            wrap_friction=read_only(laid.wrap_friction),
            arms_beyond=read_only(laid.arms_beyond),
            arm_rates=partial(tendon_arm_rates, tendons, posed),
            wrap_sides=read_only(paths.wrap_sides[wrapping]),
        )
        return cables, read_only(arms)

    def describe_bodies(self, names: Sequence[str]) -> tuple[str, ...]:
        """Round bodies that routes pass, in words; names (t,)."""
        places = [
            (names[i], p, leg.body)
            for i, route in self.routes.items()
            for leg in route.legs
            for p in [route.places[leg.body or 0]]
            if isinstance(p, Around)
        ]
        return tuple([f"{name!r} the {place.shape} at places[{k}], on {place.link}" for name, place, k in places])


def read_cable_routing(
    names: Sequence[str], R: Array, arms: Mapping[str, Any] | None, friction: Any, joints: Sequence[str]
) -> CableRouting:
    """From what users pass; R (t, nv) : 0 of routes, arms : by tendon or None. Raises InputError, UnknownName."""
    routes = {} if arms is None else {i: arms[name] for i, name in enumerate(names) if isinstance(arms[name], Route)}
    order = [np.flatnonzero(row).tolist() for row in R]
    if arms is not None:
        own = [arms[name] for name in names]
        order = [[] if isinstance(row, Route) else [joints.index(j) for j, x in row.items() if x] for row in own]
    if isinstance(friction, Mapping):
        given = check_keys(_FRICTION_ARGUMENT, friction, names, "a tendon")
        rows = [given.get(name, 0.0) for name in names]
    elif count_dimensions(friction) == 0:
        rows = [friction] * len(names)
    else:
        matrix = check_array(_FRICTION_ARGUMENT, friction, R.shape, what="μθ ≥ 0, one row for each tendon,")
        rows = [dict(zip(joints, row.tolist(), strict=True)) for row in matrix]
    every = isinstance(friction, Mapping)
    own_friction = [
        _read_tendon_friction(
            f"{_FRICTION_ARGUMENT}[{name!r}]" if every else _FRICTION_ARGUMENT, row, joints, i in routes
        )
        for i, (name, row) in enumerate(zip(names, rows, strict=True))
    ]
    for i, route in routes.items():
        if np.max(own_friction[i]) > 0.0 and any(isinstance(place, Pulley) for place in route.places[1:]):
            raise InputError(
                _FRICTION_ARGUMENT, f"0 for {names[i]!r}, which a pulley divides", f"{np.max(own_friction[i]):g}"
            )
    return CableRouting(R, order, own_friction, routes)


def _read_tendon_friction(argument: str, value: Any, joints: Sequence[str], routed: bool) -> Array | float:
    """(nv,) μθ of one tendon at the joints; μ of one with a route."""
    if not isinstance(value, Mapping):
        one = _read_friction(argument, value)
        return one if routed else np.full(len(joints), one)
    if routed:
        raise InputError(argument, "one coefficient of friction, of all that the route goes around", repr(value)[:80])
    values = check_keys(argument, value, joints, "a joint")
    return np.array([_read_friction(f"{argument}[{joint!r}]", values.get(joint, 0.0)) for joint in joints])
