"""The places that a cable passes: sites of links, round bodies on them, and pulleys."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, dimensions, number, read_only, several, unit
from handlcp.errors import InputError, Unsupported, shown
from handlcp.hand.elasticity.wrapping import ROUNDING
from handlcp.keywords import helped_init

CYLINDER, SPHERE = "cylinder", "sphere"

_PLACEMENTS = "a pin.SE3 whose z is the axis, a point and a unit axis ((3,), (3,)), or of a sphere its centre (3,)"


@helped_init("link")
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


@helped_init()
@dataclass(frozen=True, eq=False)
class Pulley:
    """A loose pulley, from which a branch of its own begins. divisor : > 0, of the branch's length and tension: 2 for
    each of two branches that one cable pulls, a differential. Raises InputError.
    """

    divisor: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "divisor", number("Pulley.divisor", self.divisor, above=0.0))


@helped_init()
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
        link_name("Around.link", self.link)
        if self.shape not in (CYLINDER, SPHERE):
            raise InputError("Around.shape", f'"{CYLINDER}" or "{SPHERE}"', repr(self.shape))
        object.__setattr__(self, "radius", number("Around.radius", self.radius, above=0.0))
        object.__setattr__(self, "placement", _placed(self.placement, self.shape))
        if self.side is not None:
            object.__setattr__(self, "side", array("Around.side", self.side, (3,), what="metres in the link's frame"))
            self._check_side()

    def moved(self, point: Callable[[str, Array], Array]) -> Around:
        """The same body where the link's lengths are others; point : as of `Site.moved`."""
        centre, axis = self.placement
        there = point(self.link, centre)
        side = None if self.side is None else self.side + (there - centre)
        return replace(self, placement=(there, axis), side=side)

    def _check_side(self) -> None:
        centre, axis = self.placement
        away = self.side - centre
        if np.linalg.norm(away) < (1.0 - ROUNDING) * self.radius:
            raise Unsupported(
                f"Around.side: {self.side.tolist()} is inside the {self.shape}, which asks for a cable through the "
                "inside; here cables go round the outside: move the side out"
            )
        if self.shape == CYLINDER and np.linalg.norm(np.cross(axis, away)) <= ROUNDING * self.radius:
            raise InputError("Around.side", "a point beside the axis of the cylinder", f"{self.side.tolist()} on it")


# ---------------------------------------------------------------- Checks.


def link_name(argument: str, value: Any) -> str:
    """The name of a link, whichever: a route is bound to a hand later. Raises InputError."""
    if not isinstance(value, str) or not value:
        raise InputError(argument, "the name of a link", repr(value))
    return value


def _placed(value: Any, shape: str) -> tuple[Array, Array]:
    """Centre (3,) [m] and axis (3,). Raises InputError."""
    name = "Around.placement"
    if isinstance(value, pin.SE3):
        return array(name, value.translation, (3,)), unit(name, value.rotation[:, 2], (3,))
    if shape == SPHERE and dimensions(value) == 1:
        return array(name, value, (3,), what="metres in the link's frame"), read_only(np.array([0.0, 0.0, 1.0]))
    value = several(name, value, _PLACEMENTS)
    if len(value) != 2:
        raise InputError(name, _PLACEMENTS, shown(value))
    centre = array(f"{name}[0]", value[0], (3,), what="metres in the link's frame")
    return centre, unit(f"{name}[1]", value[1], (3,))
