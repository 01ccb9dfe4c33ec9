"""A robot as it was read, before anything is said about fingertips, stiffness or torques."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import URDFError
from handlcp.hand.robot.joint_limits import Doubt
from handlcp.hand.robot.joints import JointFacts
from handlcp.hand.robot.urdf import captured_stderr, resolve_meshes

COLLISION, VISUAL = "collision", "visual"
_KINDS = {COLLISION: pin.GeometryType.COLLISION, VISUAL: pin.GeometryType.VISUAL}


@dataclass(frozen=True, eq=False)
class Part:
    """One shape of a link. frame : number of the link's frame. shape : coal's. rotation (3, 3), position (3,) : in the
    link's frame [m].
    """

    frame: int
    shape: Any
    rotation: Array
    position: Array


@dataclass(frozen=True, eq=False)
class Description:
    """Nothing of it is changed once it is made; threads may share it.

    source : name of the file, or of the model. model : Pinocchio's, without mimic joints; None: not made.
    facts : of movable joints. root : the <robot>, None for a model. folders : where meshes are looked up.
    given : parts by kind, of a model that came with geometry. doubts : found while reading.
    """

    source: str
    model: Any
    facts: tuple[JointFacts, ...]
    root: ET.Element | None = None
    folders: tuple[Path, ...] = ()
    given: tuple[tuple[str, tuple[Part, ...]], ...] = ()
    doubts: tuple[Doubt, ...] = ()

    def has(self, kind: str) -> tuple[str, ...]:
        """Names of the links with such geometry, each once."""
        if self.root is None:
            frames = [self.model.frames[part.frame].name for part in dict(self.given).get(kind, ())]
            return tuple(dict.fromkeys(frames))
        links = [link for link in self.root.findall("link") if link.find(f"{kind}/geometry") is not None]
        return tuple(dict.fromkeys(link.get("name", "") for link in links))

    @property
    def masses(self) -> dict[str, float]:
        """Link → mass [kg]. A model knows that of all links of a joint, and it is given to the first of them."""
        found, counted = dict[str, float](), {0}
        if self.root is not None:
            for link in self.root.findall("link"):
                mass = link.find("inertial/mass")
                found[link.get("name", "")] = 0.0 if mass is None else float(mass.get("value", 0.0))
            return found
        for frame in self.model.frames:
            joint = int(frame.parentJoint)
            if frame.type == pin.FrameType.BODY:
                found[frame.name] = 0.0 if joint in counted else float(self.model.inertias[joint].mass)
                counted.add(joint)
        return found

    def parts(self, kind: str, links: Set[str] | None = None) -> tuple[Part, ...]:
        """Shapes of these links, None: of all. Raises URDFError for meshes that are missing or cannot be read."""
        if self.root is None:
            every = dict(self.given).get(kind, ())
            return tuple(p for p in every if links is None or self.model.frames[p.frame].name in links)
        return self._loaded(self.root, kind, links)

    def _loaded(self, root: ET.Element, kind: str, links: Set[str] | None) -> tuple[Part, ...]:
        reduced = copy.deepcopy(root)
        for link in reduced.findall("link"):
            wanted = links is None or link.get("name") in links
            for element in [e for e in link if e.tag in _KINDS and not (wanted and e.tag == kind)]:
                link.remove(element)  # its meshes may be missing
        resolve_meshes(reduced, self.folders)
        with captured_stderr() as messages:
            try:
                text = ET.tostring(reduced, encoding="unicode")
                found = pin.buildGeomFromUrdfString(self.model, text, _KINDS[kind])
            except (ValueError, RuntimeError) as error:
                found, failure = None, str(error)
        detail = " ".join("".join(messages).split())
        if found is None:
            raise URDFError("source", f"{kind} geometry that can be loaded", f"{failure} {detail}".strip())
        if not len(found.geometryObjects) and links:
            expected = f"{kind} geometry for {', '.join(sorted(links))!r} that can be loaded, or a tip_radius"
            raise URDFError("source", expected, detail or "none that Pinocchio reads")
        return parts_of(self.model, found)


def parts_of(model: Any, geometry: Any) -> tuple[Part, ...]:
    """From a pinocchio.GeometryModel."""
    found = []
    for item in geometry.geometryObjects:
        place = model.frames[item.parentFrame].placement.actInv(item.placement)
        found.append(Part(int(item.parentFrame), item.geometry, place.rotation.copy(), place.translation.copy()))
    return tuple(found)
