"""The solids of a picture beside the hand: the object, the environment, rods for unknown fingers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp import Grasp
from handlcp.show.picture import shapes

Colour = tuple[float, float, float]  # red, green, blue from 0 to 1

HAND, OBJECT, ENVIRONMENT = (0.62, 0.65, 0.69), (0.90, 0.70, 0.30), (0.80, 0.78, 0.74)


@dataclass(frozen=True, slots=True)
class Body:
    """triangles (m, 3, 3) [m], world axes. label : for the legend. link : the name of a hand's link, "" for others.
    marked : whether to mark it.
    """

    triangles: Array
    colour: Colour
    label: str = ""
    link: str = ""
    marked: bool = False


def object_body(grasp: Grasp, obj: Any = None) -> Body | None:
    """The object; the hull of the contacts where the object is not known; None where they span no volume."""
    obj = getattr(grasp, "target", None) if obj is None else obj
    if obj is not None:
        known = obj.triangles if obj.triangles is not None else shapes.of_coal(obj.geometry)
        if known is not None:
            return Body(shapes.placed(known, obj.placement), OBJECT, "object")
    hull = shapes.hull(grasp.scene.positions, 0.3 * grasp.scene.units.length)
    return None if hull is None else Body(hull, OBJECT, "hull of the contacts")


def stub_bodies(grasp: Grasp) -> list[Body]:
    """For a grasp without a hand: a short rod behind each contact of a finger, ending at the contact."""
    size = grasp.scene.units.length
    r = 0.08 * size
    fingers = grasp.scene.n - grasp.scene.environment
    pairs = zip(grasp.scene.positions[:fingers], grasp.scene.frames[:fingers, :, 2], strict=True)
    return [Body(shapes.capsule(p - n * 0.75 * size, p - n * r, r), HAND) for p, n in pairs]


def environment_bodies(grasp: Grasp) -> list[Body]:
    """A slab under each set of environment contacts in one plane, wider by half a grasp's size on every side."""
    scene, out = grasp.scene, []
    size, left = scene.units.length, list(range(scene.n - scene.environment, scene.n))
    thick = 0.1 * size
    while left:
        R, p = scene.frames[left[0]], scene.positions[left[0]]
        local = (scene.positions[left] - p) @ R
        same = (abs(local[:, 2]) < 1e-2 * size) & (scene.frames[left][:, :, 2] @ R[:, 2] > 1 - 1e-6)
        low, high = local[same, :2].min(axis=0) - 0.5 * size, local[same, :2].max(axis=0) + 0.5 * size
        slab = shapes.box([*(high - low), thick]) + np.array([*(low + high) / 2, -thick / 2])
        out.append(Body(slab @ R.T + p, ENVIRONMENT))
        left = [i for i, there in zip(left, same.tolist(), strict=True) if not there]
    return out
