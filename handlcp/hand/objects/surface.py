"""The nearest point on the surface of a ball, a box, a cylinder or an ellipsoid, compiled; each in its own axes."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.dense import kernel

BALL, BOX, CYLINDER, ELLIPSOID = 0, 1, 2, 3


@kernel
def touched(
    kind: int, sizes: Array, R: Array, p: Array, centres: Array, radii: Array, positions: Array, normals: Array,
    gaps: Array,
) -> None:  # fmt: skip
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
        distance, x, out = on_surface(kind, sizes, c)
        gaps[i] = distance - radii[i]
        for b in range(3):
            positions[i, b], normals[i, b] = p[b], 0.0
            for a in range(3):
                positions[i, b] += R[b, a] * x[a]
                normals[i, b] -= R[b, a] * out[a]


@kernel
def on_surface(kind: int, sizes: Array, c: Array) -> tuple[float, Array, Array]:
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
    """Outside: clamped to the box. Inside: straight out through the nearest face."""
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
    """Outside: clamped to the lateral surface and the ends. Inside: straight out through the nearer of the two."""
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
