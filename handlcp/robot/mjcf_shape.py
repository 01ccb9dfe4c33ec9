"""`compiled_meshes`: meshes of an MJCF model as MuJoCo compiled them, also those written inside it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import scipy

from handlcp.check import Array, read_only
from handlcp.robot.joint import Doubt
from handlcp.robot.link_shape import COMPILED_ATTRIBUTE, CompiledMesh, quaternion_rotation

_EQUAL_CORNER_SHARE = 1e-5  # of a mesh's size: corners of a file and of the compiled model that are closer are the same


def _name_and_path(model: Any, mesh: int) -> tuple[str, str]:
    """Of a mesh, by its number; no path of one that is written inside the file."""
    start = int(model.mesh_pathadr[mesh])
    path = bytes(model.paths)[start:].split(b"\0", 1)[0].decode(errors="replace") if start >= 0 else ""
    return str(model.mesh(mesh).name or f"mesh {mesh}"), path


def compiled_meshes(model: Any, path: Path | None) -> tuple[dict[str, CompiledMesh], list[Doubt]]:
    """Every mesh by name, and doubts about those that are read in part. Corners are MuJoCo's float32 numbers.

    MuJoCo moves corners to the mesh's principal axes, which is undone: they are in the axes in which the file places
    the mesh. Of an OBJ file with several objects it keeps all corners, but the triangles of the first object alone;
    those of the file are taken where its corners are the compiled ones. path : of the MJCF file.
    """
    found, partial = dict[str, CompiledMesh](), list[str]()
    for mesh in range(model.nmesh):
        name, address = _name_and_path(model, mesh)
        made, file = _compiled_mesh(model, mesh), Path(address)
        if file.suffix.lower() == ".obj" and _has_several_objects(file := (path or file).parent / file):
            whole = _read_whole_mesh(file, np.array(model.mesh_scale[mesh], dtype=float))
            if whole is not None and _has_corners(whole.corners, made.corners):
                made = whole
            else:
                partial.append(name)
        found[name] = made
    what = f"of meshes with several objects the first alone is read: {', '.join(partial)}"
    return found, [Doubt("hand", what, "OBJ files with one object", "minor", "geometry")] if partial else []


def _compiled_mesh(model: Any, mesh: int) -> CompiledMesh:
    first, faces = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    own = np.asarray(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], dtype=float)
    corners = own @ quaternion_rotation(model.mesh_quat[mesh]).T + model.mesh_pos[mesh]
    triangles = np.array(model.mesh_face[faces : faces + int(model.mesh_facenum[mesh])], dtype=np.int64)
    return CompiledMesh(read_only(corners), triangles)


def _has_several_objects(file: Path) -> bool:
    """Whether an OBJ file has more than one object or group."""
    try:
        lines = file.read_bytes().splitlines()
    except OSError:
        return False
    return sum(line.startswith((b"o ", b"g ")) for line in lines) > 1


def _read_whole_mesh(file: Path, scale: Array) -> CompiledMesh | None:
    try:
        tree = coal.MeshLoader(coal.NODE_TYPE.BV_OBBRSS).load(str(file), scale)
    except (ValueError, RuntimeError):
        return None
    triangles = [[t[0], t[1], t[2]] for t in (tree.tri_indices(i) for i in range(tree.num_tris))]
    return CompiledMesh(read_only(np.array(tree.vertices(), dtype=float)), np.array(triangles, dtype=np.int64))


def _has_corners(file: Array, compiled: Array) -> bool:
    """Whether each of corners (k, 3) is among those of a file (m, 3)."""
    away = scipy.spatial.cKDTree(file).query(compiled)[0]
    return bool(away.max() <= _EQUAL_CORNER_SHARE * np.ptp(file, axis=0).max())


# ----------------------------------------------------------------
# Shapes of an MJCF file: geometry of its bodies as URDF elements, and how numbers are written there.

_PLANE, _HFIELD, _SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH = range(8)
DRIVES_TENDON = 3  # what an actuator moves
_DRAWN_GROUPS = 3  # groups of geoms that MuJoCo draws: 0, 1, 2


def add_element(parent: ET.Element, tag: str, **attributes: Any) -> ET.Element:
    """A new element below `parent`; numbers are written so that the same come back."""
    return ET.SubElement(parent, tag, {name: _format_value(value) for name, value in attributes.items()})


def add_origin(element: ET.Element, R: Array, p: Array) -> None:
    """An <origin> from a rotation (3, 3) and a position (3,) [m]."""
    add_element(element, "origin", xyz=p, rpy=pin.rpy.matrixToRpy(np.array(R)))


def add_shapes(link: ET.Element, model: Any, body: int) -> list[Doubt]:
    """Write the geoms of a body to its link; returns what of them a URDF cannot say."""
    left_out = list[str]()
    first = int(model.body_geomadr[body])
    for g in range(first, first + int(model.body_geomnum[body])):
        solid = bool(model.geom_contype[g] or model.geom_conaffinity[g])
        drawn = not solid or int(model.geom_group[g]) < _DRAWN_GROUPS
        if int(model.geom_type[g]) in (_PLANE, _HFIELD) and not model.body_weldid[body]:
            continue  # the floor of a scene, no part of a hand
        kinds = [kind for kind, wanted in (("collision", solid), ("visual", drawn)) if wanted]
        written = [_write_geom(link, kind, model, g) for kind in kinds]
        if not all(written):
            left_out.append(model.geom(g).name or f"geom {g}")
    if not left_out:
        return []
    what = f"geometry that a URDF cannot say is left out: {', '.join(left_out)}"
    return [Doubt(link.get("name", ""), what, "boxes, balls, cylinders, capsules or meshes", "minor")]


def _write_geom(link: ET.Element, kind: str, model: Any, g: int) -> bool:
    """One geom; False where there is no such shape in a URDF."""
    R, p, size = quaternion_rotation(model.geom_quat[g]), model.geom_pos[g], model.geom_size[g]
    shape, material = int(model.geom_type[g]), int(model.geom_matid[g])
    colour = np.asarray(model.geom_rgba[g] if material < 0 else model.mat_rgba[material], dtype=float)
    radius, half = float(size[0]), float(size[1])
    if shape == _SPHERE:
        _write_shape(link, kind, R, p, colour, "sphere", radius=radius)
    elif shape == _BOX:
        _write_shape(link, kind, R, p, colour, "box", size=2 * size)
    elif shape in (_CYLINDER, _CAPSULE):
        _write_shape(link, kind, R, p, colour, "cylinder", radius=radius, length=2 * half)
        for end in (half, -half) if shape == _CAPSULE else ():  # a capsule is a cylinder between two balls
            _write_shape(link, kind, R, p + R[:, 2] * end, colour, "sphere", radius=radius)
    elif shape == _MESH:  # in the axes in which the file places it
        mesh = int(model.geom_dataid[g])
        R = R @ quaternion_rotation(model.mesh_quat[mesh]).T
        name, file = _name_and_path(model, mesh)
        named = {"filename": file or name, COMPILED_ATTRIBUTE: name}
        _write_shape(link, kind, R, p - R @ model.mesh_pos[mesh], colour, "mesh", **named)
    return shape in (_SPHERE, _BOX, _CYLINDER, _CAPSULE, _MESH)


def soft_part_doubts(model: Any) -> list[Doubt]:
    """What deforms, of which nothing is read."""
    found = {"skins": model.nskin, "flexible parts": model.nflex}
    said = [f"{count} {what}" for what, count in found.items() if count]
    if not said:
        return []
    what = f"what deforms is left out: {' and '.join(said)}"
    return [Doubt("hand", what, "geoms of bodies, with pad_flexibility", "minor", "geometry")]


def _write_shape(link: ET.Element, kind: str, R: Array, p: Array, colour: Array, tag: str, **attributes: Any) -> None:
    element = add_element(link, kind)
    add_origin(element, R, p)
    add_element(add_element(element, "geometry"), tag, **attributes)
    if kind == "visual":
        add_element(add_element(element, "material", name=""), "color", rgba=colour)


def _format_value(value: Any) -> str:
    if isinstance(value, str):
        return value
    return " ".join(repr(float(v)) for v in np.atleast_1d(np.asarray(value, dtype=float)))
