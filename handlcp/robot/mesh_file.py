"""`check_mesh_file`: mesh files looked at before assimp reads them: their kind, size, and what they unfold to."""

from __future__ import annotations

import math
import re
from collections import defaultdict, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from math import isfinite
from pathlib import Path

import numpy as np

from handlcp.errors import InputError, why_unreadable
from handlcp.read_file import MAX_MESH_BYTES, ElementCounter, InputErrorClass, read_bytes, walk_xml

MESH_SUFFIXES = (".stl", ".obj", ".dae", ".ply")
MESH_FILE_EXPECTED = "an STL, OBJ, DAE or PLY file"
# Nodes and geometries of a Collada scene, each counted as often as it stands there: 5 kB each
_MAX_NODE_COPIES = 10_000
_MATERIAL_LINE = re.compile(rb"^\s*mtllib\s+(.*?)\s*$", re.MULTILINE)
# Elements of Collada whose text is whole numbers, and numbers
_INTEGER_TAGS = ("p", "v", "h", "vcount", "int_array")
_REAL_TAGS = ("float_array", "matrix", "rotate", "translate", "scale", "lookat", "skew", "bind_shape_matrix")
_UNIT_RANGE = 1e-9, 1e3  # metres of one: from nanometres to kilometres
_INSTANCE_TAGS = ("instance_node", "instance_geometry", "instance_controller")


def check_mesh_file(argument: str, file: Path, error: InputErrorClass = InputError) -> None:
    """Raises `error` for a file that is missing, too large, of another kind than its ending says, or unfolds to more
    than it seems to hold.
    """
    data = read_bytes(argument, file, "a mesh file", MAX_MESH_BYTES, error)
    kind, shown = file.suffix.lower(), repr(str(file))
    if kind not in MESH_SUFFIXES:
        raise error(argument, f"{MESH_FILE_EXPECTED} (hl.Mesh takes what trimesh has loaded, too)", shown)
    if kind == ".dae":
        scene = _ColladaScene(argument, shown, error)
        walk_xml(data, scene)
        scene.check(len(data))
    elif kind == ".obj":
        for name in _MATERIAL_LINE.findall(data):  # assimp would wait for a device
            beside = file.parent / name.decode(errors="replace")
            if why := why_unreadable(beside):
                if why != "does not exist":
                    raise error(argument, "an OBJ file with files of materials", f"{shown}: {name!r}, which {why}")
            else:
                read_bytes(argument, beside, "a file of materials", MAX_MESH_BYTES, error)
    elif kind == ".ply":
        try:
            _check_ply(data)
        except (ValueError, KeyError, IndexError, OverflowError):
            raise error(argument, "a PLY file", f"{shown}, which does not hold what its header lists") from None


