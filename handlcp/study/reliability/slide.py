"""Contacts slid along the object's surface, many at once."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.surface import touched

__all__ = ["slid"]


def slid(positions: Array, frames: Array, shifts: Array, obj: Object | None) -> tuple[Array, Array]:
    """Positions (m, k, 3) and frames (m, k, 3, 3) of k contacts after m shifts (m, k, 2) [m] along their tangents.

    On a ball, a box, a cylinder or an ellipsoid a contact stays on the surface, and its normal turns with that. On
    anything else, or without an object (None), it moves in its tangent plane, and keeps its normal.
    """
    m, k = len(shifts), len(positions)
    goal = positions + np.einsum("kab,mkb->mka", frames[:, :, :2], shifts)
    if obj is None or obj.known is None:
        return goal, np.broadcast_to(frames, (m, k, 3, 3))
    on, inward = _nearest(np.concatenate([positions, goal.reshape(-1, 3)]), obj)
    moved = positions + (on[k:].reshape(m, k, 3) - on[:k])
    turned = inward[k:].reshape(m, k, 3) - inward[:k]
    z = frames[:, :, 2] + turned
    z = z / np.sqrt((z * z).sum(axis=-1, keepdims=True))
    x = frames[:, :, 0] - z * (z * frames[:, :, 0]).sum(axis=-1, keepdims=True)
    x = x / np.sqrt((x * x).sum(axis=-1, keepdims=True))
    made = np.stack([x, np.cross(z, x), z], axis=-1)
    stays = (turned == 0.0).all(axis=-1, keepdims=True)[..., None]
    return moved, np.where(stays, frames, made)


def _nearest(points: Array, obj: Object) -> tuple[Array, Array]:
    """(n, 3) nearest points of the surface, and (n, 3) the normals into the object there."""
    assert obj.known is not None
    (kind, sizes), (R, p) = obj.known, obj.frame
    on, inward = np.empty_like(points), np.empty_like(points)
    touched(kind, sizes, R, p, points, np.zeros(len(points)), on, inward, np.empty(len(points)))
    return on, inward
