"""`LinkStretch`: another length between two joints, or a joint and its fingertip, and what becomes of the rest.

    t' = t,  t < 0;    t' = t s,  0 ≤ t ≤ L;    t' = t + (s - 1) L,  t > L,    s = L'/L

with t along the line from the joint to the end, L long before. What is on the way becomes longer or shorter along this
line, what is beyond the end moves along as it is, and what is behind the joint stays.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.robot.description import COLLISION, VISUAL
from handlcp.robot.link_shape import LinkShape, read_numbers, read_origin
from handlcp.robot.urdf import joint_link

_MIN_ALIGNED_COSINE = 0.996  # cosine of 5°: an edge or axis that is no farther off the line runs along it
_END_TOLERANCE = 1e-9  # of the length: a link that begins so close to the end is beyond it


@dataclass(frozen=True, slots=True)
class LinkStretch:
    """A link that is made longer or shorter along a line.

    direction (3,) : of the line, a unit vector.
    before, after : the lengths L, L' [m].
    start : t of the origin of the frame in which direction and points are given [m]; 0 in that of the joint.
    """

    direction: Array
    before: float
    after: float
    start: float = 0.0

    def in_link(self, placement: Any) -> LinkStretch | None:
        """In the frame of a link that is placed so in this one's frame; None beyond the end, where nothing changes."""
        t = self.start + float(self.direction @ placement.translation)
        if t >= self.before * (1.0 - _END_TOLERANCE):
            return None
        return LinkStretch(placement.rotation.T @ self.direction, self.before, self.after, t)

    def map_point(self, x: Array) -> Array:
        """(3,) where the point x (3,) comes to be in the frame, which moves itself."""
        return x + self.direction * (
            self._shift_at(self.start + float(self.direction @ x)) - self._shift_at(self.start)
        )

    def map_solid(self, rotation: Array, position: Array, sizes: Array) -> tuple[Array, Array]:
        """Position (3,) and sizes (3,) [m] of a solid about its position, with these sizes along its axes: the columns
        of rotation (3, 3). Only along an axis that runs along the line can it become longer.
        """
        k, cosine = self._nearest_axis(rotation)
        if cosine < _MIN_ALIGNED_COSINE:
            return self.map_point(position), sizes
        t, half = self.start + float(self.direction @ position), 0.5 * cosine * float(sizes[k])
        low, high = self._shift_at(t - half), self._shift_at(t + half)
        made = np.array(sizes, dtype=float)
        made[k] += (high - low) / cosine
        return position + self.direction * (0.5 * (low + high) - self._shift_at(self.start)), made

    def map_mesh(self, rotation: Array, position: Array, scale: Array) -> tuple[Array, Array] | None:
        """Position (3,) and scale (3,) of a mesh, which becomes longer by L'/L everywhere; None where none of its axes
        runs along the line.
        """
        k, cosine = self._nearest_axis(rotation)
        if cosine < _MIN_ALIGNED_COSINE:
            return None
        made, more = np.array(scale, dtype=float), self.after / self.before
        made[k] *= more
        t = self.start + float(self.direction @ position)
        return position + self.direction * ((more - 1.0) * t - self._shift_at(self.start)), made

    def _nearest_axis(self, rotation: Array) -> tuple[int, float]:
        """Which column is nearest to the line, and the cosine of the angle between them."""
        cosines = abs(rotation.T @ self.direction)
        k = int(cosines.argmax())
        return k, min(float(cosines[k]), 1.0)

    def _shift_at(self, t: float) -> float:
        """How far a point at t along the line is moved, t' - t [m]."""
        return (self.after - self.before) * min(max(t / self.before, 0.0), 1.0)


# ----------------------------------------------------------------
# Other lengths and places in a pinocchio.Model, and in the geometry that came with it.


GivenShapes = tuple[tuple[str, tuple[LinkShape, ...]], ...]


def stretch_model(model: Any, stretches: Mapping[int, LinkStretch]) -> None:
    """Lengths by the number of the joint where they begin; the model is changed."""
    for k in range(1, model.njoints):
        if (stretch := stretches.get(int(model.parents[k]))) is not None:
            place = model.jointPlacements[k]
            place.translation = stretch.map_point(place.translation)
        if (stretch := stretches.get(k)) is not None:
            model.inertias[k].lever = stretch.map_point(model.inertias[k].lever)
    for frame in model.frames:
        if (stretch := stretches.get(int(frame.parentJoint))) is not None:
            frame.placement.translation = stretch.map_point(frame.placement.translation)


