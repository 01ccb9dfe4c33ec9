"""`closest_on_surface`: nearest points of simple shapes, and of balls swept along a line or over a rectangle.

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
from handlcp.lcp.kernels.dense import kernel

# ----------------------------------------------------------------
# The nearest point on the surface of a ball, a box, a cylinder or an ellipsoid, compiled; each in its own axes.

BALL, BOX, CYLINDER, ELLIPSOID = 0, 1, 2, 3


@kernel
def write_ball_proximities(
    kind: int,
    sizes: Array,
    R: Array,
    p: Array,
    centres: Array,
    radii: Array,
    positions: Array,
    normals: Array,
    gaps: Array,
) -> None:
    """Write where balls with these centres (n, 3) and radii (n,) are nearest to a shape of this kind and sizes (3,),
    whose axes are the columns of R and whose frame is at p: positions (n, 3) on the shape, normals (n, 3) from the ball
    into the shape, gaps (n,).
    """
    c = np.empty(3)
    for i in range(len(centres)):
        for a in range(3):
            c[a] = 0.0
            for b in range(3):
                c[a] += R[b, a] * (centres[i, b] - p[b])
        distance, x, out = closest_on_surface(kind, sizes, c)
        gaps[i] = distance - radii[i]
        write_contact(R, p, x, out, positions[i], normals[i])


@kernel
def write_contact(R: Array, p: Array, x: Array, out: Array, position: Array, normal: Array) -> None:
    """Write position p + R x and normal -R out, each (3,), of a point x on a shape and its outward normal there, whose
    axes are the columns of R and whose frame is at p.
    """
    for b in range(3):
        position[b], normal[b] = p[b], 0.0
        for a in range(3):
            position[b] += R[b, a] * x[a]
            normal[b] -= R[b, a] * out[a]


@kernel
def closest_on_surface(kind: int, sizes: Array, c: Array) -> tuple[float, Array, Array]:
    """Signed distance of a point c (3,), nearest point on the surface, outward normal there. sizes (3,) : radius of a
    ball; half the edges of a box; radius and half the length of a cylinder; semi-axes of an ellipsoid.
    """
    if kind == BALL:
        return _on_ball(sizes[0], c)
    if kind == BOX:
        return _on_box(sizes, c)
    if kind == CYLINDER:
        return _on_cylinder(sizes[0], sizes[1], c)
    return _on_ellipsoid(sizes, c)


@kernel
def _on_ball(radius: float, c: Array) -> tuple[float, Array, Array]:
    """Along the line from the centre; at the centre any way out is as long, and the one along x is taken."""
    away = np.sqrt(c[0] ** 2 + c[1] ** 2 + c[2] ** 2)
    out = np.zeros(3)
    if away > 0.0:
        out[:] = c / away
    else:
        out[0] = 1.0
    return away - radius, radius * out, out


@kernel
def _on_box(half: Array, c: Array) -> tuple[float, Array, Array]:
    """As `closest_on_surface`: clamped to the box, from inside straight out through the nearest face."""
    x, out = np.empty(3), np.zeros(3)
    beyond, face, nearest = 0.0, 0, -np.inf
    for a in range(3):
        x[a] = min(max(c[a], -half[a]), half[a])
        out[a] = c[a] - x[a]
        beyond += out[a] ** 2
        if abs(c[a]) - half[a] > nearest:
            face, nearest = a, abs(c[a]) - half[a]
    if beyond > 0.0:
        distance = np.sqrt(beyond)
        return distance, x, out / distance
    out[face] = 1.0 if c[face] >= 0.0 else -1.0
    x[face] = out[face] * half[face]
    return nearest, x, out


@kernel
def _on_cylinder(radius: float, half: float, c: Array) -> tuple[float, Array, Array]:
    """As `closest_on_surface`: clamped to the side and the ends, from inside straight out through the nearer one."""
    away = np.sqrt(c[0] ** 2 + c[1] ** 2)
    a, b = (c[0] / away, c[1] / away) if away > 0.0 else (1.0, 0.0)
    side = 1.0 if c[2] >= 0.0 else -1.0
    beside, above = away - radius, abs(c[2]) - half
    if beside > 0.0 and above > 0.0:  # nearest to the rim
        distance = np.sqrt(beside**2 + above**2)
        out = np.array([a * beside, b * beside, side * above]) / distance
        return distance, np.array([a * radius, b * radius, side * half]), out
    if beside > above:
        return beside, np.array([a * radius, b * radius, c[2]]), np.array([a, b, 0.0])
    return above, np.array([c[0], c[1], side * half]), np.array([0.0, 0.0, side])


@kernel
def _on_ellipsoid(radii: Array, c: Array) -> tuple[float, Array, Array]:
    """X = a² c / (t + a²) with |x / a| = 1, radii a. Newton's method finds t from the left (convex)."""
    squares = radii * radii
    weights = squares * c * c
    if weights.max() <= 0.0:  # at the centre the shortest semi-axis is the way out
        x = np.zeros(3)
        x[np.argmin(squares)] = radii.min()
    else:
        t = np.max(np.sqrt(weights) - squares)
        for _ in range(100):
            d = t + squares
            step = ((weights / (d * d)).sum() - 1.0) / (2.0 * (weights / (d * d * d)).sum())
            t += step
            if not step > 1e-16 * abs(t):
                break
        x = squares * c / (t + squares)
    n = x / squares
    n /= np.sqrt((n * n).sum())
    return (n * (c - x)).sum(), x, n


