"""Mesh files, looked at before assimp reads them: of which kind, how large, and how much they unfold to."""

from __future__ import annotations

import math
import re
from collections import defaultdict, deque
from collections.abc import Iterator
from pathlib import Path

from handlcp.errors import InputError, unreadable
from handlcp.hand.robot.check_ply import is_ply
from handlcp.read_file import MOST_MESH, ElementCounter, Refusal, read_bytes, walk_xml

FORMATS = (".stl", ".obj", ".dae", ".ply")
KINDS = "an STL, OBJ, DAE or PLY file"
_MOST_COPIES = 10_000  # nodes and geometries of a Collada scene, each counted as often as it stands there: 5 kB each
_MATERIALS = re.compile(rb"^\s*mtllib\s+(.*?)\s*$", re.MULTILINE)
_WHOLE = ("p", "v", "h", "vcount", "int_array")  # elements of Collada whose text is whole numbers
_REAL = ("float_array", "matrix", "rotate", "translate", "scale", "lookat", "skew", "bind_shape_matrix")  # and numbers
_UNITS = 1e-9, 1e3  # metres of one: from nanometres to kilometres
_LISTED = ("instance_node", "instance_geometry", "instance_controller")


def check_mesh_file(argument: str, file: Path, error: Refusal = InputError) -> None:
    """Raises `error` for a file that is missing, too large, of another kind than its ending says, or unfolds to more
    than it seems to hold.
    """
    data = read_bytes(argument, file, "a mesh file", MOST_MESH, error)
    kind, shown = file.suffix.lower(), repr(str(file))
    if kind not in FORMATS:
        raise error(argument, f"{KINDS} (hl.Mesh takes what trimesh has loaded, too)", shown)
    if kind == ".dae":
        scene = _Scene(argument, shown, error)
        walk_xml(data, scene)
        scene.check(len(data))
    elif kind == ".obj":
        for name in _MATERIALS.findall(data):  # assimp would wait for a device
            beside = file.parent / name.decode(errors="replace")
            if why := unreadable(beside):
                if why != "does not exist":
                    raise error(argument, "an OBJ file with files of materials", f"{shown}: {name!r}, which {why}")
            else:
                read_bytes(argument, beside, "a file of materials", MOST_MESH, error)
    elif kind == ".ply" and not is_ply(data):
        raise error(argument, "a PLY file", f"{shown}, which does not hold what its header lists")


class _Scene(ElementCounter):
    """What stands in which node of a Collada file: nodes stand in nodes, and are copied into others by name."""

    def __init__(self, argument: str, shown: str, error: Refusal) -> None:
        super().__init__(argument, shown, error)
        self._within = defaultdict[int, list[int | str]](list)  # node → nodes, and names of copies, in it
        self._called = defaultdict[str, list[int]](list)
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
            self._within[self._open[-1]].append(self._nodes)
            self._open.append(self._nodes)
            for called in {attributes.get(key) for key in ("id", "name", "sid")}:
                if called:
                    self._called[called].append(self._nodes)
        elif name in _LISTED:
            self._within[self._open[-1]].append(attributes.get("url", "").lstrip("#"))
        if name == "unit" and "meter" in attributes:
            self._check_unit(attributes["meter"])
        for key in ("count", "offset", "stride"):
            if key in attributes:
                self._check_numbers(attributes[key].split(), whole=True)
                self._largest = max(self._largest, int(attributes[key][:20] or 0))
        self._text = [] if name in _WHOLE or name in _REAL else None

    def end(self, tag: str) -> None:
        super().end(tag)
        name = tag.rpartition("}")[2]
        if name in ("node", "visual_scene"):
            self._open.pop()
        if self._text is not None:
            self._check_numbers("".join(self._text).split(), name in _WHOLE)
            self._text = None

    def _check_unit(self, text: str) -> None:
        try:
            metres = float(text)
        except ValueError:
            metres = math.nan
        if not _UNITS[0] <= metres <= _UNITS[1]:
            expected = f'a Collada file with a unit of {_UNITS[0]:g} to {_UNITS[1]:g} m in <unit meter="…">'
            raise self.refuse(expected, f"with {text[:40]!r}")

    def _check_numbers(self, words: list[str], whole: bool) -> None:
        """Raises the file's error for what is no number: assimp never comes past it."""
        try:
            if whole and not all(map(str.isdecimal, words)):
                words = [word if word.removeprefix("-").isdecimal() else f"{word}?" for word in words]
            deque(map(float, words), maxlen=0)
        except ValueError as failure:
            raise self.refuse("a Collada file of numbers", f"({str(failure)[:80]})") from None

    def check(self, size: int) -> None:
        """Raises the file's error where nodes are copied into each other without end, or too often."""
        if self._largest > size:
            raise self.refuse("a Collada file", f"with a count of {self._largest} in {size} bytes")
        total = dict[int, int]()  # node → how many stand in it, 0 while they are counted
        path = [(0, self._inner(0))]  # from the top to the node that is looked into, with what is left of each
        while path:
            node, left = path[-1]
            total.setdefault(node, 0)
            for inner in left:
                if inner not in total:
                    path.append((inner, self._inner(inner)))
                    break
                if inner in [above for above, _ in path]:
                    raise self.refuse("a Collada file", "whose nodes stand in each other")
            else:
                total[node] = 1 + len(self._within[node]) + sum(total[n] for n in self._inner(node))
                if total[node] > _MOST_COPIES:
                    raise self.refuse(f"a Collada file of at most {_MOST_COPIES} nodes, copies counted", "with more")
                path.pop()

    def _inner(self, node: int) -> Iterator[int]:
        """The nodes that stand in one, copies by name among them."""
        for one in self._within[node]:
            yield from self._called.get(one, ()) if isinstance(one, str) else (one,)
