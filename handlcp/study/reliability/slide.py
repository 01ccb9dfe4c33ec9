"""Contacts slid along the object's surface, many at once.

Past an edge of a box or a rim of a cylinder a contact has no normal: it is on two faces, and a fingertip rolls around
the edge. Such a contact keeps its axes, and is named as one that is past an edge.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.surface import BOX, CYLINDER, touched

_TURNED = 1e-6  # of a normal that has one direction on a whole face: more is another face


def slid(positions: Array, frames: Array, shifts: Array, obj: Object | None) -> tuple[Array, Array, Bools]:
    """Positions (m, k, 3) and frames (m, k, 3, 3) of k contacts after m shifts (m, k, 2) [m] along their tangents, and
    which of them (m, k) are past an edge.

    On a ball, a box, a cylinder or an ellipsoid a contact stays on the surface, and its normal turns with that. On
    anything else, or without an object (None), it moves in its tangent plane, and keeps its normal.
    """
    m, k = len(shifts), len(positions)
    goal = positions + np.einsum("kab,mkb->mka", frames[:, :, :2], shifts)
    if obj is None or obj.known is None:
        return goal, np.broadcast_to(frames, (m, k, 3, 3)), np.zeros((m, k), bool)
    on, inward = _nearest(np.concatenate([positions, goal.reshape(-1, 3)]), obj)
    moved = positions + (on[k:].reshape(m, k, 3) - on[:k])
    turned = inward[k:].reshape(m, k, 3) - inward[:k]
    past = _past_an_edge(turned, obj)
    z = frames[:, :, 2] + np.where(past[..., None], 0.0, turned)
    z = z / np.sqrt((z * z).sum(axis=-1, keepdims=True))
    x = frames[:, :, 0] - z * (z * frames[:, :, 0]).sum(axis=-1, keepdims=True)
    x = x / np.sqrt((x * x).sum(axis=-1, keepdims=True))
    made = np.stack([x, np.cross(z, x), z], axis=-1)
    stays = (turned == 0.0).all(axis=-1) | past
    return moved, np.where(stays[..., None, None], frames, made), past


def _past_an_edge(turned: Array, obj: Object) -> Bools:
    """(m, k) from how normals (m, k, 3) have turned: on a box not at all; on a cylinder not towards its axis."""
    assert obj.known is not None
    kind, (R, _) = obj.known[0], obj.frame
    if kind == BOX:
        return np.asarray((abs(turned) > _TURNED).any(axis=-1))
    if kind == CYLINDER:
        return np.asarray(abs(turned @ R[:, 2]) > _TURNED)
    return np.zeros(turned.shape[:-1], bool)


def _nearest(points: Array, obj: Object) -> tuple[Array, Array]:
    """(n, 3) nearest points of the surface, and (n, 3) the normals into the object there."""
    assert obj.known is not None
    (kind, sizes), (R, p) = obj.known, obj.frame
    on, inward = np.empty_like(points), np.empty_like(points)
    touched(kind, sizes, R, p, points, np.zeros(len(points)), on, inward, np.empty(len(points)))
    return on, inward