class _ColladaScene(ElementCounter):
    """What stands in which node of a Collada file: nodes stand in nodes, and are copied into others by name."""

    def __init__(self, argument: str, shown: str, error: InputErrorClass) -> None:
        super().__init__(argument, shown, error)
        self._contents = defaultdict[int, list[int | str]](list)  # node → nodes, and names of copies, in it
        self._nodes_by_name = defaultdict[str, list[int]](list)
        self._nodes, self._open, self._largest = 0, [0], 0
        self._text: list[str] | None = None  # of the element that is open, where it has to be numbers

    def data(self, text: str) -> None:
        """Text in an element."""
        if self._text is not None:
            self._text.append(text)

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        super().start(tag, attributes)
        name = tag.rpartition("}")[2]
        if name in ("node", "visual_scene"):
            self._nodes += 1
            self._contents[self._open[-1]].append(self._nodes)
            self._open.append(self._nodes)
            for called in {attributes.get(key) for key in ("id", "name", "sid")}:
                if called:
                    self._nodes_by_name[called].append(self._nodes)
        elif name in _INSTANCE_TAGS:
            self._contents[self._open[-1]].append(attributes.get("url", "").lstrip("#"))
        if name == "unit" and "meter" in attributes:
            self._check_unit(attributes["meter"])
        for key in ("count", "offset", "stride"):
            if key in attributes:
                self._check_numbers(attributes[key].split(), whole=True)
                self._largest = max(self._largest, int(attributes[key][:20] or 0))
        self._text = [] if name in _INTEGER_TAGS or name in _REAL_TAGS else None

    def end(self, tag: str) -> None:
        super().end(tag)
        name = tag.rpartition("}")[2]
        if name in ("node", "visual_scene"):
            self._open.pop()
        if self._text is not None:
            self._check_numbers("".join(self._text).split(), name in _INTEGER_TAGS)
            self._text = None

    def _check_unit(self, text: str) -> None:
        try:
            metres = float(text)
        except ValueError:
            metres = math.nan
        if not _UNIT_RANGE[0] <= metres <= _UNIT_RANGE[1]:
            expected = f'a Collada file with a unit of {_UNIT_RANGE[0]:g} to {_UNIT_RANGE[1]:g} m in <unit meter="…">'
            raise self.make_error(expected, f"with {text[:40]!r}")

    def _check_numbers(self, words: list[str], whole: bool) -> None:
        """Raises the file's error for what is no number: assimp never comes past it."""
        try:
            if whole and not all(map(str.isdecimal, words)):
                words = [word if word.removeprefix("-").isdecimal() else f"{word}?" for word in words]
            deque(map(float, words), maxlen=0)
        except ValueError as failure:
            raise self.make_error("a Collada file of numbers", f"({str(failure)[:80]})") from None

    def check(self, size: int) -> None:
        """Raises the file's error where nodes are copied into each other without end, or too often."""
        if self._largest > size:
            raise self.make_error("a Collada file", f"with a count of {self._largest} in {size} bytes")
        total = dict[int, int]()  # node → how many stand in it, 0 while they are counted
        path = [(0, self._inner_nodes(0))]  # from the top to the node that is looked into, with what is left of each
        while path:
            node, left = path[-1]
            total.setdefault(node, 0)
            for inner in left:
                if inner not in total:
                    path.append((inner, self._inner_nodes(inner)))
                    break
                if inner in [above for above, _ in path]:
                    raise self.make_error("a Collada file", "whose nodes stand in each other")
            else:
                total[node] = 1 + len(self._contents[node]) + sum(total[n] for n in self._inner_nodes(node))
                if total[node] > _MAX_NODE_COPIES:
                    expected = f"a Collada file of at most {_MAX_NODE_COPIES} nodes, copies counted"
                    raise self.make_error(expected, "with more")
                path.pop()

    def _inner_nodes(self, node: int) -> Iterator[int]:
        """The nodes that stand in one, copies by name among them."""
        for one in self._contents[node]:
            yield from self._nodes_by_name.get(one, ()) if isinstance(one, str) else (one,)


# ----------------------------------------------------------------
# Whether a PLY file is what its header says. assimp takes its numbers at their word, and reads beyond its memory.

_NUMBER_TYPES = dict.fromkeys(("char", "int8"), "i1") | dict.fromkeys(("uchar", "uint8"), "u1")
_NUMBER_TYPES |= dict.fromkeys(("short", "int16"), "i2") | dict.fromkeys(("ushort", "uint16"), "u2")
_NUMBER_TYPES |= dict.fromkeys(("int", "int32"), "i4") | dict.fromkeys(("uint", "uint32"), "u4")
_NUMBER_TYPES |= dict.fromkeys(("float", "float32"), "f4") | dict.fromkeys(("double", "float64"), "f8")
_INDEX_NAMES = ("vertex_indices", "vertex_index")
_BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_MAX_FACE_CORNERS = 1000  # of a face


@dataclass
class _PlyElement:
    """One element of the header of a PLY file, such as vertex, 4. properties : name, type of the numbers, type of how
    many of a list, or "".
    """

    name: str
    count: int
    properties: list[tuple[str, str, str]] = field(default_factory=list)

    @property
    def has_lists(self) -> bool:
        """Whether some property is a list."""
        return any(lists for _, _, lists in self.properties)


