"""Compiled contact physics for the certifier: recomputed from positions, frames and flexibility, from no matrix of the solver."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.compile import kernel

__all__ = ["check_contacts", "nearest_in_polygon", "relative_motion"]


@kernel
def relative_motion(arms: Array, frames: Array, flexibility: Array, offset: Array, forces: Array, twist: Array) -> tuple[Array, Array]:
    """v = Rᵀ(u + ω × a) + E r + d for every contact, and its scale.

    arms (n, 3) contact points from the centre that twist (6,) refers to, frames (n, 3, 3), flexibility (3n, 3n),
    offset and forces (n, 3) in contact axes. Returns v (n, 3) and (n,): the largest term of each contact's own sum.
    """
    n = len(arms)
    v, scale = np.empty((n, 3)), np.zeros(n)
    u = np.empty(3)
    for i in range(n):
        a = arms[i]
        u[0] = twist[0] + twist[4] * a[2] - twist[5] * a[1]
        u[1] = twist[1] + twist[5] * a[0] - twist[3] * a[2]
        u[2] = twist[2] + twist[3] * a[1] - twist[4] * a[0]
        for k in range(3):
            move = frames[i, 0, k] * u[0] + frames[i, 1, k] * u[1] + frames[i, 2, k] * u[2]
            retreat = 0.0
            for j in range(n):
                for m in range(3):
                    retreat += flexibility[3 * i + k, 3 * j + m] * forces[j, m]
            v[i, k] = move + retreat + offset[i, k]
            scale[i] = max(scale[i], abs(move), abs(retreat), abs(offset[i, k]))
    return v, scale


@kernel
def nearest_in_polygon(x: float, y: float, apothem: float, faces: int) -> tuple[float, float]:
    """The point nearest to (x, y) of the regular polygon with that apothem and outward normals at 2πj/m from the x axis.

    faces = 2: the interval [-apothem, apothem] of the x axis. faces = 0: the disc of that radius.
    """
    if apothem <= 0.0:
        return 0.0, 0.0
    if faces == 2:
        return min(max(x, -apothem), apothem), 0.0
    if faces == 0:
        r = np.sqrt(x * x + y * y)
        return (x, y) if r <= apothem else (x * apothem / r, y * apothem / r)
    step = 2.0 * np.pi / faces
    j = np.round(np.arctan2(y, x) / step)
    c, s = np.cos(j * step), np.sin(j * step)
    outward, along = c * x + s * y, c * y - s * x
    if outward <= apothem:
        return x, y
    half = apothem * np.tan(0.5 * step)
    along = min(max(along, -half), half)
    return c * apothem - s * along, s * apothem + c * along


@kernel
def check_contacts(forces: Array, v: Array, limits: Array, governed: Array, faces: int, F: float, V: Array) -> tuple[float, float, float]:
    """Worst (normal, cone, slip) residual over the governed contacts, each relative to F [N] and V (n,) [m].

    normal: |min(r_N / F, v_N / V)|. cone: excess of r_T over the polygon of apothem limits·r_N, / F.
    slip: distance of r_T / F from the projection of r_T / F - v_T / V on that polygon; zero exactly when the contact
    sticks, or slides against a force on the limit (maximum dissipation).
    """
    normal, cone, slip = 0.0, 0.0, 0.0
    for i in range(len(forces)):
        if not governed[i]:
            continue
        x, y, z = forces[i, 0] / F, forces[i, 1] / F, forces[i, 2] / F
        normal = max(normal, abs(min(z, v[i, 2] / V[i])))
        if limits[i] <= 0.0:
            cone = max(cone, np.sqrt(x * x + y * y))
            continue
        a = limits[i] * z
        px, py = nearest_in_polygon(x, y, a, faces)
        cone = max(cone, np.sqrt((x - px) ** 2 + (y - py) ** 2))
        wy = 0.0 if faces == 2 else v[i, 1] / V[i]
        px, py = nearest_in_polygon(x - v[i, 0] / V[i], y - wy, a, faces)
        slip = max(slip, np.sqrt((x - px) ** 2 + (y - py) ** 2))
    return normal, cone, slip
