"""`check_robot` and what else a URDF goes through: cut out the hand, check its numbers, find its meshes, and make
Pinocchio's model of it.

Pinocchio reports a broken URDF only on the stderr of the process, so file descriptor 2 is captured while it parses.
"""

from __future__ import annotations

import math
import os
import re
import tempfile
import threading
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pinocchio as pin

from handlcp import words
from handlcp.errors import InputError, UnknownName, URDFError, missing_library, why_unreadable
from handlcp.robot.mesh_file import check_mesh_file

LARGEST_NUMBER = 1e6  # metres, kilograms, radians, ratios: no hand is larger
MIN_MESH_SCALE = 1e-9  # of meshes: nanometres
MAX_ELEMENTS = 1500  # links, joints, materials of a robot: libraries below read them with one call inside another
MAX_JOINTS = 150  # that move: Pinocchio's data take 32 bytes times their cube

# Element, attribute, how many numbers, least value. Pinocchio silently drops numbers that it cannot read.
_NUMBER_ATTRIBUTES = (
    ("origin", "xyz", 3, -math.inf),
    ("origin", "rpy", 3, -math.inf),
    ("mass", "value", 1, 0.0),
    *(("inertia", name, 1, -math.inf) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    ("sphere", "radius", 1, 0.0),
    ("cylinder", "radius", 1, 0.0),
    ("cylinder", "length", 1, 0.0),
    ("box", "size", 3, 0.0),
    ("mesh", "scale", 3, -math.inf),
)
# What stands beside links and joints
_KEPT_TAGS = ("material", "transmission", "ros2_control", "servo", "cable", "pin")
_STDERR_LOCK = threading.Lock()


def check_robot(argument: str, root: ET.Element, base: str | None, shown: str) -> ET.Element:
    """A <robot> that is small enough to be a hand, cut down to the link `base` and those below it; numbers checked.

    shown : what to call it in messages. Raises URDFError, UnknownName for the base, InputError.
    """
    if base is not None and not isinstance(base, str):
        raise InputError("base", "the name of a link, or None", repr(base))
    if len(root) > MAX_ELEMENTS:
        expected = f"a robot of at most {MAX_ELEMENTS} links and joints"
        raise URDFError(argument, expected, f"{shown} with {len(root)}")
    root = root if base is None else _cut_below(root, base)
    moving = sum(joint.get("type") != "fixed" for joint in root.findall("joint"))
    if moving > MAX_JOINTS:
        expected = f"a hand of at most {MAX_JOINTS} movable joints (base= cuts it out of a larger robot)"
        raise URDFError(argument, expected, f"{shown} with {moving}")
    _check_numbers(argument, root)
    return root


def _cut_below(root: ET.Element, base: str) -> ET.Element:
    """The robot below link `base`; the frame of that link is its world frame. Raises UnknownName."""
    links = [name for link in root.findall("link") if (name := link.get("name"))]
    if base not in links:
        raise UnknownName("base", "a link", [str(base)], links)
    kept, joints = {base}, set[ET.Element]()
    while more := [j for j in root.findall("joint") if j not in joints and joint_link(j, "parent") in kept]:
        joints.update(more)
        kept.update(joint_link(joint, "child") for joint in more)
    cut = ET.Element("robot", root.attrib)
    cut.extend(e for e in root if (e.tag == "link" and e.get("name") in kept) or e in joints or e.tag in _KEPT_TAGS)
    return cut


def _check_numbers(argument: str, root: ET.Element) -> None:
    """Raises URDFError for a length, an angle, a mass or an inertia that is not the finite number it should be."""
    for owner in root:
        for tag, attribute, count, least in _NUMBER_ATTRIBUTES:
            for text in (element.get(attribute) for element in owner.iter(tag)):
                if text is not None and not _are_numbers(text, count, least, MIN_MESH_SCALE * (attribute == "scale")):
                    bound = f"from 0 to {LARGEST_NUMBER:g}" if least == 0.0 else f"of at most ±{LARGEST_NUMBER:g}"
                    bound += f", at least ±{MIN_MESH_SCALE:g}," if attribute == "scale" else ""
                    expected = f"{count} number{'s' if count > 1 else ''} {bound} in <{tag} {attribute}=…>"
                    raise URDFError(argument, f"{expected} of {owner.tag} {owner.get('name')!r}", repr(text))


def _are_numbers(text: str, count: int, least: float, smallest: float) -> bool:
    """Whether they lie between `least` and the largest number, each of a magnitude of at least `smallest`."""
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return False
    low = max(least, -LARGEST_NUMBER)
    return len(values) == count and all(low <= v <= LARGEST_NUMBER and abs(v) >= smallest for v in values)


def build_model(argument: str, root: ET.Element, label: str) -> Any:
    """Pinocchio's model, which ignores mimic tags. Raises URDFError with the parser's own message."""
    with capture_stderr() as messages:
        try:
            return pin.buildModelFromXML(ET.tostring(root, encoding="unicode"))
        except (ValueError, RuntimeError, MemoryError) as error:
            failure = str(error)
    details = [line.strip() for line in "".join(messages).splitlines() if not line.strip().startswith("at line")]
    raise URDFError(argument, "a URDF that describes a robot", f"{label}: {'; '.join(details) or failure}")


def package_folders(package_dirs: Any, path: Path | None) -> tuple[Path, ...]:
    """Where package:// addresses are looked up: folders given, the URDF's own, ROS_PACKAGE_PATH. Raises InputError."""
    given = () if package_dirs is None else [package_dirs] if isinstance(package_dirs, (str, Path)) else package_dirs
    try:
        folders = [Path(folder) for folder in given]
    except TypeError:
        raise InputError("package_dirs", "a folder or a sequence of folders", repr(package_dirs)) from None
    for folder in folders:
        if why_unreadable(folder) != "is a folder":
            raise InputError("package_dirs", "folders that exist", repr(str(folder)))
    if path is not None:
        folders += [path.parent, *path.parent.resolve().parents[:4]]
    return (*folders, *(Path(p) for p in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if p))


def mesh_folders(package_dirs: Any, path: Path | None) -> tuple[Path, ...]:
    """Where meshes are looked up: as packages are; of a text, which has no folder, last in the working directory."""
    return (*package_folders(package_dirs, path), *(() if path is not None else (Path.cwd(),)))


def find_mesh_file(mesh: ET.Element, folders: Sequence[Path]) -> Path | None:
    """The file that a <mesh> addresses, or names whole; None where it is in none of the folders."""
    tail = mesh.get("filename", "").split("://", 1)[-1]
    places = [folder / tail for folder in folders] if tail and not Path(tail).is_absolute() else [Path(tail)]
    return next((p for p in places if tail and not why_unreadable(p)), None)


def resolve_meshes(element: ET.Element, folders: Sequence[Path]) -> None:
    """Replace the address of each mesh below `element` by its full path. Raises URDFError for a file that is missing,
    or none of a mesh.
    """
    checked = set[Path]()
    for mesh in element.iter("mesh"):
        found = find_mesh_file(mesh, folders)
        if found is None:
            where = ", ".join(str(f) for f in folders) or "nowhere"
            expected = f"a folder that holds {mesh.get('filename', '')!r}"
            raise URDFError("package_dirs", expected, f"folders without it: {where}")
        if found not in checked:
            check_mesh_file("source", found, URDFError)
            checked.add(found)
        mesh.set("filename", str(found.resolve()))


@contextmanager
def capture_stderr() -> Iterator[list[str]]:
    """Collect what C code writes to stderr; the list is filled when the block ends. One thread at a time."""
    collected: list[str] = []
    with _STDERR_LOCK, tempfile.TemporaryFile() as sink:
        saved = os.dup(2)
        try:
            os.dup2(sink.fileno(), 2)
            yield collected
        finally:
            os.dup2(saved, 2)
            os.close(saved)
            sink.seek(0)
            collected.append(sink.read().decode(errors="replace"))


def joint_link(joint: ET.Element, end: str) -> str:
    """The link at one end of a joint, "parent" or "child"; "" where there is none."""
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


# ----------------------------------------------------------------
# A xacro file, URDF with macros, expanded to the URDF that it means, by the package xacrodoc, which needs no ROS.
#
# xacro keeps the file that it reads, and the folders of packages, in variables of its modules. They are set for each
# file here, one file at a time: what was read before, and the working directory, make no difference.

_MACRO_TAG = re.compile(rb"<[\w.-]+:macro\s[^>]*?name\s*=\s*[\"']([^\"']+)[\"']")
_ELEMENT_TAG = re.compile(rb"<(link|joint)[\s/>]")
_EXPANSION_LOCK = threading.Lock()


def expand_xacro(argument: str, path: Path, text: bytes, folders: Sequence[Path]) -> bytes:
    """The URDF, with the default of every argument of the file. text : of the file. folders : where $(find package) is
    looked up, besides the folders above the file.

    Raises Unsupported without xacrodoc; URDFError for a file that it refuses, and for one of macros that calls none.
    """
    try:
        import xacrodoc.xacrodoc as library
        from xacrodoc import XacroDoc, packages
    except ImportError:
        raise missing_library("no xacro file is expanded without xacrodoc", "xacrodoc") from None
    file = path.resolve()
    with _EXPANSION_LOCK:
        packages.reset()  # it keeps the folders of former files
        if folders:
            packages.look_in([str(folder) for folder in folders])
        try:
            library.xacro.init_stacks(str(file))  # what is included is looked up beside the file that includes it
            urdf = str(XacroDoc.from_file(str(file), resolve_packages=False).dom.toxml()).encode()
        except Exception as error:  # a file runs expressions, which raise what they like
            shown = f"{str(path)!r}: {' '.join(str(error).split()) or type(error).__name__}"
            raise URDFError(argument, "a xacro file that can be expanded", shown[:400]) from None
        finally:
            library.xacro.init_stacks(None)
    macros = [name.decode(errors="replace") for name in _MACRO_TAG.findall(text)]
    if macros and not _ELEMENT_TAG.search(urdf):
        came = f"{str(path)!r}, which defines macros ({words.list_names(macros)}) and calls none: it makes no link"
        raise URDFError(argument, "a xacro file that makes a robot, such as the one that includes this one", came)
    return urdf
