"""The geometry of fingertips: a sphere at the tip frame, or what the URDF says collides there."""

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

from handlcp.check import Array, number, read_only
from handlcp.errors import URDFError
from handlcp.hand.meshes import hull
from handlcp.hand.stiffness import per_name
from handlcp.hand.urdf import captured_stderr, resolve_meshes

__all__ = ["TipGeometry", "TipShape", "read_radii", "sphere_tip", "urdf_tip"]


@dataclass(frozen=True, slots=True)
class TipShape:
    """One convex shape of a fingertip: coal geometry and its placement in the tip frame; `radius` [m] if it is a
    sphere.
    """

    geometry: Any
    rotation: Array
    translation: Array
    radius: float | None
    central: bool = False


class TipGeometry:
    """The shapes of the fingertips, each found when it is first asked for: a radius, else the URDF's collision
    geometry.
    """

    __slots__ = ("_found", "_model", "_names", "_radii", "folders", "root")

    def __init__(
        self,
        model: Any,
        root: ET.Element | None,
        names: Sequence[str],
        radii: Mapping[str, float],
        folders: Sequence[Path],
    ) -> None:
        self._model, self.root, self._names, self._radii, self.folders = model, root, names, radii, folders
        self._found: dict[int, tuple[TipShape, ...]] = {}

    def shapes(self, tip: int) -> tuple[TipShape, ...]:
        """The shapes of the tip numbered `tip`. Raises URDFError when there are none."""
        if tip not in self._found:
            name = self._names[tip]
            if name in self._radii:
                self._found[tip] = sphere_tip(self._radii[name])
            elif self.root is None:
                expected = f"a radius for {name!r}: a pinocchio.Model carries no collision geometry"
                raise URDFError("tip_radius", expected, "None")
            else:
                self._found[tip] = urdf_tip(self._model, self.root, name, self.folders)
        return self._found[tip]


def sphere_tip(radius: float) -> tuple[TipShape, ...]:
    """A sphere about the origin of the tip frame."""
    return (TipShape(coal.Sphere(radius), read_only(np.eye(3)), read_only(np.zeros(3)), radius, True),)


def read_radii(value: Any, tips: Sequence[str]) -> dict[str, float]:
    """Radii by tip name: from None (nobody's), a number > 0 [m] (everybody's) or a mapping. Raises InputError,
    UnknownName.
    """
    if value is None:
        return {}
    if isinstance(value, Mapping):
        given = per_name("tip_radius", value, tips, "a fingertip")
        return {tip: number(f"tip_radius[{tip!r}]", r, above=0.0) for tip, r in given.items()}
    return dict.fromkeys(tips, number("tip_radius", value, above=0.0))


def urdf_tip(model: Any, root: ET.Element, frame: str, folders: Sequence[Path]) -> tuple[TipShape, ...]:
    """The collision geometry of the link that is the tip frame; if that link has none, all of the links fixed to it
    (those that move as one body with it). Meshes count as their convex hulls.

    Raises URDFError when there is none, or a mesh file is not found.
    """
    carriers = _carriers(root, frame)
    if not carriers:
        raise URDFError(
            "tip_radius", f"a radius for {frame!r}, whose link has no collision geometry in the URDF", "None"
        )
    slim = copy.deepcopy(root)
    for link in slim.findall("link"):
        if link.get("name") not in carriers:
            for collision in link.findall("collision"):
                link.remove(collision)
        for visual in link.findall("visual"):
            link.remove(visual)
    resolve_meshes(slim, folders)
    with captured_stderr() as messages:
        try:
            found = pin.buildGeomFromUrdfString(
                model, ET.tostring(slim, encoding="unicode"), pin.GeometryType.COLLISION
            )
        except (ValueError, RuntimeError) as error:
            found, failure = None, str(error)
    if found is None:
        raise URDFError(
            "source", f"collision geometry for {frame!r} that can be loaded", f"{failure} {''.join(messages)}".strip()
        )
    if not len(found.geometryObjects):
        detail = " ".join("".join(messages).split()) or "none that Pinocchio reads"
        raise URDFError("source", f"collision geometry for {frame!r} that can be loaded, or a tip_radius", detail)
    at = next(f.placement for f in reversed(list(model.frames)) if f.name == frame)
    return tuple(_shape(frame, g, at.actInv(g.placement)) for g in found.geometryObjects)


def _shape(frame: str, found: Any, placement: Any) -> TipShape:
    g = found.geometry
    if isinstance(g, coal.BVHModelBase):
        g = hull(g)
    elif not isinstance(g, (coal.Sphere, coal.Box, coal.Cylinder, coal.Capsule, coal.Ellipsoid, coal.ConvexBase)):
        raise URDFError(
            "tip_radius", f"a radius for {frame!r}, whose collision geometry is no convex shape", type(g).__name__
        )
    radius = float(g.radius) if isinstance(g, coal.Sphere) else None
    rotation, translation = read_only(placement.rotation.copy()), read_only(placement.translation.copy())
    return TipShape(g, rotation, translation, radius, radius is not None and not translation.any())


def _carriers(root: ET.Element, frame: str) -> set[str]:
    """Names of the links whose collision geometry is the tip's."""
    colliding = {link.get("name", "") for link in root.findall("link") if link.find("collision/geometry") is not None}
    fixed = [
        (p.get("link", ""), c.get("link", ""), j.get("name", ""))
        for j in root.findall("joint")
        if j.get("type") == "fixed" and (p := j.find("parent")) is not None and (c := j.find("child")) is not None
    ]
    body = next(
        (child for _, child, name in fixed if name == frame), frame
    )  # a fixed joint's frame is its child link's
    if body in colliding:
        return {body}
    together, grown = {body}, True
    while grown:
        more = {x for p, c, _ in fixed for x in (p, c) if (p in together) != (c in together)} - together
        grown = bool(more)
        together |= more
    return together & colliding
