"""Balls on surfaces that are known in closed form, compiled: contacts, and how they turn and shift as balls move."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.hand.followed.contacts import contacts_at
from handlcp.hand.objects.surface import on_surface
from handlcp.lcp.kernels.dense import kernel, product

_STEP = 1e-6  # of the object's size: central differences of normals, good to ten digits


@kernel
def ball_look(
    placements: Array, columns: Array, support: Array, coupling: Array, pads: Array, around: Array, kind: int,
    sizes: Array, own: Array, at: Array, beside: Array, radii: Array, R: Array, t: Array, give: Array, old: Array,
    places: Array, turns: Array, positions: Array, normals: Array, gaps: Array, turn: Array, shift: Array,
    frames: Array, P: Array, J: Array, turning: Array,
) -> None:  # fmt: skip
    """Write all that a look knows of contacts that are balls of fingers alone: see `ball_contacts`, `contacts_at`.

    placements (k, 4, 4) : of the fingertips, give (k, 3) : of their pads. The object has moved by x ↦ R x + t; own
    (3, 3), at (3,) : its shape's axes and frame before.
    """
    p = np.empty(3)
    for a in range(3):
        p[a] = t[a] + R[a, 0] * at[0] + R[a, 1] * at[1] + R[a, 2] * at[2]
    for i in range(len(radii)):
        for a in range(3):
            places[i, a] = placements[i, a, 3] + give[i, a]
            for b in range(3):
                turns[i, a, b] = placements[i, a, b]
    ball_contacts(kind, sizes, product(R, own), p, places, turns, beside, radii, positions, normals, gaps, turn, shift)
    contacts_at(
        columns, support, coupling, pads, around, turns, positions, old, normals, frames, P, J, turning
    )  # fmt: skip


@kernel
def ball_contacts(
    kind: int, sizes: Array, R: Array, p: Array, places: Array, turns: Array, beside: Array, radii: Array,
    positions: Array, normals: Array, gaps: Array, turn: Array, shift: Array,
) -> None:  # fmt: skip
    """Write the contacts of k balls with a shape of this kind and sizes (3,), whose axes are the columns of R and whose
    frame is at p: positions, normals, gaps, turn, shift as in `Touch`.

    places (n, 3), turns (n, 3, 3) : of the fingertips. beside (k, 3), radii (k,) : of their balls, in tip axes.
    """
    arm, c, out, step = np.empty(3), np.empty(3), np.empty(3), _STEP * sizes.max()
    H, N = np.empty((3, 3)), np.empty((3, 3))
    for i in range(len(radii)):
        for a in range(3):
            arm[a] = 0.0
            for b in range(3):
                arm[a] += turns[i, a, b] * beside[i, b]
        for a in range(3):
            c[a] = 0.0
            for b in range(3):
                c[a] += R[b, a] * (places[i, b] + arm[b] - p[b])
        distance, x, out = on_surface(kind, sizes, c)
        for a in range(3):
            kept = c[a]
            c[a] = kept + step
            _, _, ahead = on_surface(kind, sizes, c)
            c[a] = kept - step
            _, _, back = on_surface(kind, sizes, c)
            c[a] = kept
            for b in range(3):
                H[b, a] = -(ahead[b] - back[b]) / (2.0 * step)
        for a in range(3):
            for b in range(3):
                N[a, b] = 0.0
                for e in range(3):
                    if H[e, 0] != 0.0 or H[e, 1] != 0.0 or H[e, 2] != 0.0:
                        N[a, b] += R[a, e] * (H[e, 0] * R[b, 0] + H[e, 1] * R[b, 1] + H[e, 2] * R[b, 2])
        gaps[i] = distance - radii[i]
        for b in range(3):
            positions[i, b], normals[i, b] = p[b], 0.0
            for a in range(3):
                positions[i, b] += R[b, a] * x[a]
                normals[i, b] -= R[b, a] * out[a]
        moved_along(turn[i], shift[i], N, normals[i], distance, arm)


@kernel
def moved_along(turn: Array, shift: Array, N: Array, normal: Array, distance: float, arm: Array) -> None:
    """Write turn, shift (3, 6) of a contact that follows a point of the fingertip, `arm` (3,) away from its place:
    N (3, 3) turns the normal by the point's motion, and with d the point's distance the contact at x = p + d n moves by
    (1 - n nᵀ + d N).
    """
    for a in range(3):
        for b in range(3):
            turn[a, b] = N[a, b]
            shift[a, b] = distance * N[a, b] - normal[a] * normal[b]
        shift[a, a] += 1.0
    for a in range(3):  # the point moves by v + ω × arm
        for rows in (turn, shift):
            x, y, z = rows[a, 0], rows[a, 1], rows[a, 2]
            rows[a, 3] = arm[1] * z - arm[2] * y
            rows[a, 4] = arm[2] * x - arm[0] * z
            rows[a, 5] = arm[0] * y - arm[1] * x
