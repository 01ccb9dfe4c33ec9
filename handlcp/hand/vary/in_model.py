"""Other lengths and places in a pinocchio.Model, and in the geometry that came with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.hand.robot.source.part import Part
from handlcp.hand.vary.stretch import Stretch

Given = tuple[tuple[str, tuple[Part, ...]], ...]


def put_joint(model: Any, name: str, position: Array) -> None:
    """A joint stands elsewhere, (3,) [m] in the frame of its parent; the model is changed."""
    joint = model.getJointId(name)
    frame = model.frames[model.getFrameId(name, pin.FrameType.JOINT)]
    parent = model.frames[frame.parentFrame].placement
    place = pin.SE3(model.jointPlacements[joint])
    place.translation = parent.act(position)
    model.jointPlacements[joint] = place


def stretch_model(model: Any, stretches: Mapping[int, Stretch]) -> None:
    """Lengths by the number of the joint where they begin; the model is changed."""
    for k in range(1, model.njoints):
        if (stretch := stretches.get(int(model.parents[k]))) is not None:
            model.jointPlacements[k] = _moved(model.jointPlacements[k], stretch)
        if (stretch := stretches.get(k)) is not None:
            model.inertias[k].lever = stretch.point(model.inertias[k].lever)
    for frame in model.frames:
        if (stretch := stretches.get(int(frame.parentJoint))) is not None:
            frame.placement = _moved(frame.placement, stretch)


def stretch_parts(given: Given, model: Any, stretches: Mapping[int, Stretch]) -> tuple[Given, list[str]]:
    """The geometry; model : as it was before. And names of links with meshes that keep their shape, all of them."""
    kinds, kept = list[tuple[str, tuple[Part, ...]]](), list[str]()
    for kind, parts in given:
        made = []
        for part in parts:
            frame = model.frames[part.frame]
            stretch = stretches.get(int(frame.parentJoint))
            local = None if stretch is None else stretch.in_link(frame.placement)
            if local is not None and isinstance(part.shape, (coal.BVHModelBase, coal.ConvexBase)):
                kept.append(frame.name)
            made.append(part if local is None else _stretched(part, local))
        kinds.append((kind, tuple(made)))
    return tuple(kinds), list(dict.fromkeys(kept))


def _moved(placement: Any, stretch: Stretch) -> Any:
    return pin.SE3(placement.rotation, stretch.point(placement.translation))


def _stretched(part: Part, stretch: Stretch) -> Part:
    shape, R, p = part.shape, part.rotation, part.position
    if isinstance(shape, (coal.Cylinder, coal.Capsule)):
        p, sizes = stretch.solid(R[:, [2]], p, np.array([2.0 * shape.halfLength]))
        shape = type(shape)(shape.radius, float(sizes[0]))
    elif isinstance(shape, coal.Box):
        p, sizes = stretch.solid(R, p, 2.0 * shape.halfSide)
        shape = coal.Box(*sizes.tolist())
    else:
        p = stretch.point(p)
    return replace(part, shape=shape, position=p)
