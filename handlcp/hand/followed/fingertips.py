"""Which way a hand's fingertips find their contacts while the object moves: compiled, by detection, or as given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.objects.detect import nearest
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.surface import touched

__all__ = ["Find", "finger_contacts"]

# (places (n, 3), turns (n, 3, 3) of fingertips, R (3, 3), t (3,) of the object's motion, and what is written: positions
# (n, 3), normals (n, 3), gaps (n,)), the first k rows of which belong to fingers
Find = Callable[[Array, Array, Array, Array, Array, Array, Array], None]


def finger_contacts(hand: Any, spec: GraspSpec, mechanism: Any) -> Find:
    """For the k fingers of a grasp. hand : a `HandModel`; mechanism : its `HandMechanism`."""
    if mechanism.target is None:
        return _given(spec, mechanism)
    shapes = [hand.tip_shapes(i) for i in mechanism.tips]
    solid = mechanism.target.known
    if solid is not None and all(len(s) == 1 and s[0].radius is not None for s in shapes):
        return _balls(solid, mechanism.target, [s[0] for s in shapes])
    return _detected(mechanism.target, shapes)


def _balls(solid: tuple[int, Array], obj: Object, tips: list[Any]) -> Find:
    kind, sizes = solid
    own, at = np.ascontiguousarray(obj.placement.rotation), obj.placement.translation.copy()
    radii, k = np.array([tip.radius for tip in tips]), len(tips)
    beside = np.array([tip.translation for tip in tips])
    central = not beside.any()

    def find(places: Array, turns: Array, R: Array, t: Array, positions: Array, normals: Array, gaps: Array) -> None:
        centres = places[:k] if central else places[:k] + np.einsum("nij,nj->ni", turns[:k], beside)
        touched(kind, sizes, R @ own, R @ at + t, centres, radii, positions[:k], normals[:k], gaps[:k])

    return find


def _detected(obj: Object, shapes: list[Any]) -> Find:
    """Detected where the object was at the start: fingertips are moved back instead of the object."""

    def find(places: Array, turns: Array, R: Array, t: Array, positions: Array, normals: Array, gaps: Array) -> None:
        for i, tip in enumerate(shapes):
            near = nearest(tip, R.T @ (places[i] - t), R.T @ turns[i], obj)
            positions[i], normals[i], gaps[i] = R @ near.position + t, R @ near.normal, near.gap

    return find


def _given(spec: GraspSpec, mechanism: Any) -> Find:
    """Points of the fingertips, on planes of the object."""
    k, tips, first = len(mechanism.tips), list(mechanism.tips), mechanism.posture
    turned = first.tip_rotations[tips]
    points = np.einsum("nji,nj->ni", turned, spec.positions[:k] - first.tip_positions[tips])
    planes, out = spec.positions[:k], spec.frames[:k, :, 2]

    def find(places: Array, turns: Array, R: Array, t: Array, positions: Array, normals: Array, gaps: Array) -> None:
        touching = places[:k] + np.einsum("nij,nj->ni", turns[:k], points)
        normals[:k] = out @ R.T
        gaps[:k] = (normals[:k] * (planes @ R.T + t - touching)).sum(axis=1)
        positions[:k] = touching + gaps[:k, None] * normals[:k]

    return find