def _check_ply(data: bytes) -> None:
    """Raises an error where not all that the header lists is there, with numbers where it says numbers, and corners of
    faces that are there.
    """
    head, mark, _ = data.partition(b"end_header")
    start = data.index(b"\n", len(head) + len(mark)) + 1
    if data[len(head) + len(mark) : start].strip():
        raise ValueError("end_header")
    order, elements = _read_ply_header(head.decode("ascii"))
    vertices = next((element for element in elements if element.name == "vertex"), None)
    if vertices is None or not {"x", "y", "z"} <= {name for name, _, _ in vertices.properties}:
        raise ValueError("vertices")
    if vertices.has_lists:
        raise ValueError("lists of vertices")
    if order:
        _check_ply_binary(data[start:], order, elements, vertices.count)
    else:
        _check_ply_text(data[start:].decode("ascii"), elements, vertices.count)


def _read_ply_header(text: str) -> tuple[str, list[_PlyElement]]:
    """The byte order, "" of text, and the elements. Raises ValueError."""
    first, second, *lines = text.replace("\r\n", "\n").removesuffix("\n").split("\n")
    kind = second.split()
    if first != "ply" or len(kind) != 3 or kind[0] != "format" or kind[2] != "1.0":
        raise ValueError("header")
    elements = list[_PlyElement]()
    for line in lines:
        match line.split():
            case ["comment" | "obj_info", *_]:
                continue
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append(_PlyElement(name, int(count)))
            case ["property", "list", lists, kind_of, name]:
                elements[-1].properties.append((name, _NUMBER_TYPES[kind_of], _NUMBER_TYPES[lists]))
            case ["property", kind_of, name]:
                elements[-1].properties.append((name, _NUMBER_TYPES[kind_of], ""))
            case _:
                raise ValueError(line)
    return _BYTE_ORDERS[kind[1]], elements


def _check_ply_text(body: str, elements: Sequence[_PlyElement], vertices: int) -> None:
    """One line for each of an element."""
    lines = body.replace("\r\n", "\n").rstrip("\n ").split("\n")
    if len(lines) != sum(element.count for element in elements):
        raise ValueError("lines")
    left = iter(lines)
    for element in elements:
        for line in islice(left, element.count):
            words = [word for word in line.split(" ") if word]
            k = 0
            for name, _, lists in element.properties:
                count = _check_count(int(words[k])) if lists else 1
                k += bool(lists)
                own = words[k : k + count]
                k += count
                if name in _INDEX_NAMES:
                    _check_corners([int(word) for word in own], vertices)
                elif not all(isfinite(float(word)) for word in own):
                    raise ValueError("not finite")
            if k != len(words):
                raise ValueError(line)


def _check_ply_binary(body: bytes, order: str, elements: Sequence[_PlyElement], vertices: int) -> None:
    at = 0
    for element in elements:
        if not element.has_lists:
            at += element.count * sum(np.dtype(kind).itemsize for _, kind, _ in element.properties)
            continue
        for _ in range(element.count):
            if at >= len(body):
                raise ValueError("too short")
            for name, kind, lists in element.properties:
                count = 1
                if lists:
                    count = _check_count(int(np.frombuffer(body, order + lists, 1, at)[0]))
                    at += np.dtype(lists).itemsize
                if name in _INDEX_NAMES:
                    _check_corners([int(n) for n in np.frombuffer(body, order + kind, count, at)], vertices)
                at += count * np.dtype(kind).itemsize
    if at != len(body):
        raise ValueError("length")


def _check_count(count: int) -> int:
    """How many a list has."""
    if not 0 <= count <= _MAX_FACE_CORNERS:
        raise ValueError("a list")
    return count


def _check_corners(numbers: list[int], vertices: int) -> None:
    if numbers and not (min(numbers) >= 0 and max(numbers) < vertices):
        raise ValueError("a corner that is not there")
