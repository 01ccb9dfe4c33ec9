"""How tendons lie in a posture: their arms, and the posts that they rub on.

Arms of a tendon are given, or those of its route there. Of a route each round body that the cable lies on is a post,
whose wrap changes with the posture.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Ints, array, dimensions, number, per_name, read_only
from handlcp.errors import InputError
from handlcp.hand.elasticity.route import BoundRoute, Route, TendonPath

Arms = dict[str, dict[str, float]]
_FRICTION = "Tendons.friction"
_KEPT = 8  # postures, which steps ask for again
_grip = partial(number, minimum=0.0)


class Laid(NamedTuple):
    """arms (t, nv) : R [m/rad, m/m]. shift (t,) : l - R q, with l drawn in by the joints since their posture zero [m].
    of (m,), grips (m,), posts (m, nv) : as `Cables` has them.
    """

    arms: Array
    shift: Array
    of: Ints
    grips: Array
    posts: Array


class _Post(NamedTuple):
    tendon: int
    grip: float
    row: Array


@dataclass(frozen=True, eq=False)
class Lays:
    """Of t tendons over nv joints. arms (t, nv) : as they were given, 0 of those with routes. order : of each tendon,
    the joints in the order in which it passes them. grips : μθ of each of these by joint (nv,); μ of a route. routes :
    by number of the tendon.
    """

    arms: Array
    order: list[list[int]]
    grips: list[Array | float]
    routes: dict[int, Route]
    _lately: dict[bytes, Laid] = field(default_factory=dict, init=False, repr=False)

    def moved(self, point: Callable[[str, Array], Array]) -> Lays:
        """Along routes whose places are elsewhere on their links; point : as of `Site.moved`."""
        return replace(self, routes={i: route.moved(point) for i, route in self.routes.items()})

    def bound(self, kinematics: Any, names: Sequence[str]) -> dict[int, BoundRoute]:
        """The routes on the links of a hand. Raises UnknownName."""
        return {i: route.bound(kinematics, f"Tendons.moment_arms[{names[i]!r}]") for i, route in self.routes.items()}

    def at(self, bound: Mapping[int, BoundRoute], q: Array) -> Laid:
        """With joints at q (nv,). Raises InputError as `BoundRoute.at`."""
        if not bound:
            return self._at(bound, q)
        key = q.tobytes()
        if (found := self._lately.get(key)) is None:
            if len(self._lately) >= _KEPT:
                self._lately.clear()
            found = self._lately[key] = self._at(bound, q)
        return found

    def _at(self, bound: Mapping[int, BoundRoute], q: Array) -> Laid:
        R, shift, posts = self.arms.copy(), np.zeros(len(self.arms)), list[_Post]()
        for i, (order, grips) in enumerate(zip(self.order, self.grips, strict=True)):
            if i in bound:
                path = bound[i].at(q)
                R[i], shift[i] = path.arms, -path.length - path.arms @ q
                posts += _along(i, path, float(np.max(grips)))
            else:
                posts += _at_joints(i, self.arms[i], order, np.asarray(grips))
        return Laid(
            read_only(R), read_only(shift), np.array([p.tendon for p in posts], dtype=np.int64),
            read_only(np.array([p.grip for p in posts])),
            read_only(np.array([p.row for p in posts]).reshape(-1, R.shape[1])),
        )  # fmt: skip


def _at_joints(tendon: int, arms: Array, order: list[int], grips: Array) -> list[_Post]:
    """One post for each joint that has friction; beyond it the tendon moves the joints that it passes from there on."""
    every = np.arange(len(arms))
    return [
        _Post(tendon, float(grips[j]), np.where(np.isin(every, order[k:]), arms, 0.0))
        for k, j in enumerate(order)
        if grips[j] > 0.0
    ]


def _along(tendon: int, path: TendonPath, friction: float) -> list[_Post]:
    """One post for each round body of a route: all of them, so that there are as many in every posture."""
    if not friction:
        return []
    rows = np.cumsum([piece.arms for piece in path.pieces][::-1], axis=0)[::-1]  # of each piece and those after it
    lies = [k for k, piece in enumerate(path.pieces) if piece.turned > 0.0]
    posts = [_Post(tendon, friction * path.pieces[k].turned, rows[k]) for k in lies]
    free = len(path.angles) - len(posts)
    return [*posts, *[_Post(tendon, 0.0, np.zeros_like(path.arms))] * free]


def lays_of(
    names: Sequence[str], R: Array, arms: Mapping[str, Any] | None, friction: Any, joints: Sequence[str]
) -> Lays:
    """From what users pass. names (t,), R (t, nv) : 0 of those with routes. arms : by tendon, if they were given so.
    Raises InputError, UnknownName.
    """
    routes = {} if arms is None else {i: arms[name] for i, name in enumerate(names) if isinstance(arms[name], Route)}
    order = [np.flatnonzero(row).tolist() for row in R]
    if arms is not None:
        own = [arms[name] for name in names]
        order = [[] if isinstance(row, Route) else [joints.index(j) for j, x in row.items() if x] for row in own]
    if isinstance(friction, Mapping):
        given = per_name(_FRICTION, friction, names, "a tendon")
        rows = [given.get(name, 0.0) for name in names]
    elif dimensions(friction) == 0:
        rows = [friction] * len(names)
    else:
        matrix = array(_FRICTION, friction, R.shape, what="μθ ≥ 0, one row for each tendon,")
        rows = [dict(zip(joints, row.tolist(), strict=True)) for row in matrix]
    every = isinstance(friction, Mapping)
    grips = [
        _grips(f"{_FRICTION}[{name!r}]" if every else _FRICTION, row, joints, i in routes)
        for i, (name, row) in enumerate(zip(names, rows, strict=True))
    ]
    for i, route in routes.items():
        if np.max(grips[i]) > 0.0 and len({leg.divisor for leg in route.legs}) > 1:
            raise InputError(_FRICTION, f"0 for {names[i]!r}, which a pulley divides", f"{np.max(grips[i]):g}")
    return Lays(R, order, grips, routes)


def _grips(argument: str, value: Any, joints: Sequence[str], routed: bool) -> Array | float:
    """(nv,) μθ of one tendon at the joints; μ of one with a route."""
    if not isinstance(value, Mapping):
        one = _grip(argument, value)
        return one if routed else np.full(len(joints), one)
    if routed:
        raise InputError(argument, "one coefficient of friction, of all that the route goes around", repr(value)[:80])
    values = per_name(argument, value, joints, "a joint")
    return np.array([_grip(f"{argument}[{joint!r}]", values.get(joint, 0.0)) for joint in joints])
