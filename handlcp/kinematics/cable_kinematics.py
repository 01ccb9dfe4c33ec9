"""`evaluate_cable_paths`: where taut cables run in a posture, around cylinders and balls, and their arms; compiled.

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

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.dense import kernel, product

SURFACE_ROUNDING = 1e-9  # of a radius: a point less deep inside a body lies on its surface

_COLLINEAR_SINE = 1e-12  # sine of an angle between two points, seen from the centre of a ball: they span no plane


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
def distance_from_body(body: RoundBody, point: Array) -> float:
    """How far a point (3,) is from the surface [m]; below 0 it is inside."""
    along, square = 0.0, 0.0
    for k in range(3):
        along += (point[k] - body.centre[k]) * body.axis[k]
    for k in range(3):
        square += (point[k] - body.centre[k] - along * body.axis[k]) ** 2
    return math.sqrt(square) - body.radius


@kernel
def straight_path(a: Array, b: Array, out: Array) -> float:
    """Length [m] of a cable from a (3,) to b (3,) that touches nothing. out (5, 3) : as in `wrap_path`, with b for both
    points, and the direction from a for the first; the last row stays.
    """
    length = math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
    for k in range(3):
        out[0, k] = out[1, k] = b[k]
        out[2, k], out[3, k] = (b[k] - a[k]) / length if length > 0.0 else 0.0, 0.0
    return length


@kernel
def wrap_path(body: RoundBody, a: Array, b: Array, out: Array) -> tuple[float, float]:
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
        _axes_about(body.axis, x, y, z)
    else:
        _axes_in_plane(p, q, side, x, y, z)
    pa, pb = complex(_dot(p, x), _dot(p, y)), complex(_dot(q, x), _dot(q, y))
    way, turn = _wrap_direction(pa, pb, r, complex(_dot(side, x), _dot(side, y)))
    middle = pa / abs(pa) * cmath.rect(1.0, way * (_tangent_angle(pa, r) + turn + _tangent_angle(pb, r)) / 2.0)
    for k in range(3):
        out[4, k] = middle.real * x[k] + middle.imag * y[k]
    if not turn > 0.0:
        return straight_path(a, b, out), 0.0
    # Unrolled, the cable is the hypotenuse over its length in the plane of the circle and its rise along the axis
    before, after, rise = _tangent_length(pa, r), _tangent_length(pb, r), _dot(q, z) - _dot(p, z)
    flat = before + r * turn + after
    length = math.hypot(flat, rise)
    cosine, sine = flat / length, rise / length
    touch = pa / abs(pa) * cmath.rect(1.0, way * _tangent_angle(pa, r))
    leave = pb / abs(pb) * cmath.rect(1.0, -way * _tangent_angle(pb, r))
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
def _wrap_direction(a: complex, b: complex, r: float, side: complex) -> tuple[float, float]:
    """Which way a cable from a to b goes round the circle, 1 counterclockwise or -1, and over which angle [rad]; not
    above 0: it does not touch. side 0: the shorter way.
    """
    reach, ahead = _tangent_angle(a, r) + _tangent_angle(b, r), _angle_ahead(a, b)
    left, right = ahead - reach, 2.0 * math.pi - ahead - reach
    if (ahead < _angle_ahead(a, -side)) if side != 0.0 else (left < right):
        return 1.0, left
    return -1.0, right


@kernel
def _angle_ahead(a: complex, b: complex) -> float:
    """Angle from a counterclockwise on to b, 0 to 2π."""
    return cmath.phase(b * a.conjugate()) % (2.0 * math.pi)


@kernel
def _tangent_angle(a: complex, r: float) -> float:
    """arccos(r/|a|), exact also close to the circle."""
    return math.atan2(_tangent_length(a, r), r)


@kernel
def _tangent_length(a: complex, r: float) -> float:
    """Length of the tangent from a to the circle [m]; 0 on it, and where rounding puts a point inside."""
    d = abs(a)
    return math.sqrt(max(d - r, 0.0) * (d + r))


# ---------------------------------------------------------------- Axes.


@kernel
def _axes_about(axis: Array, x: Array, y: Array, z: Array) -> None:
    """Write axes x, y, z with z along `axis`, a unit vector."""
    least = 0
    for k in range(1, 3):
        if abs(axis[k]) < abs(axis[least]):
            least = k
    for k in range(3):
        z[k], y[k] = axis[k], 1.0 if k == least else 0.0
    _divide(x, _cross(y, z, x))
    _cross(z, x, y)


@kernel
def _axes_in_plane(p: Array, q: Array, side: Array, x: Array, y: Array, z: Array) -> None:
    """Write axes x, y, z with x along p and q in their plane; in line with p, the side is, or anything."""
    size = math.sqrt(_dot(p, p))
    for k in range(3):
        x[k] = p[k] / size
    for n in range(2):
        other = q if n == 0 else side
        size = _cross(x, other, z)
        if size > _COLLINEAR_SINE * math.sqrt(_dot(other, other)):
            _divide(z, size)
            _cross(z, x, y)
            return
    _axes_about(x, y, z, x)


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
def _divide(a: Array, size: float) -> None:
    for k in range(3):
        a[k] /= size


# ----------------------------------------------------------------
# Cables along routes in a posture, those of a whole hand in one compiled call: lengths, arms, wraps, how arms change.
#
# L(q) = Σ_branches (1/d) Σ (straight pieces + arcs),    arms = -∂L/∂q
#
# A taut path is the shortest of its kind, so where it meets and leaves a round body changes its length in second
# order only: for ∂L/∂q these points move with the body's link. Then arcs keep their length, and each straight piece
# from a to b along the unit vector u lengthens by u · (ṗ_b - ṗ_a). A joint with the world velocity field v + ω × p
# that moves b and not a brings
#
# ∂|b - a|/∂q = u · v + (p × u) · ω,    p any point of the line
#
# with the other sign where it moves a and not b, and nothing where it moves both or none.
#
# How that changes with a joint i: what i moves of a leg is moved by its screw, and u and p × u follow, by central
# differences. v and ω of a joint j change with joints before it alone, so i is taken as the one of both that does not
# come before the other; the second derivative has both orders.
# Source: Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation (1994), section 6.4, for arms as
# derivatives of the length; MuJoCo's XML reference, tendon/spatial, for sites, side sites and pulleys.


_DIFFERENCE_STEP = 1e-6  # [rad, m] of the central differences


class PackedRoutes(NamedTuple):
    """t tendons on the links of a hand, over p places and l legs from one site to the next, those of a tendon in order.

    links (p,) : number of a place's link among the placements. points (p, 3), sides (p, 3) [m], axes (p, 3) : as in
    `RoundBody`, in the link's frame; of a site the point. radii (p,) : 0 of sites. support (p, joints) : 1 where a
    joint moves a place. legs (l, 4) : numbers of the tendon, of the first and last place, and of the body between,
    -1: straight. divisors (l,).
    """

    links: Ints
    points: Array
    axes: Array
    sides: Array
    radii: Array
    support: Array
    legs: Ints
    divisors: Array


class CablePosture(NamedTuple):
    """A posture of the links that cables run over.

    placements (links, 4, 4) : of the links, world axes [m].
    columns (joints, 6) : of the world Jacobian, the linear part of the world's origin first.
    """

    placements: Array
    columns: Array


class CablePaths(NamedTuple):
    """Tendons in a posture, and each of their legs.

    lengths (t,) : L [m].
    arms (t, joints) : -∂L/∂q.
    wrap_angles (l,) : by how much the cable turns on the body of a leg [rad], 0: it does not touch.
    piece_arms (l, 2, joints) : arms of the straight pieces before and after the body, divisors included; the second 0
        where there is one piece.
    arms_beyond (l, joints) : arms of all pieces of the tendon after the body.
    piece_ends (l, 4, 3) : from where to where the pieces run [m], world axes; of one the last two are where it ends.
    wrap_sides (l, 3) : the side of its body on which the cable passes, a unit vector in the axes of the body's link;
        zeros: without a body.
    """

    lengths: Array
    arms: Array
    wrap_angles: Array
    piece_arms: Array
    arms_beyond: Array
    piece_ends: Array
    wrap_sides: Array


class _WorldPlaces(NamedTuple):
    """The places of `PackedRoutes` in world axes: points, axes and sides (p, 3)."""

    points: Array
    axes: Array
    sides: Array


@kernel
def evaluate_cable_paths(s: PackedRoutes, posed: CablePosture, out: CablePaths) -> tuple[int, float]:
    """Write into out (of zeros) what tendons do in a posture. Returns the first site inside the body that it leads to,
    as twice its leg and 1 more for the last site of it, and how deep it is there [m]; -1 where there is none.
    """
    at, run = _transform_places(s, posed.placements), np.empty((5, 3))
    wrong, depth = _find_site_inside(s, at)
    if wrong >= 0:
        return wrong, depth
    for n in range(len(s.legs) - 1, -1, -1):
        t, first, last, body = s.legs[n, 0], s.legs[n, 1], s.legs[n, 2], s.legs[n, 3]
        length, angle = _leg_path(s, n, at, run)
        a, b, own, ends = at.points[first], at.points[last], out.piece_arms[n], out.piece_ends[n]
        out.lengths[t] += length / s.divisors[n]
        out.wrap_angles[n] = angle
        for k in range(3):
            ends[0, k], ends[1, k], ends[2, k], ends[3, k] = a[k], run[0, k], run[1, k], b[k]
            if body >= 0:
                M = posed.placements[s.links[body]]
                out.wrap_sides[n, k] = M[0, k] * run[4, 0] + M[1, k] * run[4, 1] + M[2, k] * run[4, 2]
        middle = body if angle > 0.0 else last
        for j in range(len(posed.columns)):
            leaves, comes = s.support[first, j] - s.support[middle, j], s.support[middle, j] - s.support[last, j]
            if leaves != 0.0:
                own[0, j] = leaves * _point_speed_along(posed.columns[j], run[2], a) / s.divisors[n]
            if comes != 0.0:
                own[1, j] = comes * _point_speed_along(posed.columns[j], run[3], b) / s.divisors[n]
        for j in range(len(posed.columns)):
            out.arms_beyond[n, j] = out.arms[t, j] + own[1, j]
            out.arms[t, j] = out.arms_beyond[n, j] + own[0, j]
    return -1, 0.0


@kernel
def evaluate_arm_rates(s: PackedRoutes, posed: CablePosture, out: Array) -> None:
    """Add ∂arms/∂q of each tendon, symmetric [m/rad²], to out (t, joints, joints)."""
    at, columns = _transform_places(s, posed.placements), posed.columns
    low, high = _copy_places(at), _copy_places(at)
    before, after = np.empty((5, 3)), np.empty((5, 3))
    for n in range(len(s.legs)):
        rates, share = out[s.legs[n, 0]], 1.0 / s.divisors[n] / (2.0 * _DIFFERENCE_STEP)
        for i in range(len(columns)):
            if not _is_leg_moved(s, n, i):
                continue
            for k in range(3):
                place = s.legs[n, 1 + k]
                if place >= 0 and s.support[place, i] != 0.0:
                    _move_place(low, at, place, columns[i], -_DIFFERENCE_STEP)
                    _move_place(high, at, place, columns[i], _DIFFERENCE_STEP)
            _, less = _leg_path(s, n, low, before)
            _, more = _leg_path(s, n, high, after)
            for j in range(i + 1):
                if _is_leg_moved(s, n, j):
                    change = _leg_arm(s, n, columns[j], high, after, j, more > 0.0)
                    change = share * (change - _leg_arm(s, n, columns[j], low, before, j, less > 0.0))
                    rates[i, j] += change
                    if i != j:
                        rates[j, i] += change
            for k in range(3):
                _restore_place(low, at, s.legs[n, 1 + k])
                _restore_place(high, at, s.legs[n, 1 + k])


class TendonArms(NamedTuple):
    """What of tendons changes with the posture, as compiled code reads it: arms (t, nv), shift (t,), wrap_friction
    (m,) and arms_beyond (m, nv).
    """

    arms: Array
    shift: Array
    wrap_friction: Array
    arms_beyond: Array


class RoutedTendons(NamedTuple):
    """t tendons over nv independent joints, r of them along routes, as compiled code reads them.

    routes : of the r tendons. numbers (r,) : which of the t they are.
    coupling (joints, nv) : of the independent joints; empty (0, 0) where they are all of them.
    elastic (nv,) : joints that are not rigid; arms of the others are 0, since no load reaches tendons through them.
    given : with the arms that were given, 0 of routes; wrap_friction of posts of routes is their μ.
    post_legs (m,) : number of the leg that goes round a post, -1: of a tendon without a route.
    """

    routes: PackedRoutes
    numbers: Ints
    coupling: Array
    elastic: Bools
    given: TendonArms
    post_legs: Ints


@kernel
def lay_tendons(s: RoutedTendons, posed: CablePosture, q: Array) -> tuple[TendonArms, CablePaths, int, float]:
    """The tendons with joints at q (nv,), in the posture of that: their arms, and their paths over the independent
    joints, rigid ones included; and the first site inside its body as of `evaluate_cable_paths`.
    """
    r, joints, legs, nv = len(s.numbers), len(posed.columns), len(s.routes.legs), len(q)
    paths = CablePaths(
        np.zeros(r), np.zeros((r, joints)), np.zeros(legs), np.zeros((legs, 2, joints)), np.zeros((legs, joints)),
        np.zeros((legs, 4, 3)), np.zeros((legs, 3)),
    )  # fmt: skip
    wrong, depth = evaluate_cable_paths(s.routes, posed, paths)
    arms, beyond, own = paths.arms, paths.arms_beyond, paths.piece_arms
    if len(s.coupling) > 0:
        arms, beyond, own = product(arms, s.coupling), product(beyond, s.coupling), np.zeros((legs, 2, nv))
        for n in range(legs):
            own[n] = product(paths.piece_arms[n], s.coupling)
    R, shift = s.given.arms.copy(), np.zeros(len(s.given.arms))
    friction, arms_beyond = s.given.wrap_friction.copy(), s.given.arms_beyond.copy()
    for k in range(r):
        i = s.numbers[k]
        shift[i] = -paths.lengths[k]
        for j in range(nv):
            R[i, j] = arms[k, j] if s.elastic[j] else 0.0
            shift[i] -= R[i, j] * q[j]
    for p in range(len(friction)):
        leg = s.post_legs[p]
        if leg >= 0:
            friction[p] *= paths.wrap_angles[leg]
            for j in range(nv):
                arms_beyond[p, j] = beyond[leg, j] if s.elastic[j] else 0.0
    paths = CablePaths(paths.lengths, arms, paths.wrap_angles, own, beyond, paths.piece_ends, paths.wrap_sides)
    return TendonArms(R, shift, friction, arms_beyond), paths, wrong, depth


@kernel
def tendon_arm_rates(s: RoutedTendons, posed: CablePosture) -> Array:
    """(t, nv, nv) ∂R/∂q in a posture [m/rad²], symmetric; 0 of given arms and of rigid joints."""
    joints, nv = len(posed.columns), len(s.elastic)
    rates, out = np.zeros((len(s.numbers), joints, joints)), np.zeros((len(s.given.arms), nv, nv))
    evaluate_arm_rates(s.routes, posed, rates)
    for k in range(len(s.numbers)):
        own = rates[k]
        if len(s.coupling) > 0:
            own = product(s.coupling.T.copy(), product(own, s.coupling))
        for i in range(nv):
            for j in range(nv):
                if s.elastic[i] and s.elastic[j]:
                    out[s.numbers[k], i, j] = own[i, j]
    return out


@kernel
def _transform_places(s: PackedRoutes, placements: Array) -> _WorldPlaces:
    n = len(s.links)
    out = _WorldPlaces(np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)))
    for i in range(n):
        M = placements[s.links[i]]
        for a in range(3):
            point, axis, side = M[a, 3], 0.0, M[a, 3]
            for b in range(3):
                point += M[a, b] * s.points[i, b]
                axis += M[a, b] * s.axes[i, b]
                side += M[a, b] * s.sides[i, b]
            out.points[i, a], out.axes[i, a], out.sides[i, a] = point, axis, side
    return out


@kernel
def _copy_places(at: _WorldPlaces) -> _WorldPlaces:
    return _WorldPlaces(at.points.copy(), at.axes.copy(), at.sides.copy())


@kernel
def _round_body(s: PackedRoutes, at: _WorldPlaces, i: int) -> RoundBody:
    return RoundBody(at.points[i], at.axes[i], s.radii[i], at.sides[i])


@kernel
def _find_site_inside(s: PackedRoutes, at: _WorldPlaces) -> tuple[int, float]:
    for n in range(len(s.legs)):
        body = s.legs[n, 3]
        if body >= 0:
            for k in range(2):
                depth = -distance_from_body(_round_body(s, at, body), at.points[s.legs[n, 1 + k]])
                if depth > SURFACE_ROUNDING * s.radii[body]:
                    return 2 * n + k, depth
    return -1, 0.0


@kernel
def _leg_path(s: PackedRoutes, n: int, at: _WorldPlaces, run: Array) -> tuple[float, float]:
    """Length of a leg [m] and the angle on its body [rad]; run (5, 3) : as `wrap_path` writes it."""
    a, b, body = at.points[s.legs[n, 1]], at.points[s.legs[n, 2]], s.legs[n, 3]
    if body < 0:
        return straight_path(a, b, run), 0.0
    return wrap_path(_round_body(s, at, body), a, b, run)


@kernel
def _point_speed_along(column: Array, u: Array, p: Array) -> float:
    """Velocity along u of a point p that a joint moves, u · (v + ω × p), of its column (v, ω)."""
    found = 0.0
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        found += u[a] * (column[a] + column[3 + b] * p[c] - column[3 + c] * p[b])
    return found


@kernel
def _is_leg_moved(s: PackedRoutes, n: int, j: int) -> bool:
    """Whether a joint moves some places of a leg and not others."""
    first, last, body = s.support[s.legs[n, 1], j], s.support[s.legs[n, 2], j], s.legs[n, 3]
    return bool(first != last or (body >= 0 and s.support[body, j] != first))


@kernel
def _leg_arm(s: PackedRoutes, n: int, column: Array, at: _WorldPlaces, run: Array, j: int, touches: bool) -> float:
    """A leg's arm of a joint, divisor left out, where the leg lies as `run` says."""
    first, last = s.legs[n, 1], s.legs[n, 2]
    middle = s.legs[n, 3] if touches else last
    leaves, comes = s.support[first, j] - s.support[middle, j], s.support[middle, j] - s.support[last, j]
    return float(
        leaves * _point_speed_along(column, run[2], at.points[first])
        + comes * _point_speed_along(column, run[3], at.points[last])
    )


