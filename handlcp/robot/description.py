"""`RobotDescription`: a robot as it was read, before anything is said of fingertips, stiffness or torques."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pinocchio as pin

from handlcp.actuation.route import Route
from handlcp.check import check_call
from handlcp.errors import InputError, Unsupported, URDFError
from handlcp.lazy_property import lazy_property
from handlcp.read_file import MAX_XML_BYTES, parse_xml, read_bytes
from handlcp.robot.joint import (
    Doubt,
    JointFacts,
    Servo,
    check_friction,
    read_joint_facts,
    read_model_facts,
    read_servos,
)
from handlcp.robot.link_shape import (
    COMPILED_ATTRIBUTE,
    CompiledMesh,
    LinkShape,
    LinkSize,
    check_shapes,
    check_units,
    collada_unit,
    compiled_shapes,
    link_sizes,
    model_shapes,
    read_numbers,
)
from handlcp.robot.mjcf import compile_mjcf, convert_to_urdf
from handlcp.robot.mjcf_cable import read_routes
from handlcp.robot.urdf import (
    MAX_JOINTS,
    build_model,
    capture_stderr,
    check_robot,
    expand_xacro,
    find_mesh_file,
    joint_link,
    mesh_folders,
    package_folders,
    resolve_meshes,
)

COLLISION, VISUAL = "collision", "visual"
_GEOMETRY_TYPES = {COLLISION: pin.GeometryType.COLLISION, VISUAL: pin.GeometryType.VISUAL}


@dataclass(frozen=True, eq=False)
class RobotDescription:
    """Nothing of it is changed once it is made; threads may share it.

    source : name of the file, or of the model. model : Pinocchio's, without mimic joints; None: not made.
    facts : of movable joints. root : the <robot>, None for a model. folders : where meshes are looked up.
    given_shapes : parts by kind, of a model that came with geometry. doubts : found while reading. meshes : those that
    MuJoCo compiled of an MJCF file, by name.
    """

    source: str
    model: Any
    facts: tuple[JointFacts, ...]
    root: ET.Element | None = None
    folders: tuple[Path, ...] = ()
    given_shapes: tuple[tuple[str, tuple[LinkShape, ...]], ...] = ()
    doubts: tuple[Doubt, ...] = ()
    meshes: Mapping[str, CompiledMesh] = field(default_factory=dict)

    @property
    def is_mjcf(self) -> bool:
        """Whether it was read from an MJCF file."""
        return self.root is not None and self.root.get("format") == "mjcf"

    def links_with(self, kind: str) -> tuple[str, ...]:
        """Names of the links with such geometry, each once."""
        if self.root is None:
            frames = [self.model.frames[part.frame].name for part in dict(self.given_shapes).get(kind, ())]
            return tuple(dict.fromkeys(frames))
        links = [link for link in self.root.findall("link") if link.find(f"{kind}/geometry") is not None]
        return tuple(dict.fromkeys(link.get("name", "") for link in links))

    def readable_links(self, kind: str) -> set[str]:
        """Names of the links with such geometry whose mesh files are all found."""
        links = () if self.root is None else self.root.findall("link")
        meshes = {link.get("name", ""): link.iterfind(f"{kind}/geometry/mesh") for link in links}
        return {name for name in self.links_with(kind) if all(self.has_mesh(m) for m in meshes.get(name, ()))}

    def has_mesh(self, mesh: ET.Element) -> bool:
        """Whether the corners of a <mesh> can be had: from memory, or from a file in one of the folders."""
        return mesh.get(COMPILED_ATTRIBUTE) in self.meshes or find_mesh_file(mesh, self.folders) is not None

    @property
    def servos(self) -> tuple[Servo, ...]:
        """The position actuators of an MJCF file; () for others."""
        return () if self.root is None else read_servos(self.root)

    @property
    def link_masses(self) -> dict[str, float]:
        """The mass of each link by its name [kg].

        A model knows only that of all links of a joint, and it is given to the first of them.
        """
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

    def load_shapes(self, kind: str, links: Set[str] | None = None) -> tuple[LinkShape, ...]:
        """Shapes of these links, None: of all. Raises URDFError for meshes that are missing or cannot be read, and for
        shapes that are far too large for the robot.
        """
        found = self._load_any_shapes(kind, links)
        check_shapes(link_sizes(found, self.model), self.model)
        return found

    @lazy_property
    def collision_sizes(self) -> dict[str, LinkSize]:
        """How large the collision geometry of each link is whose mesh files are found; without those that cannot be
        read.
        """
        try:
            return link_sizes(self._load_any_shapes(COLLISION, self.readable_links(COLLISION)), self.model)
        except URDFError:
            return {}

    def _load_any_shapes(self, kind: str, links: Set[str] | None) -> tuple[LinkShape, ...]:
        if self.root is None:
            every = dict(self.given_shapes).get(kind, ())
            return tuple(p for p in every if links is None or self.model.frames[p.frame].name in links)
        if self.is_mjcf:
            return compiled_shapes(self.root, self.model, self.meshes, kind, links)
        reduced = copy.deepcopy(self.root)
        for link in reduced.findall("link"):
            wanted = links is None or link.get("name") in links
            for element in [e for e in link if e.tag in _GEOMETRY_TYPES and not (wanted and e.tag == kind)]:
                link.remove(element)  # its meshes may be missing
        resolve_meshes(reduced, self.folders)
        for mesh in reduced.iter("mesh"):
            if (unit := collada_unit(Path(mesh.get("filename", "")))) != 1.0:
                scale = unit * read_numbers(mesh.get("scale", "1 1 1"))
                mesh.set("scale", " ".join(repr(v) for v in scale.tolist()))
        with capture_stderr() as messages:
            try:
                text = ET.tostring(reduced, encoding="unicode")
                found = pin.buildGeomFromUrdfString(self.model, text, _GEOMETRY_TYPES[kind])
            except (ValueError, RuntimeError, MemoryError) as error:
                found, failure = None, str(error)
        detail = " ".join("".join(messages).split())
        if found is None:
            raise URDFError("source", f"{kind} geometry that can be loaded", f"{failure} {detail}".strip())
        if not len(found.geometryObjects) and links:
            expected = f"{kind} geometry for {', '.join(sorted(links))!r} that can be loaded, or a tip_radius"
            raise URDFError("source", expected, detail or "none that Pinocchio reads")
        return model_shapes(self.model, found)


# ----------------------------------------------------------------
# The XML of a robot: from a path or a string to its <robot> element, a URDF's own or that of an MJCF file.

_KINDS = URDF_TAG, MJCF_TAG = "robot", "mujoco"  # tags of the first element
_READERS = {URDF_TAG: "Hand.from_urdf", MJCF_TAG: "Hand.from_mjcf"}
_MAX_PATH_LETTERS = 4096  # letters of a path: what is longer is no path, on any system


def read_robot(
    argument: str, source: Any, base: str | None = None, package_dirs: Any = None, kinds: tuple[str, ...] = _KINDS
) -> tuple[RobotDescription, ET.Element, str]:
    """What a path, or a string that starts with "<", says of the robot below the link `base`, without Pinocchio's
    model; its <robot>; and what to call it in messages.

    kinds : formats that are welcome, by the tag of the first element. Raises URDFError for what is missing, unreadable,
    not XML, of another kind, or too large; UnknownName for the base; InputError; Unsupported without what reads it.
    """
    text, path = read_content(argument, source)
    if path is not None and path.suffix == ".xacro":
        text = expand_xacro(argument, path, text, package_folders(package_dirs, None))
    label = "the XML string" if path is None else str(path)
    shown = label if path is None else repr(label)
    root = parse_xml(argument, text, shown, URDFError)
    if root.tag not in kinds:
        hint = f" ({_READERS[root.tag]} reads <{root.tag}>)" if root.tag in _READERS else ""
        expected = f"a {' or '.join(f'<{kind}>' for kind in kinds)} element at the top{hint}"
        raise URDFError(argument, expected, f"<{root.tag}> in {shown}")
    if path is None and any("xacro" in tag for tag in {e.tag for e in root}):
        raise URDFError(argument, "a URDF, or the path of a xacro file, which is expanded", f"macros in {shown}")
    doubts, meshes = tuple[Doubt, ...](), dict[str, CompiledMesh]()
    if root.tag == MJCF_TAG:
        root, doubts, meshes = convert_to_urdf(text.decode() if path is None else "", path, base)
    root = check_robot(argument, root, base, shown)
    name, folders = root.get("name", "") if path is None else path.name, mesh_folders(package_dirs, path)
    doubts = (*doubts, *several_robots_doubts(root))
    return RobotDescription(name, None, read_joint_facts(root), root, folders, (), doubts, meshes), root, label


def read_content(argument: str, source: Any) -> tuple[bytes, Path | None]:
    """Bytes, and the path that they are from."""
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        text = source.lstrip("\ufeff \t\r\n").encode(errors="replace")
        if len(text) > MAX_XML_BYTES:
            raise URDFError(argument, f"at most {MAX_XML_BYTES // 10**6} MB of XML", f"{len(text) / 1e6:.0f} MB")
        return text, None
    try:
        path = Path(source)
    except TypeError:
        expected = "the path of a URDF file, or its text; Hand.from_model takes a pinocchio.Model"
        raise InputError(argument, expected, repr(source)[:80]) from None
    if len(name := str(path)) > _MAX_PATH_LETTERS:
        raise URDFError(argument, "the path of a URDF file", f"{name[:60]!r}…, a name of {len(name)} letters")
    return read_bytes(argument, path, "a URDF file", MAX_XML_BYTES, URDFError), path


# ----------------------------------------------------------------
# From a path, an XML string, or a Pinocchio model to a `RobotDescription`.


def describe_xml(
    argument: str, source: Any, base: str | None = None, package_dirs: Any = None, kinds: tuple[str, ...] = _KINDS
) -> RobotDescription:
    """Of a URDF or MJCF file, or of such a text; arguments as of `read_robot` and `Hand.from_urdf`.

    Raises URDFError, UnknownName, InputError, and Unsupported for an MJCF file without MuJoCo, a xacro file without
    xacrodoc.
    """
    described, root, label = read_robot(argument, source, base, package_dirs, kinds)
    check_friction(argument, root)
    model = build_model(argument, root, label)
    check_units(argument, model)
    return replace(described, model=model)


def describe_model(argument: str, source: Any) -> RobotDescription:
    """Of a pinocchio.Model, or a RobotWrapper, whose collision and visual geometry come with it.

    Raises InputError for what is none, is too large, or has mimic joints; URDFError for units that look wrong.
    """
    model = getattr(source, "model", source)
    if not isinstance(model, pin.Model):
        raise InputError(argument, "a pinocchio.Model or a pinocchio.RobotWrapper", repr(source)[:80])
    if model.nv > MAX_JOINTS:
        raise InputError(argument, f"a model of at most {MAX_JOINTS} degrees of freedom", f"{model.nv}")
    if mimic := [name for name, joint in zip(model.names, model.joints, strict=True) if "Mimic" in joint.shortname()]:
        expected = "a model built with mimic=False (Hand.from_urdf reads <mimic> tags itself)"
        raise InputError(argument, expected, f"mimic joints: {', '.join(mimic)}")
    model = pin.Model(model)
    check_units(argument, model)
    given = []
    for kind in (COLLISION, VISUAL):
        geometry = getattr(source, f"{kind}_model", None)
        if isinstance(geometry, pin.GeometryModel):
            given.append((kind, model_shapes(model, geometry)))
    return RobotDescription(str(model.name), model, read_model_facts(model), given_shapes=tuple(given))


# ----------------------------------------------------------------
# Whether a file holds several robots: two arms on a stand, or a left and a right hand in one world.

_MIN_CARRIED_FINGERS = 2  # ends of chains below a link: with as many it carries a hand of its own
_MIN_ARM_JOINTS = 6  # movable joints one after the other: no finger has as many


def several_robots_doubts(root: ET.Element) -> Iterator[Doubt]:
    """A doubt where the first link that branches carries two or more robots. root : the <robot> as it is read."""
    below = dict[str, list[ET.Element]]()
    for joint in root.findall("joint"):
        below.setdefault(joint_link(joint, "parent"), []).append(joint)
    moved = {joint_link(joint, "child") for joint in root.findall("joint")}
    links = [name for link in root.findall("link") if (name := link.get("name", "")) not in moved]
    seen = set[str]()
    while len(links) == 1 and links[0] not in seen:  # a circle is said where the model is built
        seen.add(links[0])
        children = [(joint, joint_link(joint, "child")) for joint in below.get(links[0], ())]
        links = [child for joint, child in children if _is_movable(joint) or _count_chains(child, below)[0]]
    robots = []
    for name in links:
        ends, longest = _count_chains(name, below)
        if ends >= _MIN_CARRIED_FINGERS or longest >= _MIN_ARM_JOINTS - 1:  # one more moves this link itself
            robots.append(name)
    if len(robots) > 1:
        what = f"the file holds several robots, which are read as one hand: {', '.join(robots)}"
        yield Doubt("hand", what, f"base={robots[0]!r}, or another link that carries one hand", "serious", "robots")


def _count_chains(link: str, below: dict[str, list[ET.Element]]) -> tuple[int, int]:
    """How many movable joints below a link have none below themselves, and the most of them in a row."""
    stack, seen = list[tuple[str, tuple[str, ...], int]]([(link, (), 0)]), {link}
    every, inner, longest = set[str](), set[str](), 0
    while stack:
        at, last, count = stack.pop()
        longest = max(longest, count)
        for joint in below.get(at, ()):
            child, name = joint_link(joint, "child"), joint.get("name", "")
            if child in seen:
                continue
            seen.add(child)
            if _is_movable(joint):
                every.add(name)
                inner.update(last)
            stack.append((child, (name,) if _is_movable(joint) else last, count + _is_movable(joint)))
    return len(every - inner), longest


def _is_movable(joint: ET.Element) -> bool:
    return joint.get("type") not in (None, "fixed")


# ----------------------------------------------------------------
# The routes of an MJCF file's tendons, for whoever says the rest of them.


@check_call()
def tendon_routes(source: Any) -> dict[str, Route]:
    """The spatial tendons of an MJCF file as routes, by name, for `Tendons`; those that are sums of joint angles are
    left out.

    source : as of `Hand.from_mjcf`. Raises Unsupported for a tendon that runs through the inside of a body, naming it,
    and without MuJoCo; URDFError as `Hand.from_mjcf`.
    """
    text, path = read_content("source", source)
    read, refused = read_routes(compile_mjcf(text.decode() if path is None else "", path))
    if refused:
        raise Unsupported("; ".join([f"tendon {name!r}: {why}" for name, why in refused.items()]))
    return read
