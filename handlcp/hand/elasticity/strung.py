"""Cables along routes in a posture, those of a whole hand in one compiled call: lengths, arms, wraps, how arms change.

L(q) = Σ_branches (1/d) Σ (straight pieces + arcs),    arms = -∂L/∂q

A taut path is the shortest of its kind, so where it meets and leaves a round body changes its length in second order
only: for ∂L/∂q these points move with the body's link. Then arcs keep their length, and each straight piece from a to b
along the unit vector u lengthens by u · (ṗ_b - ṗ_a). A joint with the world velocity field v + ω × p that moves b and
not a brings

∂|b - a|/∂q = u · v + (p × u) · ω,    p any point of the line

with the other sign where it moves a and not b, and nothing where it moves both or none.

How that changes with a joint i: what i moves of a leg is moved by its screw, and u and p × u follow, by central
differences. v and ω of a joint j change with joints before it alone, so i is taken as the one of both that does not
come before the other; the second derivative has both orders.
Source: Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation (1994), section 6.4, for arms as
derivatives of the length; MuJoCo's XML reference, tendon/spatial, for sites, side sites and pulleys.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.hand.elasticity.wrapping import ROUNDING, RoundBody, bend, outside, straight
from handlcp.lcp.kernels.dense import kernel

_STEP = 1e-6  # [rad, m] of the central differences


class Strands(NamedTuple):
    """t tendons on the links of a hand, over p places and l legs from one site to the next, those of a tendon in order.

    at (p,) : number of a place's link among the placements. points (p, 3), sides (p, 3) [m], axes (p, 3) : as in
    `RoundBody`, in the link's frame; of a site the point. radii (p,) : 0 of sites. support (p, joints) : 1 where a
    joint moves a place. legs (l, 4) : numbers of the tendon, of the first and last place, and of the body between,
    -1: straight. divisors (l,).
    """

    at: Ints
    points: Array
    axes: Array
    sides: Array
    radii: Array
    support: Array
    legs: Ints
    divisors: Array


class Posed(NamedTuple):
    """A posture. placements (links, 4, 4). columns (joints, 6) : of the world Jacobian, the linear part of the world's
    origin first.
    """

    placements: Array
    columns: Array


class Strung(NamedTuple):
    """Tendons in a posture. lengths (t,) : L [m]. arms (t, joints) : -∂L/∂q. Of each leg: turned (l,) : by how much the
    cable turns on its body [rad], 0: it does not touch. pieces (l, 2, joints) : arms of the straight pieces before and
    after the body, divisors included; the second 0 where there is one piece. beyond (l, joints) : arms of all pieces of
    the tendon after the body. ends (l, 4, 3) : from where to where the pieces run [m], world axes; of one the last two
    are where it ends. sides (l, 3) : the side of its body on which the cable passes, a unit vector in the axes of the
    body's link; zeros: without a body.
    """

    lengths: Array
    arms: Array
    turned: Array
    pieces: Array
    beyond: Array
    ends: Array
    sides: Array


class _Placed(NamedTuple):
    """points, axes, sides (p, 3) : of `Strands`, in world axes."""

    points: Array
    axes: Array
    sides: Array


@kernel
def strung(s: Strands, posed: Posed, out: Strung) -> tuple[int, float]:
    """Write into out (of zeros) what tendons do in a posture. Returns the first site inside the body that it leads to,
    as twice its leg and 1 more for the last site of it, and how deep it is there [m]; -1 where there is none.
    """
    at, run = _placed(s, posed.placements), np.empty((5, 3))
    wrong, depth = _inside(s, at)
    if wrong >= 0:
        return wrong, depth
    for n in range(len(s.legs) - 1, -1, -1):
        t, first, last, body = s.legs[n, 0], s.legs[n, 1], s.legs[n, 2], s.legs[n, 3]
        length, angle = _leg(s, n, at, run)
        a, b, own, ends = at.points[first], at.points[last], out.pieces[n], out.ends[n]
        out.lengths[t] += length / s.divisors[n]
        out.turned[n] = angle
        for k in range(3):
            ends[0, k], ends[1, k], ends[2, k], ends[3, k] = a[k], run[0, k], run[1, k], b[k]
            if body >= 0:
                M = posed.placements[s.at[body]]
                out.sides[n, k] = M[0, k] * run[4, 0] + M[1, k] * run[4, 1] + M[2, k] * run[4, 2]
        middle = body if angle > 0.0 else last
        for j in range(len(posed.columns)):
            leaves, comes = s.support[first, j] - s.support[middle, j], s.support[middle, j] - s.support[last, j]
            if leaves != 0.0:
                own[0, j] = leaves * _along(posed.columns[j], run[2], a) / s.divisors[n]
            if comes != 0.0:
                own[1, j] = comes * _along(posed.columns[j], run[3], b) / s.divisors[n]
        for j in range(len(posed.columns)):
            out.beyond[n, j] = out.arms[t, j] + own[1, j]
            out.arms[t, j] = out.beyond[n, j] + own[0, j]
    return -1, 0.0


@kernel
def turning(s: Strands, posed: Posed, tension: Array, out: Array) -> None:
    """Add Σ T ∂arms/∂q, symmetric, to out (joints, joints); tension (t,) : T."""
    at, columns = _placed(s, posed.placements), posed.columns
    low, high = _copied(at), _copied(at)
    before, after = np.empty((5, 3)), np.empty((5, 3))
    for n in range(len(s.legs)):
        if tension[s.legs[n, 0]] == 0.0:
            continue
        share = tension[s.legs[n, 0]] / s.divisors[n] / (2.0 * _STEP)
        for i in range(len(columns)):
            if not _parts(s, n, i):
                continue
            for k in range(3):
                place = s.legs[n, 1 + k]
                if place >= 0 and s.support[place, i] != 0.0:
                    _move(low, at, place, columns[i], -_STEP)
                    _move(high, at, place, columns[i], _STEP)
            _, less = _leg(s, n, low, before)
            _, more = _leg(s, n, high, after)
            for j in range(i + 1):
                if _parts(s, n, j):
                    change = _pulls(s, n, columns[j], high, after, j, more > 0.0)
                    change = share * (change - _pulls(s, n, columns[j], low, before, j, less > 0.0))
                    out[i, j] += change
                    if i != j:
                        out[j, i] += change
            for k in range(3):
                _put_back(low, at, s.legs[n, 1 + k])
                _put_back(high, at, s.legs[n, 1 + k])


@kernel
def _placed(s: Strands, placements: Array) -> _Placed:
    n = len(s.at)
    out = _Placed(np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)))
    for i in range(n):
        M = placements[s.at[i]]
        for a in range(3):
            point, axis, side = M[a, 3], 0.0, M[a, 3]
            for b in range(3):
                point += M[a, b] * s.points[i, b]
                axis += M[a, b] * s.axes[i, b]
                side += M[a, b] * s.sides[i, b]
            out.points[i, a], out.axes[i, a], out.sides[i, a] = point, axis, side
    return out


@kernel
def _copied(at: _Placed) -> _Placed:
    return _Placed(at.points.copy(), at.axes.copy(), at.sides.copy())


@kernel
def _body(s: Strands, at: _Placed, i: int) -> RoundBody:
    return RoundBody(at.points[i], at.axes[i], s.radii[i], at.sides[i])


@kernel
def _inside(s: Strands, at: _Placed) -> tuple[int, float]:
    for n in range(len(s.legs)):
        body = s.legs[n, 3]
        if body >= 0:
            for k in range(2):
                depth = -outside(_body(s, at, body), at.points[s.legs[n, 1 + k]])
                if depth > ROUNDING * s.radii[body]:
                    return 2 * n + k, depth
    return -1, 0.0


@kernel
def _leg(s: Strands, n: int, at: _Placed, run: Array) -> tuple[float, float]:
    """Length of a leg [m] and the angle on its body [rad]; run (5, 3) : as `bend` writes it."""
    a, b, body = at.points[s.legs[n, 1]], at.points[s.legs[n, 2]], s.legs[n, 3]
    if body < 0:
        return straight(a, b, run), 0.0
    return bend(_body(s, at, body), a, b, run)


@kernel
def _along(column: Array, u: Array, p: Array) -> float:
    """Velocity along u of a point p that a joint moves, u · (v + ω × p), of its column (v, ω)."""
    found = 0.0
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        found += u[a] * (column[a] + column[3 + b] * p[c] - column[3 + c] * p[b])
    return found


@kernel
def _parts(s: Strands, n: int, j: int) -> bool:
    """Whether a joint moves some places of a leg and not others."""
    first, last, body = s.support[s.legs[n, 1], j], s.support[s.legs[n, 2], j], s.legs[n, 3]
    return bool(first != last or (body >= 0 and s.support[body, j] != first))


@kernel
def _pulls(s: Strands, n: int, column: Array, at: _Placed, run: Array, j: int, touches: bool) -> float:
    """A leg's arm of a joint, divisor left out, where the leg lies as `run` says."""
    first, last = s.legs[n, 1], s.legs[n, 2]
    middle = s.legs[n, 3] if touches else last
    leaves, comes = s.support[first, j] - s.support[middle, j], s.support[middle, j] - s.support[last, j]
    return float(leaves * _along(column, run[2], at.points[first]) + comes * _along(column, run[3], at.points[last]))


