"""The path of a taut cable from one point to another around a cylinder or a ball, compiled.

Seen along the axis of a cylinder, or in the plane through both points and the centre of a ball, the body is a circle of
radius r. From a point at the distance d two lines touch the circle, β = arccos(r/d) to either side of the point. So a
cable from a to b that goes round counterclockwise lies on the circle over the angle

    θ = ahead - β_a - β_b,    ahead = angle from a on to b,

and clockwise over 2π - ahead - β_a - β_b. Where the angle is not above zero the cable is straight and does not touch.
Of all paths that go round one way this one is the shortest; on a cylinder it has one slope along the axis all the way:
unrolled, it is a straight line.

A side settles which way: the cable does not cross the half-line that begins at the centre and points away from the
side. Without one it goes the shorter way. MuJoCo 4.0.1 does the same. Either way the cable may change sides from one
posture to the next: then the direction from the centre to its middle turns round.
Source: plane geometry; Garner & Pandy, Computer Methods in Biomechanics and Biomedical Engineering 3 (2000).
"""

from __future__ import annotations

import cmath
import math
from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.dense import kernel

ROUNDING = 1e-9  # of a radius: a point less deep inside a body lies on its surface

_IN_LINE = 1e-12  # sine of an angle between two points, seen from the centre of a ball: they span no plane


class RoundBody(NamedTuple):
    """A cylinder without ends, or a ball; all in one frame, that of the points that it is asked about.

    centre : (3,) [m], of a cylinder any point on its axis. axis : (3,) unit vector; zeros: a ball. radius : [m].
    side : (3,) the cable passes the centre on this side [m]; the centre itself: where that is shorter.
    """

    centre: Array
    axis: Array
    radius: float
    side: Array


@kernel
def outside(body: RoundBody, point: Array) -> float:
    """How far a point (3,) is from the surface [m]; below 0 it is inside."""
    along, square = 0.0, 0.0
    for k in range(3):
        along += (point[k] - body.centre[k]) * body.axis[k]
    for k in range(3):
        square += (point[k] - body.centre[k] - along * body.axis[k]) ** 2
    return math.sqrt(square) - body.radius


@kernel
def straight(a: Array, b: Array, out: Array) -> float:
    """Length [m] of a cable from a (3,) to b (3,) that touches nothing. out (5, 3) : as in `bend`, with b for both
    points, and the direction from a for the first; the last row stays.
    """
    length = math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
    for k in range(3):
        out[0, k] = out[1, k] = b[k]
        out[2, k], out[3, k] = (b[k] - a[k]) / length if length > 0.0 else 0.0, 0.0
    return length


@kernel
def bend(body: RoundBody, a: Array, b: Array, out: Array) -> tuple[float, float]:
    """Length [m] of a taut cable from a (3,) to b (3,), both outside, and the angle by which its direction turns on the
    body [rad], that of the capstan equation, ∫ curvature ds; 0: it is straight and touches nothing.

    Written into out (5, 3): where it meets the body and where it leaves it [m], unit vectors along which it runs at
    these points, and one from the centre towards the middle of its way round, also where it does not touch. Small
    arrays cost more here than what is computed with them: there is one of work.
    """
    work, centre, r = np.empty((6, 3)), body.centre, body.radius
    p, q, side, x, y, z = work[0], work[1], work[2], work[3], work[4], work[5]
    for k in range(3):
        p[k], q[k], side[k] = a[k] - centre[k], b[k] - centre[k], body.side[k] - centre[k]
    if _dot(body.axis, body.axis) > 0.0:
        _about(body.axis, x, y, z)
    else:
        _plane(p, q, side, x, y, z)
    pa, pb = complex(_dot(p, x), _dot(p, y)), complex(_dot(q, x), _dot(q, y))
    way, turn = _way(pa, pb, r, complex(_dot(side, x), _dot(side, y)))
    middle = pa / abs(pa) * cmath.rect(1.0, way * (_beta(pa, r) + turn + _beta(pb, r)) / 2.0)
    for k in range(3):
        out[4, k] = middle.real * x[k] + middle.imag * y[k]
    if not turn > 0.0:
        return straight(a, b, out), 0.0
    # Unrolled, the cable is the hypotenuse over its length in the plane of the circle and its rise along the axis
    before, after, rise = _free(pa, r), _free(pb, r), _dot(q, z) - _dot(p, z)
    flat = before + r * turn + after
    length = math.hypot(flat, rise)
    cosine, sine = flat / length, rise / length
    touch = pa / abs(pa) * cmath.rect(1.0, way * _beta(pa, r))
    leave = pb / abs(pb) * cmath.rect(1.0, -way * _beta(pb, r))
    low, high = _dot(p, z) + before * rise / flat, _dot(q, z) - after * rise / flat
    for k in range(3):
        out[0, k] = centre[k] + r * (touch.real * x[k] + touch.imag * y[k]) + low * z[k]
        out[1, k] = centre[k] + r * (leave.real * x[k] + leave.imag * y[k]) + high * z[k]
        # A quarter of a turn ahead of the radius, and up the slope
        out[2, k] = cosine * way * (touch.real * y[k] - touch.imag * x[k]) + sine * z[k]
        out[3, k] = cosine * way * (leave.real * y[k] - leave.imag * x[k]) + sine * z[k]
    return length, turn * cosine  # a helix of this slope has the curvature cos²/r over the length r θ/cos