@kernel
def _move_place(out: _WorldPlaces, at: _WorldPlaces, place: int, column: Array, by: float) -> None:
    """Write a place where a joint has moved it by so much along its screw (v, ω)."""
    size = math.sqrt(column[3] ** 2 + column[4] ** 2 + column[5] ** 2)
    once, twice = by, 0.0
    if size > 0.0:
        once, twice = math.sin(size * by) / size, 2.0 * (math.sin(size * by / 2.0) / size) ** 2
    _turn_point(out.points[place], at.points[place], column, 1.0, once, twice)
    _turn_point(out.sides[place], at.sides[place], column, 1.0, once, twice)
    _turn_point(out.axes[place], at.axes[place], column, 0.0, once, twice)


@kernel
def _turn_point(out: Array, p: Array, column: Array, point: float, once: float, twice: float) -> None:
    """Write p + once g + twice ω × g with its velocity g = v + ω × p, of a direction ω × p; point : 1, or 0 of that."""
    w0, w1, w2 = column[3], column[4], column[5]
    g0 = point * column[0] + w1 * p[2] - w2 * p[1]
    g1 = point * column[1] + w2 * p[0] - w0 * p[2]
    g2 = point * column[2] + w0 * p[1] - w1 * p[0]
    out[0] = p[0] + once * g0 + twice * (w1 * g2 - w2 * g1)
    out[1] = p[1] + once * g1 + twice * (w2 * g0 - w0 * g2)
    out[2] = p[2] + once * g2 + twice * (w0 * g1 - w1 * g0)


@kernel
def _restore_place(out: _WorldPlaces, at: _WorldPlaces, place: int) -> None:
    if place >= 0:
        for k in range(3):
            out.points[place, k], out.axes[place, k] = at.points[place, k], at.axes[place, k]
            out.sides[place, k] = at.sides[place, k]
