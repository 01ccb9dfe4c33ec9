"""Where a ball that is swept along a line or over a rectangle is nearest to an object, or to its corner, compiled.

A capsule is a ball swept along a line, the face of a box a ball without radius swept over a rectangle. Of all its
stations c + s a + t b, -1 ≤ s, t ≤ 1, the nearest one counts. The signed distance φ of a convex object is a convex
function of the station, so that each slope a · ∇φ grows along a, and the nearest station is where it changes its sign.

As the shape moves, the nearest station stays where the normal n is across the line:

    a · n = 0,   ds = -(aᵀ N δc + (ω × a) · n) / (aᵀ N a)

δc is the motion of the station on the shape, ω how fast the shape turns, N the turning of the normal by the station.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.hand.objects.object import on_surface
from handlcp.lcp.kernels.dense import kernel

_SWEEPS = 40  # over a rectangle, one line after the other
_HALVINGS = 120
_SETTLED = 1e-13  # of the line's half length
_FLAT = 1e-6  # curvature along a line, times the object's size, below which stations do not move


@kernel
def nearest_station(kind: int, sizes: Array, c: Array, spans: Array, at: Array) -> Array:
    """(3,) the station nearest to a shape of this kind and sizes (`on_surface`); c (3,), spans (2, 3) in its axes.
    Writes s and t into at (2,).
    """
    point = c.copy()
    at[0] = at[1] = 0.0
    lines = 0
    for k in range(2):
        if spans[k, 0] != 0.0 or spans[k, 1] != 0.0 or spans[k, 2] != 0.0:
            lines += 1
    for _ in range(_SWEEPS if lines > 1 else lines):
        moved = 0.0
        for k in range(lines):
            before = at[k]
            for a in range(3):
                point[a] -= before * spans[k, a]
            at[k] = _along(kind, sizes, point, spans[k])
            for a in range(3):
                point[a] += at[k] * spans[k, a]
            moved = max(moved, abs(at[k] - before))
        if moved <= _SETTLED:
            break
    return point


@kernel
def _along(kind: int, sizes: Array, c: Array, span: Array) -> float:
    """S in [-1, 1] of the station nearest to the shape: where the slope changes its sign, by false position, the value
    at an end that stays halved (the Illinois method), and every third time in the middle.
    """
    low, high = -1.0, 1.0
    f, g = _slope(kind, sizes, c, span, low), _slope(kind, sizes, c, span, high)
    if f >= 0.0 and g <= 0.0:
        return 0.0
    if f >= 0.0:
        return low
    if g <= 0.0:
        return high
    side, s = 0, 0.0
    for k in range(_HALVINGS):
        s = (low * g - high * f) / (g - f)
        if k % 3 == 2 or not low < s < high:
            s = 0.5 * (low + high)
        h = _slope(kind, sizes, c, span, s)
        if h == 0.0 or high - low <= _SETTLED:
            break
        if h < 0.0:
            low, f = s, h
            g *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            high, g = s, h
            f *= 0.5 if side > 0 else 1.0
            side = 1
    return s


@kernel
def _slope(kind: int, sizes: Array, c: Array, span: Array, s: float) -> float:
    """Of the distance along the line."""
    point = np.empty(3)
    for a in range(3):
        point[a] = c[a] + s * span[a]
    _, _, out = on_surface(kind, sizes, point)
    return float(out[0] * span[0] + out[1] * span[1] + out[2] * span[2])


@kernel
def station_moves(N: Array, normal: Array, spans: Array, at: Array, arm: Array, size: float, moves: Array) -> None:
    """Write moves (3, 6): the motion of the nearest station by that of the shape, (v; ω) of a point `arm` (3,) before
    it. N (3, 3) turns the normal (3,) by the station's motion; spans (2, 3), all in world axes.
    """
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        for j in range(6):
            moves[a, j] = 0.0
        moves[a, a] = 1.0
        moves[a, 3 + b], moves[a, 3 + c] = arm[c], -arm[b]
    D, right, free = np.zeros((2, 2)), np.zeros((2, 6)), np.zeros(2)
    for k in range(2):
        along = N @ spans[k]
        length = spans[k] @ spans[k]
        if length > 0.0 and abs(at[k]) < 1.0 and -(spans[k] @ along) * size > _FLAT * length:
            free[k] = 1.0
            for m in range(2):
                D[m, k] = spans[m] @ along
            across = np.cross(spans[k], normal)
            for j in range(6):
                for a in range(3):
                    right[k, j] -= along[a] * moves[a, j]
                if j >= 3:
                    right[k, j] -= across[j - 3]
    for k in range(2):
        if free[k] == 0.0:
            D[k, :] = D[:, k] = 0.0
            D[k, k] = 1.0
    det = D[0, 0] * D[1, 1] - D[0, 1] * D[1, 0]
    if det == 0.0:
        return
    for j in range(6):
        s = (D[1, 1] * right[0, j] - D[0, 1] * right[1, j]) / det
        t = (D[0, 0] * right[1, j] - D[1, 0] * right[0, j]) / det
        for a in range(3):
            moves[a, j] += s * spans[0, a] + t * spans[1, a]


# ----------------------------------------------------------------
# A corner of an object that stands on a flat face of a link. The contact stays a point of the object, while the face
# moves on below it. Its normal is the face's, and turns with the link; beyond the face's rim it turns about the rim,
# which is round.


@kernel
def corner_contact(
    x: Array, place: Array, R: Array, beside: Array, face: Array, radius: float, normal: Array, turn: Array,
    shift: Array,
) -> float:  # fmt: skip
    """The gap between a corner at x (3,) and a face, a ball of this radius swept about `beside` (3,) along the rows of
    `face` (2, 3), whose product points out of the link: in a frame at place (3,) with rotation R (3, 3). Writes the
    normal (3,), and how it turns and the contact shifts with the link, which moves by v + ω × (x - place): turn, shift
    (3, 6) as in `Touch`.
    """
    d, spans = x - place, np.zeros((2, 3))
    for a in range(3):
        for b in range(3):
            d[a] -= R[a, b] * beside[b]
            for k in range(2):
                spans[k, a] += R[a, b] * face[k, b]
    out = np.cross(spans[0], spans[1])
    out /= np.sqrt(out @ out)
    over = np.zeros((3, 3))  # takes what of a motion changes d: all of it that does not run along the face
    for a in range(3):
        for b in range(3):
            over[a, b] = out[a] * out[b]
    outside = False
    for k in range(2):
        size = spans[k] @ spans[k]
        share = (d @ spans[k]) / size
        if abs(share) > 1.0:
            outside = True
            for a in range(3):
                for b in range(3):
                    over[a, b] += spans[k, a] * spans[k, b] / size
        d = d - min(max(share, -1.0), 1.0) * spans[k]
    away = np.sqrt(d @ d) if outside else d @ out
    normal[:] = d / away if outside else out
    turn[:], shift[:] = 0.0, 0.0
    arm, e = x - place, np.zeros(3)
    for a in range(3):
        e[:] = 0.0
        e[a] = 1.0
        turn[:, 3 + a] = np.cross(e, normal)
        if outside:
            moved, turned = over @ e, over @ np.cross(e, arm)
            turn[:, a] = -(moved - normal * (normal @ moved)) / away
            turn[:, 3 + a] -= (turned - normal * (normal @ turned)) / away
    return float(away) - radius
