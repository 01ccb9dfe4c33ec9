"""The path of a taut cable from one point to another around a cylinder or a ball.

Seen along the axis of a cylinder, or in the plane through both points and the centre of a ball, the body is a circle of
radius r. From a point at the distance d two lines touch the circle, β = arccos(r/d) to either side of the point. So a
cable from a to b that goes round counterclockwise lies on the circle over the angle

    θ = ahead - β_a - β_b,    ahead = angle from a on to b,

and clockwise over 2π - ahead - β_a - β_b. Where the angle is not above zero the cable is straight and does not touch.
Of all paths that go round one way this one is the shortest; on a cylinder it has one slope along the axis all the way:
unrolled, it is a straight line.

A side settles which way: the cable does not cross the half-line that begins at the centre and points away from the
side. Without one it goes the shorter way. MuJoCo 4.0.1 does the same.
Source: plane geometry; Garner & Pandy, Computer Methods in Biomechanics and Biomedical Engineering 3 (2000).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, dimensions, number, read_only, unit
from handlcp.errors import InputError, Unsupported

CYLINDER, SPHERE = "cylinder", "sphere"
ROUNDING = 1e-9  # of a radius: a point less deep inside a body lies on its surface

_PLACEMENTS = "a pin.SE3 whose z is the axis, a point and a unit axis ((3,), (3,)), or of a sphere its centre (3,)"
_IN_LINE = 1e-12  # sine of an angle between two points, seen from the centre of a ball: they span no plane


class Bend(NamedTuple):
    """Where a cable lies on a round body.

    start, end : (3,) where it meets the body and where it leaves it [m]. before, after : (3,) unit vectors, where it
    runs at these points. length : of the whole cable from site to site [m]. angle : by which its direction turns [rad],
    that of the capstan equation: ∫ curvature ds.
    """

    start: Array
    end: Array
    before: Array
    after: Array
    length: float
    angle: float


@dataclass(frozen=True, slots=True, eq=False)
class RoundBody:
    """A cylinder without ends, or a ball; all in one frame, that of the points that it is asked about.

    centre : (3,) [m], of a cylinder any point on its axis. axis : (3,) unit vector; None: a ball. radius : [m].
    side : (3,) the cable passes the centre on this side [m]; None: where that is shorter.
    """

    centre: Array
    axis: Array | None
    radius: float
    side: Array | None

    def outside(self, point: Array) -> float:
        """How far a point (3,) is from the surface [m]; below 0 it is inside."""
        away = point - self.centre
        if self.axis is not None:
            away = away - (away @ self.axis) * self.axis
        return float(np.linalg.norm(away)) - self.radius

    def bend(self, p: Array, q: Array) -> Bend | None:
        """How a taut cable from p (3,) to q (3,) goes round, both outside; None: it is straight and touches nothing."""
        p, q = p - self.centre, q - self.centre
        side = None if self.side is None else self.side - self.centre
        x, y, z = _about(self.axis) if self.axis is not None else _plane(p, q, side)
        a, b = complex(p @ x, p @ y), complex(q @ x, q @ y)
        found = _way(a, b, self.radius, None if side is None else complex(side @ x, side @ y))
        if found is None:
            return None
        way, turn = found
        # Unrolled, the cable is the hypotenuse over its length in the plane of the circle and its rise along the axis
        free = _free(a, self.radius), _free(b, self.radius)
        flat, rise = free[0] + self.radius * turn + free[1], float((q - p) @ z)
        length = math.hypot(flat, rise)
        cosine, sine = flat / length, rise / length
        touch = _unit(a) * cmath.rect(1.0, way * _beta(a, self.radius))
        leave = _unit(b) * cmath.rect(1.0, -way * _beta(b, self.radius))
        points, runs = list[Array](), list[Array]()
        for radial, height in ((touch, p @ z + free[0] * rise / flat), (leave, q @ z - free[1] * rise / flat)):
            points.append(self.centre + self.radius * (radial.real * x + radial.imag * y) + height * z)
            along = 1j * way * radial
            runs.append(cosine * (along.real * x + along.imag * y) + sine * z)
        # A helix of this slope has the curvature cos²/r over the length r θ/cos
        return Bend(points[0], points[1], runs[0], runs[1], length, turn * cosine)


# ---------------------------------------------------------------- A round body on a link.


@dataclass(frozen=True, eq=False)
class Around:
    """A round body that the cable lies on where it is in the way, between two sites outside it. No friction.

    link : that carries it. placement : in the link's frame [m], a pin.SE3 whose z is the axis, or a point and the axis,
    or the centre of a sphere; kept as (centre (3,), axis (3,)). radius : [m]. shape : "cylinder", without ends, or
    "sphere". side : (3,) a point in the link's frame [m], an MJCF file's side site: the cable passes the centre on this
    side, and goes round the body also where a straight line would miss it on the other. Its direction counts, seen
    along a cylinder's axis or in the plane of the cable and a sphere's centre. In a posture in which a site passes
    behind the body, seen from the side, the cable changes its way and its length jumps. None: it goes round where that
    is shorter.

    Raises InputError; Unsupported for a side closer to the centre than the radius, with which an MJCF file asks for a
    cable through the inside.
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

    def in_frame(self, link: Array) -> RoundBody:
        """The body in the frame in which its link is placed; link (4, 4)."""
        R, p = link[:3, :3], link[:3, 3]
        centre, axis = self.placement
        side = None if self.side is None else R @ self.side + p
        return RoundBody(R @ centre + p, R @ axis if self.shape == CYLINDER else None, self.radius, side)

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
        if self.shape == CYLINDER and np.linalg.norm(cross(axis, away)) <= ROUNDING * self.radius:
            raise InputError("Around.side", "a point beside the axis of the cylinder", f"{self.side.tolist()} on it")


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
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise InputError(name, _PLACEMENTS, repr(value)[:80])
    centre = array(f"{name}[0]", value[0], (3,), what="metres in the link's frame")
    return centre, unit(f"{name}[1]", value[1], (3,))


