"""Compiled contact physics for the certifier, from positions, frames and flexibility: no matrix of the solver."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.compile import kernel

__all__ = ["examine", "nearest_in_polygon", "to_world"]


@kernel
def relative_motion(
    arms: Array, frames: Array, flexibility: Array, offset: Array, forces: Array, twist: Array
) -> tuple[Array, Array]:
    """V = Rᵀ(u + ω × a) + E r + d for every contact, and its scale.

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
    """The point nearest to (x, y) of the regular polygon with that apothem, outward normals at 2πj/m from the x axis.

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
def check_contacts(
    forces: Array, v: Array, limits: Array, governed: Bools, faces: int, F: float, V: Array
) -> tuple[float, float, float]:
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


@kernel
def unbalanced(arms: Array, frames: Array, forces: Array, wrench: Array) -> tuple[float, float]:
    """(force [N], moment [N·m]) that forces (n, 3), contact axes, leave of wrench (6,) about the arms' origin."""
    lost = wrench.copy()
    for i in range(len(arms)):
        ax, ay, az = arms[i, 0], arms[i, 1], arms[i, 2]
        x, y, z = 0.0, 0.0, 0.0
        for k in range(3):
            x += frames[i, 0, k] * forces[i, k]
            y += frames[i, 1, k] * forces[i, k]
            z += frames[i, 2, k] * forces[i, k]
        lost[0] += x
        lost[1] += y
        lost[2] += z
        lost[3] += ay * z - az * y
        lost[4] += az * x - ax * z
        lost[5] += ax * y - ay * x
    return np.sqrt(lost[0] ** 2 + lost[1] ** 2 + lost[2] ** 2), np.sqrt(lost[3] ** 2 + lost[4] ** 2 + lost[5] ** 2)


@kernel
def scales(
    wrench: Array,
    forces: Array,
    length: float,
    unit: float,
    floor: float,
    flexibility: Array,
    offset: Array,
    own: Array,
    growth: float,
) -> tuple[float, Array]:
    """(F, V): the force [N] and each contact's motion (n,) [m] that residuals are measured by.

    F is the largest force of the candidate, at least the load's size (`unit` where there is no load) and at most
    `growth` times that. V is the largest term of the contact's own motion `own`, at least its retreat under F.
    """
    load = 0.0
    for k in range(6):
        load += (wrench[k] / (length if k >= 3 else 1.0)) ** 2
    load = np.sqrt(load)
    if load == 0.0:
        load = unit
    F = min(max(np.max(np.abs(forces)), load), growth * load)
    V = np.empty(len(forces))
    for i in range(len(forces)):
        retreat = (
            (flexibility[3 * i, 3 * i] + flexibility[3 * i + 1, 3 * i + 1] + flexibility[3 * i + 2, 3 * i + 2])
            * F
            / 3.0
        )
        # A long slide excuses no overlap: beyond `growth` times what the finger itself can give way, no more allowance
        give = max(retreat, np.max(np.abs(offset[i])))
        V[i] = max(min(own[i], growth * give) if give > 0.0 else own[i], retreat, floor)
    return F, V


@kernel
def examine(
    arms: Array,
    frames: Array,
    flexibility: Array,
    offset: Array,
    forces: Array,
    twist: Array,
    wrench: Array,
    limits: Array,
    governed: Bools,
    faces: int,
    length: float,
    unit: float,
    floor: float,
    growth: float,
) -> tuple[Array, tuple[float, float, float, float, float, float, float, float]]:
    """The certifier's numbers: v (n, 3), (lost force [N], lost moment [N·m], balance, normal, cone, slip, F, max V).

    NaN throughout where a force or the twist is not finite.
    """
    if not (np.isfinite(forces).all() and np.isfinite(twist).all()):
        nan = np.nan
        return np.full(forces.shape, nan), (nan, nan, nan, nan, nan, nan, nan, nan)
    v, own = relative_motion(arms, frames, flexibility, offset, forces, twist)
    lost_force, lost_moment = unbalanced(arms, frames, forces, wrench)
    F, V = scales(wrench, forces, length, unit, floor, flexibility, offset, own, growth)
    normal, cone, slip = check_contacts(forces, v, limits, governed, faces, F, V)
    balance = np.sqrt(lost_force**2 + (lost_moment / length) ** 2) / F
    return v, (lost_force, lost_moment, balance, normal, cone, slip, F, np.max(V))


@kernel
def to_world(frames: Array, vectors: Array) -> Array:
    """(n, 3) from contact axes to world axes."""
    n = len(vectors)
    out = np.empty((n, 3))
    for i in range(n):
        for k in range(3):
            out[i, k] = (
                frames[i, k, 0] * vectors[i, 0] + frames[i, k, 1] * vectors[i, 1] + frames[i, k, 2] * vectors[i, 2]
            )
    return out