@kernel
def _move(out: _Placed, at: _Placed, place: int, column: Array, by: float) -> None:
    """Write a place where a joint has moved it by so much along its screw (v, ω)."""
    size = math.sqrt(column[3] ** 2 + column[4] ** 2 + column[5] ** 2)
    once, twice = by, 0.0
    if size > 0.0:
        once, twice = math.sin(size * by) / size, 2.0 * (math.sin(size * by / 2.0) / size) ** 2
    _turned(out.points[place], at.points[place], column, 1.0, once, twice)
    _turned(out.sides[place], at.sides[place], column, 1.0, once, twice)
    _turned(out.axes[place], at.axes[place], column, 0.0, once, twice)


@kernel
def _turned(out: Array, p: Array, column: Array, point: float, once: float, twice: float) -> None:
    """Write p + once g + twice ω × g with its velocity g = v + ω × p, of a direction ω × p; point : 1, or 0 of that."""
    w0, w1, w2 = column[3], column[4], column[5]
    g0 = point * column[0] + w1 * p[2] - w2 * p[1]
    g1 = point * column[1] + w2 * p[0] - w0 * p[2]
    g2 = point * column[2] + w0 * p[1] - w1 * p[0]
    out[0] = p[0] + once * g0 + twice * (w1 * g2 - w2 * g1)
    out[1] = p[1] + once * g1 + twice * (w2 * g0 - w0 * g2)
    out[2] = p[2] + once * g2 + twice * (w0 * g1 - w1 * g0)


@kernel
def _put_back(out: _Placed, at: _Placed, place: int) -> None:
    if place >= 0:
        for k in range(3):
            out.points[place, k], out.axes[place, k] = at.points[place, k], at.axes[place, k]
            out.sides[place, k] = at.sides[place, k]