# ---------------------------------------------------------------- Around a circle; points of its plane are complex.


@kernel
def _way(a: complex, b: complex, r: float, side: complex) -> tuple[float, float]:
    """Which way a cable from a to b goes round the circle, 1 counterclockwise or -1, and over which angle [rad]; not
    above 0: it does not touch. side 0: the shorter way.
    """
    reach, ahead = _beta(a, r) + _beta(b, r), _ahead(a, b)
    left, right = ahead - reach, 2.0 * math.pi - ahead - reach
    if (ahead < _ahead(a, -side)) if side != 0.0 else (left < right):
        return 1.0, left
    return -1.0, right


@kernel
def _ahead(a: complex, b: complex) -> float:
    """Angle from a counterclockwise on to b, 0 to 2π."""
    return cmath.phase(b * a.conjugate()) % (2.0 * math.pi)


@kernel
def _beta(a: complex, r: float) -> float:
    """arccos(r/|a|), exact also close to the circle."""
    return math.atan2(_free(a, r), r)


@kernel
def _free(a: complex, r: float) -> float:
    """Length of the tangent from a to the circle [m]; 0 on it, and where rounding puts a point inside."""
    d = abs(a)
    return math.sqrt(max(d - r, 0.0) * (d + r))


# ---------------------------------------------------------------- Axes.


@kernel
def _about(axis: Array, x: Array, y: Array, z: Array) -> None:
    """Write axes x, y, z with z along `axis`, a unit vector."""
    least = 0
    for k in range(1, 3):
        if abs(axis[k]) < abs(axis[least]):
            least = k
    for k in range(3):
        z[k], y[k] = axis[k], 1.0 if k == least else 0.0
    _scale(x, _cross(y, z, x))
    _cross(z, x, y)


@kernel
def _plane(p: Array, q: Array, side: Array, x: Array, y: Array, z: Array) -> None:
    """Write axes x, y, z of the plane through the centre of a ball, p and q, with x along p.

    Points in line with the centre span none: then the plane goes through the side, or else anywhere.
    """
    size = math.sqrt(_dot(p, p))
    for k in range(3):
        x[k] = p[k] / size
    for n in range(2):
        other = q if n == 0 else side
        size = _cross(x, other, z)
        if size > _IN_LINE * math.sqrt(_dot(other, other)):
            _scale(z, size)
            _cross(z, x, y)
            return
    _about(x, y, z, x)


@kernel
def _dot(a: Array, b: Array) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@kernel
def _cross(a: Array, b: Array, out: Array) -> float:
    """Write a × b; its length."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return math.sqrt(_dot(out, out))


@kernel
def _scale(a: Array, size: float) -> None:
    for k in range(3):
        a[k] /= size
