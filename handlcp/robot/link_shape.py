"""`LinkShape`: shapes of links as coal has them, loaded by Pinocchio or compiled by MuJoCo."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array, Ints
from handlcp.errors import URDFError
from handlcp.robot.joint import Doubt

COMPILED_ATTRIBUTE = "compiled"  # attribute of a <mesh> whose corners are in memory: the name that they are kept under


@dataclass(frozen=True, eq=False)
class LinkShape:
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


def model_shapes(model: Any, geometry: Any) -> tuple[LinkShape, ...]:
    """From a pinocchio.GeometryModel."""
    found = []
    for item in geometry.geometryObjects:
        place = model.frames[item.parentFrame].placement.actInv(item.placement)
        colour = np.array(item.meshColor).ravel()[:3] if item.overrideMaterial else None
        frame = int(item.parentFrame)
        found.append(LinkShape(frame, item.geometry, place.rotation.copy(), place.translation.copy(), colour))
    return tuple(found)


def compiled_shapes(
    root: ET.Element, model: Any, meshes: Mapping[str, CompiledMesh], kind: str, links: Set[str] | None
) -> tuple[LinkShape, ...]:
    """Of a <robot> that was an MJCF file, in the order of frames; no file is read. kind : the tag. links None: all."""
    found = list[LinkShape]()
    numbers = {f.name: i for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}
    for link in root.findall("link"):
        name = link.get("name", "")
        for element in link.iterfind(kind) if links is None or name in links else ():
            (shape,) = element.iterfind("geometry/*")
            R, p = read_origin(element)
            colour = element.find("material/color")
            rgb = None if colour is None else read_numbers(colour.get("rgba", ""))[:3]
            found.append(LinkShape(numbers[name], _make_coal_shape(shape, meshes), R, p, rgb))
    return tuple(sorted(found, key=lambda part: part.frame))


def _make_coal_shape(shape: ET.Element, meshes: Mapping[str, CompiledMesh]) -> Any:
    radius, length = (float(read_numbers(shape.get(word, "0"))[0]) for word in ("radius", "length"))
    if shape.tag == "sphere":
        return coal.Sphere(radius)
    if shape.tag == "cylinder":
        return coal.Cylinder(radius, length)
    if shape.tag == "box":
        return coal.Box(read_numbers(shape.get("size", "")))
    mesh = meshes[shape.get(COMPILED_ATTRIBUTE, "")]
    return build_mesh_tree(mesh.corners * read_numbers(shape.get("scale", "1 1 1")), mesh.triangles)


def build_mesh_tree(corners: Array, triangles: Any) -> Any:
    """A mesh of coal, of corners (k, 3) [m] and triangles (m, 3)."""
    tree = coal.BVHModelOBBRSS()
    tree.beginModel(len(triangles), len(corners))
    tree.addVertices(np.array(corners, dtype=float))
    tree.addTriangles(np.array(triangles))
    tree.endModel()
    return tree


def read_origin(element: ET.Element) -> tuple[Array, Array]:
    """Rotation (3, 3) and position (3,) [m] of an <origin>."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(3), np.zeros(3)
    r, p, y = read_numbers(origin.get("rpy", "0 0 0")).tolist()
    return np.asarray(pin.rpy.rpyToMatrix(r, p, y)), read_numbers(origin.get("xyz", "0 0 0"))


def quaternion_rotation(quaternion: Array) -> Array:
    """(3, 3) of a unit quaternion w, x, y, z."""
    w, x, y, z = (float(v) for v in quaternion)
    return np.asarray(pin.Quaternion(w, x, y, z).normalized().toRotationMatrix())


def read_numbers(text: str) -> Array:
    """(n,) of a text with numbers."""
    return np.array([float(word) for word in text.split()])


# ----------------------------------------------------------------
# Numbers of a robot that look as if they were in other units than metres and kilograms: its skeleton, and its shapes.
#
# A skeleton in millimetres is some hundred metres wide; so is a mesh that was drawn in millimetres. Neither is refused
# for being large beside a small hand alone: a hand may stand on a table, or at the end of an arm.

MAX_ROBOT_WIDTH, MAX_ROBOT_MASS = 20.0, 2000.0  # [m, kg] no robot that carries a hand is larger
MAX_SHAPE_REACH, MAX_REACH_PER_SKELETON = 5.0, 20.0  # [m], and times the skeleton: as for objects
MAX_MOVED_REACH, MAX_MOVED_PER_SKELETON = 1.0, 5.0  # the same of what a joint moves; beyond, it is doubted
MIN_MESH_WIDTH = 2e-4  # [m] no mesh of a hand is smaller
_SCALE_ADVICE = 'scale="0.001 0.001 0.001" in <mesh>'


