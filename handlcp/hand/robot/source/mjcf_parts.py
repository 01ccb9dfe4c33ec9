"""Shapes of an MJCF file: geometry of its bodies as URDF elements, and how numbers are written there."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.hand.robot.joints import Doubt
from handlcp.hand.robot.source.mjcf_meshes import mesh_name, mesh_path
from handlcp.hand.robot.source.part import COMPILED, rotation_of

_PLANE, _HFIELD, _SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH = range(8)
MOVES_TENDON = 3  # what an actuator moves
_SEEN = 3  # groups of geoms that MuJoCo draws: 0, 1, 2


def add(parent: ET.Element, tag: str, **attributes: Any) -> ET.Element:
    """A new element below `parent`; numbers are written so that the same come back."""
    return ET.SubElement(parent, tag, {name: _written(value) for name, value in attributes.items()})


def placed(element: ET.Element, R: Array, p: Array) -> None:
    """An <origin> from a rotation (3, 3) and a position (3,) [m]."""
    add(element, "origin", xyz=p, rpy=pin.rpy.matrixToRpy(np.array(R)))


def add_shapes(link: ET.Element, model: Any, body: int) -> list[Doubt]:
    """Write the geoms of a body to its link; returns what of them a URDF cannot say."""
    left_out = list[str]()
    first = int(model.body_geomadr[body])
    for g in range(first, first + int(model.body_geomnum[body])):
        solid = bool(model.geom_contype[g] or model.geom_conaffinity[g])
        if int(model.geom_type[g]) in (_PLANE, _HFIELD) and not model.body_weldid[body]:
            continue  # the floor of a scene, no part of a hand
        kinds = [kind for kind, wanted in (("collision", solid), ("visual", _seen(model, g, solid))) if wanted]
        written = [_geom(link, kind, model, g) for kind in kinds]
        if not all(written):
            left_out.append(model.geom(g).name or f"geom {g}")
    if not left_out:
        return []
    what = f"geometry that a URDF cannot say is left out: {', '.join(left_out)}"
    return [Doubt(link.get("name", ""), what, "boxes, balls, cylinders, capsules or meshes", "minor")]


def _seen(model: Any, g: int, solid: bool) -> bool:
    return not solid or int(model.geom_group[g]) < _SEEN


def _geom(link: ET.Element, kind: str, model: Any, g: int) -> bool:
    """One geom; False where there is no such shape in a URDF."""
    R, p, size = rotation_of(model.geom_quat[g]), model.geom_pos[g], model.geom_size[g]
    shape, colour = int(model.geom_type[g]), _colour(model, g)
    radius, half = float(size[0]), float(size[1])
    if shape == _SPHERE:
        _shape(link, kind, R, p, colour, "sphere", radius=radius)
    elif shape == _BOX:
        _shape(link, kind, R, p, colour, "box", size=2 * size)
    elif shape in (_CYLINDER, _CAPSULE):
        _shape(link, kind, R, p, colour, "cylinder", radius=radius, length=2 * half)
        for end in (half, -half) if shape == _CAPSULE else ():  # a capsule is a cylinder between two balls
            _shape(link, kind, R, p + R[:, 2] * end, colour, "sphere", radius=radius)
    elif shape == _MESH:
        return _mesh(link, kind, model, g, R, p)
    else:
        return False
    return True


def _mesh(link: ET.Element, kind: str, model: Any, g: int, R: Array, p: Array) -> bool:
    """A mesh in the axes in which the file places it."""
    mesh = int(model.geom_dataid[g])
    R = R @ rotation_of(model.mesh_quat[mesh]).T
    p = p - R @ model.mesh_pos[mesh]
    name, file = mesh_name(model, mesh), mesh_path(model, mesh)
    _shape(link, kind, R, p, _colour(model, g), "mesh", filename=file or name, **{COMPILED: name})
    return True


def soft_parts(model: Any) -> list[Doubt]:
    """What deforms, of which nothing is read."""
    found = {"skins": model.nskin, "flexible parts": model.nflex}
    said = [f"{count} {what}" for what, count in found.items() if count]
    if not said:
        return []
    what = f"what deforms is left out: {' and '.join(said)}"
    return [Doubt("hand", what, "geoms of bodies, with pad_flexibility", "minor", "geometry")]


def _shape(link: ET.Element, kind: str, R: Array, p: Array, colour: Array, tag: str, **attributes: Any) -> None:
    element = add(link, kind)
    placed(element, R, p)
    add(add(element, "geometry"), tag, **attributes)
    if kind == "visual":
        add(add(element, "material", name=""), "color", rgba=colour)


def _colour(model: Any, g: int) -> Array:
    material = int(model.geom_matid[g])
    return np.asarray(model.geom_rgba[g] if material < 0 else model.mat_rgba[material], dtype=float)


def _written(value: Any) -> str:
    if isinstance(value, str):
        return value
    return " ".join(repr(float(v)) for v in np.atleast_1d(np.asarray(value, dtype=float)))
