"""Whether a PLY file is what its header says. assimp takes its numbers at their word, and reads beyond its memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite

import numpy as np

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_INDICES = ("vertex_indices", "vertex_index")
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_MOST_CORNERS = 1000  # of a face


@dataclass
class _Element:
    """name, count : such as vertex, 4. properties : name, type of the numbers, type of how many of a list, or ""."""

    name: str
    count: int
    properties: list[tuple[str, str, str]] = field(default_factory=list)


def is_ply(data: bytes) -> bool:
    """Whether all that the header lists is there, with numbers where it says numbers, and faces have their corners."""
    try:
        _check(data)
    except (ValueError, KeyError, IndexError, OverflowError):
        return False
    return True


def _check(data: bytes) -> None:
    head, mark, _ = data.partition(b"end_header")
    start = data.index(b"\n", len(head) + len(mark)) + 1
    if data[len(head) + len(mark) : start].strip():
        raise ValueError("end_header")
    order, elements = _header(head.decode("ascii"))
    vertices = next((element for element in elements if element.name == "vertex"), None)
    if vertices is None or not {"x", "y", "z"} <= {name for name, _, _ in vertices.properties}:
        raise ValueError("vertices")
    if any(lists for _, _, lists in vertices.properties):
        raise ValueError("lists of vertices")
    if order:
        _check_binary(data[start:], order, elements, vertices.count)
    else:
        _check_text(data[start:].decode("ascii"), elements, vertices.count)


def _header(text: str) -> tuple[str, list[_Element]]:
    """The byte order, "" of text, and the elements. Raises ValueError."""
    first, second, *lines = text.replace("\r\n", "\n").removesuffix("\n").split("\n")
    kind = second.split()
    if first != "ply" or len(kind) != 3 or kind[0] != "format" or kind[2] != "1.0":
        raise ValueError("header")
    elements = list[_Element]()
    for line in lines:
        match line.split():
            case ["comment" | "obj_info", *_]:
                continue
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append(_Element(name, int(count)))
            case ["property", "list", lists, kind_of, name]:
                elements[-1].properties.append((name, _TYPES[kind_of], _TYPES[lists]))
            case ["property", kind_of, name]:
                elements[-1].properties.append((name, _TYPES[kind_of], ""))
            case _:
                raise ValueError(line)
    return _ORDERS[kind[1]], elements


def _check_text(body: str, elements: Sequence[_Element], vertices: int) -> None:
    """One line for each of an element."""
    lines = body.replace("\r\n", "\n").rstrip("\n ").split("\n")
    if len(lines) != sum(element.count for element in elements):
        raise ValueError("lines")
    at = 0
    for element in elements:
        for line in lines[at : at + element.count]:
            words, k = line.split(" "), 0
            words = [word for word in words if word]
            for name, _, lists in element.properties:
                count = int(words[k]) if lists else 1
                own = words[k + 1 : k + 1 + count] if lists else words[k : k + 1]
                k += count + bool(lists)
                if lists and not 0 <= count <= _MOST_CORNERS:
                    raise ValueError("a list")
                if name in _INDICES:
                    _check_corners([int(word) for word in own], vertices)
                elif not all(isfinite(float(word)) for word in own):
                    raise ValueError("not finite")
            if k != len(words):
                raise ValueError(line)
        at += element.count


def _check_binary(body: bytes, order: str, elements: Sequence[_Element], vertices: int) -> None:
    at = 0
    for element in elements:
        if not any(lists for _, _, lists in element.properties):
            at += element.count * sum(np.dtype(kind).itemsize for _, kind, _ in element.properties)
            continue
        for _ in range(element.count):
            if at >= len(body):
                raise ValueError("too short")
            for name, kind, lists in element.properties:
                count = 1
                if lists:
                    count = int(_numbers(body, order + lists, 1, at)[0])
                    at += np.dtype(lists).itemsize
                    if not 0 <= count <= _MOST_CORNERS:
                        raise ValueError("a list")
                if name in _INDICES:
                    _check_corners(_numbers(body, order + kind, count, at), vertices)
                at += count * np.dtype(kind).itemsize
    if at != len(body):
        raise ValueError("length")


def _numbers(body: bytes, kind: str, count: int, at: int) -> list[int]:
    """Raises ValueError where there are fewer."""
    return [int(number) for number in np.frombuffer(body, kind, count, at)]


def _check_corners(numbers: list[int], vertices: int) -> None:
    if numbers and not (min(numbers) >= 0 and max(numbers) < vertices):
        raise ValueError("a corner that is not there")
