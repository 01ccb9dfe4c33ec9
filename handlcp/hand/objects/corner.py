"""A corner of an object that stands on a flat face of a link, compiled.

The contact stays a point of the object, while the face moves on below it. Its normal is the face's, and turns with the
link; beyond the face's rim it turns about the rim, which is round.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.dense import kernel


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
