"""The geometry of fingertips: a sphere at the tip frame, or the collision geometry in the URDF."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array, number, per_name, read_only
from handlcp.errors import URDFError
from handlcp.hand.robot.hull import hull
from handlcp.hand.robot.kinematics import TipFrames
from handlcp.hand.robot.urdf import captured_stderr, resolve_meshes

__all__ = ["TipGeometry", "TipShape", "read_radii", "sphere_tip", "urdf_tip"]

_CONVEX = (coal.Sphere, coal.Box, coal.Cylinder, coal.Capsule, coal.Ellipsoid, coal.ConvexBase)


@dataclass(frozen=True, slots=True)
class TipShape:
    """One convex shape of a fingertip: coal's geometry and its placement in the tip frame.

    radius : [m] of a sphere, None for other shapes. central : whether it is a sphere about the origin of the tip frame.
    name : for messages.
    """

    geometry: Any
    rotation: Array
    translation: Array
    radius: float | None
    central: bool = False
    name: str = "a fingertip"


class TipGeometry:
    """The shapes of the fingertips: spheres of given radii, else the URDF's collision geometry, read when asked for."""

    __slots__ = ("_found", "_model", "_tips", "folders", "root")

    def __init__(
        self, model: Any, root: ET.Element | None, tips: TipFrames, radii: Mapping[str, float], folders: Sequence[Path]
    ) -> None:
        self._model, self.root, self._tips, self.folders = model, root, tips, folders
        self._found = {i: sphere_tip(radii[name]) for i, name in enumerate(tips.names) if name in radii}

    def shapes(self, tip: int) -> tuple[TipShape, ...]:
        """The shapes of the tip numbered `tip`. Raises URDFError when there are none."""
        if tip not in self._found:
            if self.root is None:
                name = self._tips.names[tip]
                expected = f"a radius for {name!r}: a pinocchio.Model carries no collision geometry"
                raise URDFError("tip_radius", expected, "None")
            self._found[tip] = urdf_tip(self._model, self.root, self._tips.frames[tip], self.folders)
        return self._found[tip]


def sphere_tip(radius: float) -> tuple[TipShape, ...]:
    """A sphere about the origin of the tip frame."""
    return (TipShape(coal.Sphere(radius), read_only(np.eye(3)), read_only(np.zeros(3)), radius, True),)


def read_radii(value: Any, tips: Sequence[str]) -> dict[str, float]:
    """Radii by tip name [m] from None (no radii), a number (all tips) or a mapping. Raises InputError, UnknownName."""
    if value is None:
        return {}
    if isinstance(value, Mapping):
        given = per_name("tip_radius", value, tips, "a fingertip")
        return {tip: number(f"tip_radius[{tip!r}]", r, above=0.0) for tip, r in given.items()}
    return dict.fromkeys(tips, number("tip_radius", value, above=0.0))


def urdf_tip(model: Any, root: ET.Element, tip: int, folders: Sequence[Path]) -> tuple[TipShape, ...]:
    """The collision geometry of the frame's link or, if it has none, of the links fixed to it; meshes become hulls.

    tip : number of the frame. Raises URDFError when there is none, or a mesh file is not found.
    """
    frame = model.frames[tip]
    links = _colliding_links(model, root, tip)
    if not links:
        expected = f"a radius for {frame.name!r}, whose link has no collision geometry in the URDF"
        raise URDFError("tip_radius", expected, "None")
    tip_only = copy.deepcopy(root)
    for link in tip_only.findall("link"):
        others = ("visual",) if link.get("name") in links else ("visual", "collision")
        for element in [e for e in link if e.tag in others]:
            link.remove(element)
    resolve_meshes(tip_only, folders)
    text = ET.tostring(tip_only, encoding="unicode")
    expected = f"collision geometry for {frame.name!r} that can be loaded"
    with captured_stderr() as messages:
        try:
            found = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
        except (ValueError, RuntimeError) as error:
            found, failure = None, str(error)
    if found is None:
        raise URDFError("source", expected, f"{failure} {''.join(messages)}".strip())
    if not len(found.geometryObjects):
        detail = " ".join("".join(messages).split()) or "none that Pinocchio reads"
        raise URDFError("source", f"{expected}, or a tip_radius", detail)
    return tuple(_shape(frame.name, g.geometry, frame.placement.actInv(g.placement)) for g in found.geometryObjects)


def _shape(frame: str, geometry: Any, placement: Any) -> TipShape:
    if isinstance(geometry, coal.BVHModelBase):
        if (made := hull(np.array(geometry.vertices(), dtype=float))) is None:
            raise URDFError("source", f"a mesh for {frame!r} that encloses a volume", "one that is flat")
        geometry = made
    elif not isinstance(geometry, _CONVEX):
        expected = f"a radius for {frame!r}, whose collision geometry is no convex shape"
        raise URDFError("tip_radius", expected, type(geometry).__name__)
    radius = float(geometry.radius) if isinstance(geometry, coal.Sphere) else None
    rotation, translation = read_only(placement.rotation.copy()), read_only(placement.translation.copy())
    central = radius is not None and not translation.any()
    return TipShape(geometry, rotation, translation, radius, central, frame)


def _colliding_links(model: Any, root: ET.Element, tip: int) -> set[str]:
    """Names of the links whose collision geometry is the tip's: its own link, or all links that move as one with it."""
    collide = {link.get("name") for link in root.findall("link") if link.find("collision/geometry") is not None}
    links = [(i, f) for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY and f.name in collide]
    own = {f.name for i, f in links if tip in (i, f.parentFrame)}  # the tip is the link's frame, or that of its joint
    return own or {f.name for _, f in links if f.parentJoint == model.frames[tip].parentJoint}
