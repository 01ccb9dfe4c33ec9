"""Shapes of links as coal has them: those that Pinocchio loads, and those of a model that MuJoCo compiled."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Set
from dataclasses import dataclass
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array, Ints

COMPILED = "compiled"  # attribute of a <mesh> whose corners are in memory: the name that they are kept under


@dataclass(frozen=True, eq=False)
class Part:
    """One shape of a link. frame : number of the link's frame. shape : coal's. rotation (3, 3), position (3,) : in the
    link's frame [m]. colour (3,) : red, green, blue from 0 to 1; None: the file says none.
    """

    frame: int
    shape: Any
    rotation: Array
    position: Array
    colour: Array | None = None


class CompiledMesh(NamedTuple):
    """A mesh of a compiled model. corners (k, 3) [m] : in the axes that the file places it in. triangles (m, 3) :
    numbers of corners.
    """

    corners: Array
    triangles: Ints


def parts_of(model: Any, geometry: Any) -> tuple[Part, ...]:
    """From a pinocchio.GeometryModel."""
    found = []
    for item in geometry.geometryObjects:
        place = model.frames[item.parentFrame].placement.actInv(item.placement)
        colour = np.array(item.meshColor).ravel()[:3] if item.overrideMaterial else None
        frame = int(item.parentFrame)
        found.append(Part(frame, item.geometry, place.rotation.copy(), place.translation.copy(), colour))
    return tuple(found)


def compiled_parts(
    root: ET.Element, model: Any, meshes: Mapping[str, CompiledMesh], kind: str, links: Set[str] | None
) -> tuple[Part, ...]:
    """Of a <robot> that was an MJCF file, in the order of frames; no file is read. kind : the tag. links None: all."""
    found = list[Part]()
    numbers = {f.name: i for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}
    for link in root.findall("link"):
        name = link.get("name", "")
        for element in link.iterfind(kind) if links is None or name in links else ():
            (shape,) = element.iterfind("geometry/*")
            R, p = origin_of(element)
            colour = element.find("material/color")
            rgb = None if colour is None else numbers_of(colour.get("rgba", ""))[:3]
            found.append(Part(numbers[name], _coal_shape(shape, meshes), R, p, rgb))
    return tuple(sorted(found, key=lambda part: part.frame))


def _coal_shape(shape: ET.Element, meshes: Mapping[str, CompiledMesh]) -> Any:
    sizes = {word: numbers_of(shape.get(word, "0")) for word in ("radius", "length")}
    radius, length = float(sizes["radius"][0]), float(sizes["length"][0])
    if shape.tag == "sphere":
        return coal.Sphere(radius)
    if shape.tag == "cylinder":
        return coal.Cylinder(radius, length)
    if shape.tag == "box":
        return coal.Box(numbers_of(shape.get("size", "")))
    mesh = meshes[shape.get(COMPILED, "")]
    return tree_of(mesh.corners * numbers_of(shape.get("scale", "1 1 1")), mesh.triangles)


def tree_of(corners: Array, triangles: Any) -> Any:
    """A mesh of coal, of corners (k, 3) [m] and triangles (m, 3)."""
    tree = coal.BVHModelOBBRSS()
    tree.beginModel(len(triangles), len(corners))
    tree.addVertices(np.array(corners, dtype=float))
    tree.addTriangles(np.array(triangles))
    tree.endModel()
    return tree


def origin_of(element: ET.Element) -> tuple[Array, Array]:
    """Rotation (3, 3) and position (3,) [m] of an <origin>."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(3), np.zeros(3)
    r, p, y = numbers_of(origin.get("rpy", "0 0 0")).tolist()
    return np.asarray(pin.rpy.rpyToMatrix(r, p, y)), numbers_of(origin.get("xyz", "0 0 0"))


def rotation_of(quaternion: Array) -> Array:
    """(3, 3) of a unit quaternion w, x, y, z."""
    w, x, y, z = (float(v) for v in quaternion)
    return np.asarray(pin.Quaternion(w, x, y, z).normalized().toRotationMatrix())


def numbers_of(text: str) -> Array:
    """(n,) of a text with numbers."""
    return np.array([float(word) for word in text.split()])