def stretch_parts(
    given: GivenShapes, model: Any, stretches: Mapping[int, LinkStretch]
) -> tuple[GivenShapes, list[str]]:
    """Stretch the shapes of links of a model as it was, and name those whose meshes all keep their shape."""
    kinds, kept = list[tuple[str, tuple[LinkShape, ...]]](), list[str]()
    for kind, parts in given:
        made = []
        for part in parts:
            frame = model.frames[part.frame]
            stretch = stretches.get(int(frame.parentJoint))
            local = None if stretch is None else stretch.in_link(frame.placement)
            if local is not None and isinstance(part.shape, (coal.BVHModelBase, coal.ConvexBase)):
                kept.append(frame.name)
            made.append(part if local is None else _stretch_part(part, local))
        kinds.append((kind, tuple(made)))
    return tuple(kinds), list(dict.fromkeys(kept))


def _stretch_part(part: LinkShape, stretch: LinkStretch) -> LinkShape:
    shape, R, p = part.shape, part.rotation, part.position
    if isinstance(shape, (coal.Cylinder, coal.Capsule)):
        p, sizes = stretch.map_solid(R[:, [2]], p, np.array([2.0 * shape.halfLength]))
        shape = type(shape)(shape.radius, float(sizes[0]))
    elif isinstance(shape, coal.Box):
        p, sizes = stretch.map_solid(R, p, 2.0 * shape.halfSide)
        shape = coal.Box(*sizes.tolist())
    else:
        p = stretch.map_point(p)
    return replace(part, shape=shape, position=p)


# ----------------------------------------------------------------
# Other lengths, axes and places in the <robot> of a hand, which is changed in place.


def place_urdf_joints(root: ET.Element, places: Mapping[str, Array], axes: Mapping[str, Array]) -> None:
    """Joints stand elsewhere, (3,) [m] in their parent's frame, or turn about, or slide along, other axes (3,), unit
    vectors in their own frames; both by name.
    """
    for joint in root.findall("joint"):
        name = joint.get("name", "")
        if name in places:
            _write_position(joint, places[name])
        if name in axes:
            element = joint.find("axis")
            element = ET.SubElement(joint, "axis") if element is None else element
            element.set("xyz", _format_numbers(axes[name]))


def stretch_urdf(root: ET.Element, model: Any, stretches: Mapping[int, LinkStretch]) -> list[str]:
    """Links of other lengths, by the number of the joint that moves them; model : Pinocchio's of this robot.

    Returns the names of links with meshes that keep their shape, as none of their axes runs along the length.
    """
    own, kept = dict[str, LinkStretch](), list[str]()
    for frame in model.frames:
        stretch = stretches.get(int(frame.parentJoint))
        local = None if stretch is None else stretch.in_link(frame.placement)
        if frame.type == pin.FrameType.BODY and local is not None:
            own[frame.name] = local
    for link in root.findall("link"):
        if (local := own.get(link.get("name", ""))) is None:
            continue
        for element in link:
            if element.tag == "inertial":
                _write_position(element, local.map_point(read_origin(element)[1]))
            elif element.tag in (COLLISION, VISUAL) and not _stretch_shape(element, local):
                kept.append(link.get("name", ""))
    for joint in root.findall("joint"):
        if (local := own.get(joint_link(joint, "parent"))) is not None:
            _write_position(joint, local.map_point(read_origin(joint)[1]))
    return list(dict.fromkeys(kept))


def _stretch_shape(element: ET.Element, stretch: LinkStretch) -> bool:
    """One <collision> or <visual>; False for a mesh that keeps its shape."""
    R, p = read_origin(element)
    for shape in element.iterfind("geometry/cylinder"):
        length = float(shape.get("length", 0.0))
        p, sizes = stretch.map_solid(R[:, [2]], p, np.array([length]))
        shape.set("length", _format_numbers(sizes))
        _write_position(element, p)
        return True
    for shape in element.iterfind("geometry/box"):
        p, sizes = stretch.map_solid(R, p, read_numbers(shape.get("size", "0 0 0")))
        shape.set("size", _format_numbers(sizes))
        _write_position(element, p)
        return True
    for shape in element.iterfind("geometry/mesh"):
        made = stretch.map_mesh(R, p, read_numbers(shape.get("scale", "1 1 1")))
        if made is not None:
            shape.set("scale", _format_numbers(made[1]))
            _write_position(element, made[0])
        return made is not None
    _write_position(element, stretch.map_point(p))
    return True


def _write_position(element: ET.Element, position: Array) -> None:
    origin = element.find("origin")
    (ET.SubElement(element, "origin") if origin is None else origin).set("xyz", _format_numbers(position))


def _format_numbers(values: Array) -> str:
    """So that the same numbers come back."""
    return " ".join([repr(v) for v in values.tolist()])