# ----------------------------------------------------------------
# Where a ball that is swept along a line or over a rectangle is nearest to such a surface.

_MAX_SWEEPS = 40  # over a rectangle, one line after the other
_MAX_HALVINGS = 120
_STATION_TOLERANCE = 1e-13  # of the line's half length
_MIN_CURVATURE = 1e-6  # curvature along a line, times the object's size, below which stations do not move


@kernel
def nearest_station(kind: int, sizes: Array, c: Array, spans: Array, at: Array) -> Array:
    """(3,) the station nearest to a shape of this kind and sizes (`closest_on_surface`); c (3,), spans (2, 3) in its
    axes. Writes s and t into at (2,).
    """
    point = c.copy()
    at[0] = at[1] = 0.0
    lines = 0
    for k in range(2):
        if spans[k, 0] != 0.0 or spans[k, 1] != 0.0 or spans[k, 2] != 0.0:
            lines += 1
    for _ in range(_MAX_SWEEPS if lines > 1 else lines):
        moved = 0.0
        for k in range(lines):
            before = at[k]
            for a in range(3):
                point[a] -= before * spans[k, a]
            at[k] = _nearest_on_line(kind, sizes, point, spans[k])
            for a in range(3):
                point[a] += at[k] * spans[k, a]
            moved = max(moved, abs(at[k] - before))
        if moved <= _STATION_TOLERANCE:
            break
    return point


@kernel
def _nearest_on_line(kind: int, sizes: Array, c: Array, span: Array) -> float:
    """S in [-1, 1] of the station nearest to the shape: where the slope changes its sign, by false position, the value
    at an end that stays halved (the Illinois method), and every third time in the middle.
    """
    low, high = -1.0, 1.0
    f, g = _distance_slope(kind, sizes, c, span, low), _distance_slope(kind, sizes, c, span, high)
    if f >= 0.0 and g <= 0.0:
        return 0.0
    if f >= 0.0:
        return low
    if g <= 0.0:
        return high
    side, s = 0, 0.0
    for k in range(_MAX_HALVINGS):
        s = (low * g - high * f) / (g - f)
        if k % 3 == 2 or not low < s < high:
            s = 0.5 * (low + high)
        h = _distance_slope(kind, sizes, c, span, s)
        if h == 0.0 or high - low <= _STATION_TOLERANCE:
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
def _distance_slope(kind: int, sizes: Array, c: Array, span: Array, s: float) -> float:
    """Of the distance along the line."""
    point = np.empty(3)
    for a in range(3):
        point[a] = c[a] + s * span[a]
    _, _, out = closest_on_surface(kind, sizes, point)
    return float(out[0] * span[0] + out[1] * span[1] + out[2] * span[2])


@kernel
def write_station_motion(
    N: Array, normal: Array, spans: Array, at: Array, arm: Array, size: float, moves: Array
) -> None:
    """Write how the nearest station moves, moves (3, 6), with (v; ω) of a point `arm` (3,) before it; world axes."""
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
        if length > 0.0 and abs(at[k]) < 1.0 and -(spans[k] @ along) * size > _MIN_CURVATURE * length:
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

TILT_ANGLE = 2e-3  # [rad] by which a shape is tilted to see where it touches: at a point, or flat


@kernel
def write_corner_contact(
    x: Array,
    place: Array,
    R: Array,
    beside: Array,
    face: Array,
    radius: float,
    normal: Array,
    turn: Array,
    shift: Array,
) -> float:
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


# ----------------------------------------------------------------
# Where what is round touches a plane.

LYING_SINE = 0.2  # sine of the angle between a cylinder's axis and the plane's normal: less, and it stands on its rim


@kernel
def rolling_point(kind: int, sizes: Array, R: Array, p: Array, normal: Array, near: Array, out: Array) -> bool:
    """Whether a shape of this kind and sizes, whose axes are the columns of R and whose frame is at p, rolls on a plane
    with this unit normal (3,). Writes the point (3,) where it touches it; of a cylinder, on the rim nearer to `near`
    (3,).
    """
    down, size = np.empty(3), 0.0
    for a in range(3):
        down[a] = -(R[0, a] * normal[0] + R[1, a] * normal[1] + R[2, a] * normal[2])
    if kind == BALL:
        down *= sizes[0]
    elif kind == ELLIPSOID:
        for a in range(3):
            down[a] *= sizes[a]
            size += down[a] ** 2
        down *= sizes / np.sqrt(size)
    elif kind == CYLINDER:
        leaning, above = np.sqrt(down[0] ** 2 + down[1] ** 2), 0.0
        if not leaning > LYING_SINE:
            return False
        for a in range(3):
            above += R[a, 2] * (near[a] - p[a])
        down[0], down[1] = sizes[0] * down[0] / leaning, sizes[0] * down[1] / leaning
        down[2] = sizes[1] if above > 0.0 else -sizes[1]
    else:
        return False
    for a in range(3):
        out[a] = p[a] + R[a, 0] * down[0] + R[a, 1] * down[1] + R[a, 2] * down[2]
    return True