# ---------------------------------------------------------------- Around a circle; points of its plane are complex.


def _way(a: complex, b: complex, r: float, side: complex | None) -> tuple[int, float] | None:
    """Which way a cable from a to b goes round the circle, 1 counterclockwise or -1, and over which angle [rad]."""
    reach = _beta(a, r) + _beta(b, r)
    ahead = _ahead(a, b)
    turns = {1: ahead - reach, -1: 2 * math.pi - ahead - reach}
    left = ahead < _ahead(a, -side) if side else turns[1] < turns[-1]
    way = 1 if left else -1
    return (way, turns[way]) if turns[way] > 0.0 else None


def _ahead(a: complex, b: complex) -> float:
    """Angle from a counterclockwise on to b, 0 to 2π."""
    return cmath.phase(b * a.conjugate()) % (2 * math.pi)


def _beta(a: complex, r: float) -> float:
    """arccos(r/|a|), exact also close to the circle."""
    return math.atan2(_free(a, r), r)


def _free(a: complex, r: float) -> float:
    """Length of the tangent from a to the circle [m]; 0 on it, and where rounding puts a point inside."""
    d = abs(a)
    return math.sqrt(max(d - r, 0.0) * (d + r))


def _unit(a: complex) -> complex:
    return a / abs(a)


def cross(a: Array, b: Array) -> Array:
    """(3,) a × b of vectors (3,); numpy's own takes ten times as long for a single pair."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def _about(axis: Array) -> tuple[Array, Array, Array]:
    """Axes x, y, z with z along `axis`, a unit vector."""
    other = np.zeros(3)
    other[np.argmin(abs(axis))] = 1.0
    x = cross(other, axis)
    x /= np.linalg.norm(x)
    return x, cross(axis, x), axis


def _plane(p: Array, q: Array, side: Array | None) -> tuple[Array, Array, Array]:
    """Axes x, y, z of the plane through the centre of a ball, p and q, with x along p.

    Points in line with the centre span none: then the plane goes through the side, or else anywhere.
    """
    x = p / np.linalg.norm(p)
    for other in (q, side):
        if other is not None:
            z = cross(x, other)
            size = float(np.linalg.norm(z))
            if size > _IN_LINE * float(np.linalg.norm(other)):
                z /= size
                return x, cross(z, x), z
    y, z, _ = _about(x)
    return x, y, z
