"""A robot as it was read, before anything is said about fingertips, stiffness or torques; and reading it."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import pinocchio as pin

from handlcp.errors import InputError, URDFError
from handlcp.hand.robot.joints import Doubt, JointFacts, joint_facts, model_facts
from handlcp.hand.robot.source.part import COMPILED, CompiledMesh, Part, compiled_parts, numbers_of, parts_of
from handlcp.hand.robot.source.robots import several_robots
from handlcp.hand.robot.source.stated import Servo, check_friction, servos_of
from handlcp.hand.robot.source.units import LinkSize, check_shapes, check_units, collada_unit, link_sizes
from handlcp.hand.robot.urdf import (
    MOST_JOINTS,
    build_model,
    captured_stderr,
    check_robot,
    mesh_file,
    mesh_folders,
    package_folders,
    resolve_meshes,
)
from handlcp.lazy import lazy
from handlcp.read_file import MOST_XML, parse_xml, read_bytes

COLLISION, VISUAL = "collision", "visual"
_KINDS = {COLLISION: pin.GeometryType.COLLISION, VISUAL: pin.GeometryType.VISUAL}


@dataclass(frozen=True, eq=False)
class Description:
    """Nothing of it is changed once it is made; threads may share it.

    source : name of the file, or of the model. model : Pinocchio's, without mimic joints; None: not made.
    facts : of movable joints. root : the <robot>, None for a model. folders : where meshes are looked up.
    given : parts by kind, of a model that came with geometry. doubts : found while reading. meshes : those that
    MuJoCo compiled of an MJCF file, by name.
    """

    source: str
    model: Any
    facts: tuple[JointFacts, ...]
    root: ET.Element | None = None
    folders: tuple[Path, ...] = ()
    given: tuple[tuple[str, tuple[Part, ...]], ...] = ()
    doubts: tuple[Doubt, ...] = ()
    meshes: Mapping[str, CompiledMesh] = field(default_factory=dict)

    @property
    def mjcf(self) -> bool:
        """Whether it was read from an MJCF file."""
        return self.root is not None and self.root.get("format") == "mjcf"

    def has(self, kind: str) -> tuple[str, ...]:
        """Names of the links with such geometry, each once."""
        if self.root is None:
            frames = [self.model.frames[part.frame].name for part in dict(self.given).get(kind, ())]
            return tuple(dict.fromkeys(frames))
        links = [link for link in self.root.findall("link") if link.find(f"{kind}/geometry") is not None]
        return tuple(dict.fromkeys(link.get("name", "") for link in links))

    def readable(self, kind: str) -> set[str]:
        """Names of the links with such geometry whose mesh files are all found."""
        links = () if self.root is None else self.root.findall("link")
        meshes = {link.get("name", ""): link.iterfind(f"{kind}/geometry/mesh") for link in links}
        return {name for name in self.has(kind) if all(self.found(m) for m in meshes.get(name, ()))}

    def found(self, mesh: ET.Element) -> bool:
        """Whether the corners of a <mesh> can be had: from memory, or from a file in one of the folders."""
        return mesh.get(COMPILED) in self.meshes or mesh_file(mesh, self.folders) is not None

    @property
    def servos(self) -> tuple[Servo, ...]:
        """The position actuators of an MJCF file; () for others."""
        return () if self.root is None else servos_of(self.root)

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
        """Shapes of these links, None: of all. Raises URDFError for meshes that are missing or cannot be read, and for
        shapes that are far too large for the robot.
        """
        found = self._parts(kind, links)
        check_shapes(link_sizes(found, self.model), self.model)
        return found

    @lazy
    def sizes(self) -> dict[str, LinkSize]:
        """How large the collision geometry of each link is whose mesh files are found; without those that cannot be
        read.
        """
        try:
            return link_sizes(self._parts(COLLISION, self.readable(COLLISION)), self.model)
        except URDFError:
            return {}

    def _parts(self, kind: str, links: Set[str] | None) -> tuple[Part, ...]:
        if self.root is None:
            every = dict(self.given).get(kind, ())
            return tuple(p for p in every if links is None or self.model.frames[p.frame].name in links)
        if self.mjcf:
            return compiled_parts(self.root, self.model, self.meshes, kind, links)
        return self._loaded(self.root, kind, links)

    def _loaded(self, root: ET.Element, kind: str, links: Set[str] | None) -> tuple[Part, ...]:
        reduced = copy.deepcopy(root)
        for link in reduced.findall("link"):
            wanted = links is None or link.get("name") in links
            for element in [e for e in link if e.tag in _KINDS and not (wanted and e.tag == kind)]:
                link.remove(element)  # its meshes may be missing
        resolve_meshes(reduced, self.folders)
        for mesh in reduced.iter("mesh"):
            if (unit := collada_unit(Path(mesh.get("filename", "")))) != 1.0:
                scale = unit * numbers_of(mesh.get("scale", "1 1 1"))
                mesh.set("scale", " ".join(repr(v) for v in scale.tolist()))
        with captured_stderr() as messages:
            try:
                text = ET.tostring(reduced, encoding="unicode")
                found = pin.buildGeomFromUrdfString(self.model, text, _KINDS[kind])
            except (ValueError, RuntimeError, MemoryError) as error:
                found, failure = None, str(error)
        detail = " ".join("".join(messages).split())
        if found is None:
            raise URDFError("source", f"{kind} geometry that can be loaded", f"{failure} {detail}".strip())
        if not len(found.geometryObjects) and links:
            expected = f"{kind} geometry for {', '.join(sorted(links))!r} that can be loaded, or a tip_radius"
            raise URDFError("source", expected, detail or "none that Pinocchio reads")
        return parts_of(self.model, found)


# ----------------------------------------------------------------
# The XML of a robot: from a path or a string to its <robot> element, a URDF's own or that of an MJCF file.

URDF, MJCF = "robot", "mujoco"  # tags of the first element
_ADVICE = {URDF: "Hand.from_urdf", MJCF: "Hand.from_mjcf"}
_STRING = "the XML string"
_LONGEST_NAME = 4096  # letters of a path: what is longer is no path, on any system


class RobotFile(NamedTuple):
    """root : the <robot>. path : None for a text. doubts : what was read in a way worth knowing. meshes : those that
    MuJoCo compiled.
    """

    root: ET.Element
    path: Path | None
    doubts: tuple[Doubt, ...]
    meshes: Mapping[str, CompiledMesh]


def robot_of(
    argument: str,
    source: Any,
    base: str | None = None,
    kinds: tuple[str, ...] = (URDF, MJCF),
    package_dirs: Any = None,
) -> RobotFile:
    """The <robot> of a path, or of a string that starts with "<", below the link `base`.

    kinds : formats that are welcome, by the tag of the first element. Raises URDFError for what is missing, unreadable,
    not XML, of another kind, or too large; UnknownName for the base; InputError; Unsupported without what reads it.
    """
    text, path = content(argument, source)
    if path is not None and path.suffix == ".xacro":
        from handlcp.hand.robot.source.xacro import expanded

        text = expanded(argument, path, text, package_folders(package_dirs, None))
    shown = _STRING if path is None else repr(str(path))
    root = parse_xml(argument, text, shown, URDFError)
    if root.tag not in kinds:
        raise URDFError(argument, _wanted(kinds, root.tag), f"<{root.tag}> in {shown}")
    if path is None and any("xacro" in tag for tag in {e.tag for e in root}):
        raise URDFError(argument, "a URDF, or the path of a xacro file, which is expanded", f"macros in {shown}")
    doubts, meshes = tuple[Doubt, ...](), dict[str, CompiledMesh]()
    if root.tag == MJCF:
        from handlcp.hand.robot.source.mjcf import urdf_of_mjcf

        root, doubts, meshes = urdf_of_mjcf(text.decode() if path is None else "", path, base)
    root = check_robot(argument, root, base, shown)
    return RobotFile(root, path, (*doubts, *several_robots(root)), meshes)


def content(argument: str, source: Any) -> tuple[bytes, Path | None]:
    """Bytes, and the path that they are from."""
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        text = source.lstrip("\ufeff \t\r\n").encode(errors="replace")
        if len(text) > MOST_XML:
            raise URDFError(argument, f"at most {MOST_XML // 10**6} MB of XML", f"{len(text) / 1e6:.0f} MB")
        return text, None
    try:
        path = Path(source)
    except TypeError:
        expected = "the path of a URDF file, or its text; Hand.from_model takes a pinocchio.Model"
        raise InputError(argument, expected, repr(source)[:80]) from None
    if len(name := str(path)) > _LONGEST_NAME:
        raise URDFError(argument, "the path of a URDF file", f"{name[:60]!r}…, a name of {len(name)} letters")
    return read_bytes(argument, path, "a URDF file", MOST_XML, URDFError), path


def _wanted(kinds: tuple[str, ...], came: str) -> str:
    """What was expected, and who reads what came."""
    names = " or ".join(f"<{kind}>" for kind in kinds)
    hint = f" ({_ADVICE[came]} reads <{came}>)" if came in _ADVICE else ""
    return f"a {names} element at the top{hint}"


# ----------------------------------------------------------------
# From a path, an XML string, or a Pinocchio model to a `Description`.


def describe_xml(
    argument: str, source: Any, base: str | None = None, package_dirs: Any = None, kinds: tuple[str, ...] = (URDF, MJCF)
) -> Description:
    """Of a URDF or MJCF file, or of such a text; arguments as of `robot_of` and `Hand.from_urdf`.

    Raises URDFError, UnknownName, InputError, and Unsupported for an MJCF file without MuJoCo, a xacro file without
    xacrodoc.
    """
    root, path, doubts, meshes = robot_of(argument, source, base, kinds, package_dirs)
    folders = mesh_folders(package_dirs, path)
    check_friction(argument, root)
    model = build_model(argument, root, str(path) if path is not None else _STRING)
    check_units(argument, model)
    short = path.name if path is not None else str(model.name)
    return Description(short, model, joint_facts(root), root, folders, (), doubts, meshes)


def describe_model(argument: str, source: Any) -> Description:
    """Of a pinocchio.Model, or a RobotWrapper, whose collision and visual geometry come with it.

    Raises InputError for what is none, is too large, or has mimic joints; URDFError for units that look wrong.
    """
    model = getattr(source, "model", source)
    if not isinstance(model, pin.Model):
        raise InputError(argument, "a pinocchio.Model or a pinocchio.RobotWrapper", repr(source)[:80])
    if model.nv > MOST_JOINTS:
        raise InputError(argument, f"a model of at most {MOST_JOINTS} degrees of freedom", f"{model.nv}")
    if mimic := [name for name, joint in zip(model.names, model.joints, strict=True) if "Mimic" in joint.shortname()]:
        expected = "a model built with mimic=False (Hand.from_urdf reads <mimic> tags itself)"
        raise InputError(argument, expected, f"mimic joints: {', '.join(mimic)}")
    model = pin.Model(model)
    check_units(argument, model)
    given = []
    for kind in (COLLISION, VISUAL):
        geometry = getattr(source, f"{kind}_model", None)
        if isinstance(geometry, pin.GeometryModel):
            given.append((kind, parts_of(model, geometry)))
    return Description(str(model.name), model, model_facts(model), given=tuple(given))