def skeleton_width(model: Any) -> float:
    """[m] The largest extent of the frames along x, y or z, joints at 0; 0 where they are nowhere."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    places = np.array([place.translation for place in data.oMf])
    return float(np.ptp(places, axis=0).max()) if np.isfinite(places).all() else 0.0


def check_units(argument: str, model: Any) -> None:
    """Raises URDFError for a robot that is wider than 20 m or heavier than 2 t, and says how to go on."""
    width = skeleton_width(model)
    if width > MAX_ROBOT_WIDTH:
        advice = "are they in millimetres? then multiply each xyz, size, radius and length by 0.001"
        raise URDFError(argument, f"lengths in metres ({advice})", f"a robot {width:.3g} m wide")
    mass = sum(float(inertia.mass) for inertia in model.inertias)
    if mass > MAX_ROBOT_MASS:
        expected = "masses in kilograms (are they in grams? then multiply each mass and inertia by 0.001)"
        raise URDFError(argument, expected, f"a robot of {mass:.3g} kg")


# ----------------------------------------------------------------
# Shapes of links beside the skeleton.


class LinkSize(NamedTuple):
    """How large one link is, as its shapes say.

    reach [m] : how far its shapes go from its frame, at most. smallest_mesh [m] : the largest extent of its smallest
    mesh, inf without one. has_farthest_mesh : whether a mesh reaches farthest. is_moved : whether a joint moves it.
    """

    reach: float
    smallest_mesh: float
    has_farthest_mesh: bool
    is_moved: bool


def link_sizes(parts: Sequence[LinkShape], model: Any) -> dict[str, LinkSize]:
    """By name of the link."""
    found = dict[str, LinkSize]()
    for part in parts:
        low, high, mesh = _shape_extents(part.shape)
        reach = float(np.linalg.norm(part.position)) + float(np.maximum(abs(low), abs(high)).max(initial=0.0))
        frame = model.frames[part.frame]
        width = float((high - low).max()) if mesh else np.inf
        last = found.get(frame.name, LinkSize(0.0, np.inf, False, frame.parentJoint > 0))
        farther = reach > last.reach
        meshed = mesh if farther else last.has_farthest_mesh
        found[frame.name] = LinkSize(max(reach, last.reach), min(width, last.smallest_mesh), meshed, last.is_moved)
    return found


def _shape_extents(shape: Any) -> tuple[Any, Any, bool]:
    """Least and largest coordinates (3,) of a shape in its own axes [m], and whether it is a mesh."""
    if isinstance(shape, (coal.BVHModelBase, coal.ConvexBase)):
        corners = np.array(shape.vertices() if isinstance(shape, coal.BVHModelBase) else shape.points(), dtype=float)
        return corners.min(axis=0), corners.max(axis=0), True
    if isinstance(shape, coal.Box):
        half = np.array(shape.halfSide).reshape(3)
    elif isinstance(shape, coal.Ellipsoid):
        half = np.array(shape.radii).reshape(3)
    else:
        radius = float(getattr(shape, "radius", 0.0))
        along = getattr(shape, "halfLength", 0.0)
        half = np.array([radius, radius, max(radius, along) if isinstance(shape, coal.Cylinder) else radius + along])
    return -half, half, False


def check_shapes(sizes: Mapping[str, LinkSize], model: Any) -> None:
    """Raises URDFError for shapes that are far larger than the robot that they belong to, and says the likely cause."""
    width = skeleton_width(model)
    most = max(MAX_SHAPE_REACH, MAX_REACH_PER_SKELETON * width)
    if large := {name: size for name, size in sizes.items() if size.reach > most}:
        drawn = f"meshes drawn in millimetres take {_SCALE_ADVICE}"
        meshed = any(size.has_farthest_mesh for size in large.values())
        cause = drawn if meshed else "sizes in millimetres? multiply them by 0.001"
        reach = f"reaching {max(size.reach for size in large.values()):.3g} m from the link's frame"
        came = f"{words.list_names(list(large))} {reach}, on a skeleton {width:.2g} m wide"
        raise URDFError("source", f"shapes of links in metres ({cause})", came)


def shape_doubts(sizes: Mapping[str, LinkSize], model: Any) -> Iterator[Doubt]:
    """Of shapes that are far too large for the robot, or of meshes that are far too small."""
    width = skeleton_width(model)
    still = max(MAX_SHAPE_REACH, MAX_REACH_PER_SKELETON * width)
    moved = max(MAX_MOVED_REACH, MAX_MOVED_PER_SKELETON * width)
    if large := {name: s for name, s in sizes.items() if s.reach > (moved if s.is_moved else still)}:
        reach = max(size.reach for size in large.values())
        what = (
            f"shapes reach {reach:.3g} m from the link's frame, on a skeleton {width:.2g} m wide: as if millimetres "
            "were taken for metres"
        )
        meshed = any(size.has_farthest_mesh for size in large.values())
        advice = f"a file with {_SCALE_ADVICE}" if meshed else "a file with sizes in metres"
        yield Doubt(", ".join(large), what, advice, "serious", "shape")
    if small := {name: s for name, s in sizes.items() if 0.0 < s.smallest_mesh < MIN_MESH_WIDTH}:
        least = min(size.smallest_mesh for size in small.values())
        what = f"a mesh is {1e6 * least:.3g} µm wide, as if its numbers were scaled from millimetres twice"
        yield Doubt(", ".join(small), what, "a file whose scale makes metres of the mesh", "serious", "shape")


# ----------------------------------------------------------------
# Collada says in which unit it is drawn. RViz and Gazebo apply that to the mesh, before the scale of the URDF, and
# neither applies <up_axis>: the mesh stands in the axes of the link as it is drawn.
# Sources: ros-visualization/rviz, pull requests 603 and 1689; gazebosim/gazebo-classic, issue 1305.


def collada_unit(file: Path) -> float:
    """Metres in the unit of a Collada file; 1 for other files, and where it says none or no number above 0."""
    if file.suffix.lower() != ".dae":
        return 1.0
    depth = 0
    try:
        with file.open("rb") as stream:
            for event, element in ET.iterparse(stream, ("start", "end")):
                tag = element.tag.rpartition("}")[2]
                if event == "start":
                    depth += 1
                    continue
                depth -= 1
                if tag == "unit" and depth == 2:  # of COLLADA/asset, the file's own
                    unit = float(element.get("meter", 1.0))
                    return unit if 0.0 < unit < np.inf else 1.0
                if tag == "asset" and depth == 1:
                    return 1.0
    except (OSError, ET.ParseError, ValueError):  # whoever loads it says what is wrong
        return 1.0
    return 1.0
