"""`check_mjcf_size`: how much an MJCF file asks MuJoCo to build, counted before MuJoCo compiles it."""

from __future__ import annotations

import math
import struct
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

from handlcp.errors import URDFError, why_unreadable
from handlcp.read_file import MAX_MESH_BYTES, MAX_XML_BYTES, parse_xml, read_bytes

MAX_BUILT_ELEMENTS = 10_000  # elements, those that are replicated counted each time; real hands have some hundred
_MAX_PIXELS = 100_000_000  # of all textures together: 300 MB
_MAX_HEIGHTS = 10_000_000  # of all height fields together
# Of the simulation that measures the length of an actuator; MuJoCo's own number is 1000
_MAX_LENGTHRANGE_STEPS = 10_000
_MAX_INCLUDE_DEPTH = 20  # files that include each other
_REPLICATING_TAGS = ("replicate", "composite", "flexcomp")  # count : how often
_FILE_TAGS = ("mesh", "hfield", "texture", "skin", "flexcomp")

# Element ("" : any), attribute → the largest number that is allowed in it. Memory is taken for each.
_MAX_VALUES = {
    ("size", "nkey"): 10_000,
    ("size", "njmax"): 1_000_000,
    ("size", "nconmax"): 1_000_000,
    ("size", "nstack"): 10_000_000,
    ("size", "nuserdata"): 1_000_000,
    **{("size", f"nuser_{of}"): 1000 for of in ("body", "jnt", "geom", "site", "cam", "tendon", "actuator", "sensor")},
    ("user", "dim"): 1000,
    ("", "actdim"): 1000,
    ("", "nsample"): 1000,
    ("mesh", "octree_maxdepth"): 6,
    ("mesh", "params"): 100,
}


def check_mjcf_size(argument: str, text: bytes, path: Path | None) -> None:
    """Raises URDFError for an MJCF text that asks for more than a hand needs. path : of its file; None: a string."""
    shown = "the XML string" if path is None else repr(str(path))
    counted = _ModelCount(argument, path, shown, len(text))
    if counted.count(parse_xml(argument, text, shown, URDFError)) > MAX_BUILT_ELEMENTS:
        expected = f"a model of at most {MAX_BUILT_ELEMENTS} elements, those of copies counted each time"
        raise counted.refuse(expected, "more")


class _ModelCount:
    """Counts one model with all that it includes."""

    def __init__(self, argument: str, path: Path | None, shown: str, size: int) -> None:
        self._argument, self._folder = argument, Path() if path is None else path.parent
        self._shown, self._bytes, self._pixels, self._heights = shown, size, 0.0, 0.0
        self._count_by_file = dict[Path, float]()  # how much an included file builds
        self._open_files = list[Path]() if path is None else [path.resolve()]
        self._largest_attached = 0.0  # the most that a model which can be attached builds
        self._folders = [self._folder]  # where files may be

    def refuse(self, expected: str, came: str) -> URDFError:
        return URDFError(self._argument, expected, f"{self._shown}, with {came}")

    def count(self, root: ET.Element) -> float:
        """How many elements a file builds. Numbers, files and models to attach are looked at before."""
        for compiler in root.iter("compiler"):
            named = [compiler.get(name) for name in ("meshdir", "assetdir", "texturedir")]
            self._folders += [folder / name for folder in self._folders[:1] for name in named if name]
        for element in root.iter():
            self._check_numbers(element)
            if element.tag in _FILE_TAGS and element.get("file"):
                self._check_file(element.get("file", ""))
        for model in root.iter("model"):
            self._largest_attached = max(self._largest_attached, self._count_included(model))
        return sum(self._count_element(child) for child in root)

    def _count_element(self, element: ET.Element) -> float:
        """How many elements this one builds."""
        if element.tag == "include":
            return 1 + self._count_included(element)
        if element.tag == "attach":
            return 1 + self._largest_attached
        within = 1 + sum(self._count_element(child) for child in element)
        if element.tag in _REPLICATING_TAGS:
            return within * math.prod(max(1.0, x) for x in _attribute_numbers(element.get("count", "")))
        return within

    def _count_included(self, element: ET.Element) -> float:
        """How much the file that an element names builds; 0 where there is none, which MuJoCo says."""
        name = element.get("file", "")
        folders = (self._folder, self._open_files[-1].parent if self._open_files else self._folder)
        found = [folder / name for folder in folders if name and _is_there(folder / name)]
        if not found:
            return 0.0
        file = found[0].resolve()
        if file in self._count_by_file:
            return self._count_by_file[file]
        if file in self._open_files or len(self._open_files) > _MAX_INCLUDE_DEPTH:
            raise self.refuse("files that do not include each other", f"{name!r} in a circle")
        data = read_bytes(self._argument, file, "an MJCF file", MAX_XML_BYTES, URDFError)
        self._bytes += len(data)
        if self._bytes > MAX_XML_BYTES:
            raise self.refuse(f"at most {MAX_XML_BYTES // 10**6} MB of XML, with all includes", "more")
        root = parse_xml(self._argument, data, repr(str(file)), URDFError)
        self._open_files.append(file)
        self._count_by_file[file] = built = self.count(root)
        self._open_files.pop()
        return built

    def _check_numbers(self, element: ET.Element) -> None:
        for attribute, text in element.attrib.items():
            largest = _MAX_VALUES.get((element.tag, attribute), _MAX_VALUES.get(("", attribute), math.inf))
            if largest < math.inf and max(_attribute_numbers(text), default=0.0) > largest:
                raise self.refuse(f"at most {largest} as {attribute} of <{element.tag}>", repr(text[:40]))
        if element.tag == "texture":
            sides = 6 if element.get("type", "cube") != "2d" else 1
            self._pixels += sides * _largest_number(element, "width") * _largest_number(element, "height")
        if element.tag == "hfield":
            self._heights += _largest_number(element, "nrow") * _largest_number(element, "ncol")
        if self._pixels > _MAX_PIXELS or self._heights > _MAX_HEIGHTS:
            raise self.refuse(f"textures of at most {_MAX_PIXELS} pixels, {_MAX_HEIGHTS} heights", "more")
        if element.tag == "lengthrange":
            total, step = _largest_number(element, "inttotal", 10.0), _largest_number(element, "timestep", 0.01)
            if not 0.0 < total <= _MAX_LENGTHRANGE_STEPS * step:
                expected = f"a <lengthrange> of at most {_MAX_LENGTHRANGE_STEPS} steps"
                raise self.refuse(expected, f"{total:g} s of {step:g} s")

    def _check_file(self, name: str) -> None:
        """Raises URDFError for a mesh or picture that is too large, or is none."""
        for file in dict.fromkeys(f for folder in self._folders for f in (folder / name, folder / Path(name).name)):
            if _is_there(file):
                data = read_bytes(self._argument, file, "a mesh or picture", MAX_MESH_BYTES, URDFError)
                if data[:8] == b"\x89PNG\r\n\x1a\n" and len(data) >= 24:
                    self._pixels += math.prod(struct.unpack(">II", data[16:24]))


def _is_there(file: Path) -> bool:
    """Whether there is something of this name, a file or not."""
    return not (why := why_unreadable(file)) or why in ("is a folder", "is no file")


def _largest_number(element: ET.Element, attribute: str, default: float = 0.0) -> float:
    return max(_attribute_numbers(element.get(attribute, "")), default=default)


def _attribute_numbers(text: str) -> Iterator[float]:
    """Those of an attribute; what is none counts as 0."""
    for word in text.split():
        try:
            value = float(word)
        except ValueError:
            continue
        yield value if value == value else math.inf
