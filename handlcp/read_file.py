"""`read_bytes` and its like: what files of others hold: XML, JSON, YAML, TOML and arrays of numbers.

Every reader of the package takes files through here. A limit is checked before what it limits is built: a few hundred
bytes can describe more than fits into the memory. Nothing that is read is run: no pickle, no constructor, no entity.
"""

from __future__ import annotations

import io
import json
import math
import sys
import tomllib
import warnings
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.errors import InputError, Unsupported, why_unreadable

# Sizes [bytes]. The largest robot of example-robot-data has 0.2 MB of XML, its largest mesh 29 MB.
MAX_XML_BYTES = 5_000_000
MAX_TOML_BYTES = 1_000_000
MAX_YAML_BYTES = 20_000_000
MAX_MESH_BYTES = 64_000_000
MAX_ARRAY_BYTES = 500_000_000  # of .npy and .npz, once more of what is packed in one
MAX_TABLE_BYTES = 500_000_000  # of the table of a sweep, and of all cells together where it is packed
MAX_TABLE_CELLS = 20_000_000  # rows times columns of such a table
# Counts of one file. Those of example-robot-data have up to 7,900 elements of 12 attributes, 14 deep.
MAX_ELEMENTS = 100_000  # of XML and of TOML
MAX_ATTRIBUTES = 100  # of one element of XML
MAX_YAML_NODES = 1_000_000  # of YAML: values, those that an alias stands for counted again
_MAX_EQUALS_SIGNS = 10_000  # of "=" between two "<", also in comments
MAX_XML_DEPTH = 200
MAX_NESTING = 32  # arrays or tables in each other, of TOML and YAML; what a scene file needs is six
_MAX_KEY_DOTS = 64  # in a key of TOML, whose parser takes time with their square

InputErrorClass = type[InputError]


def read_bytes(argument: str, file: Path, what: str, most: int, error: InputErrorClass = InputError) -> bytes:
    """The contents of a file.

    what : kind of file, such as "a scene file".
    most : bytes.

    Raises `error` for a file that is missing, is a folder or a device, cannot be read, or is larger.
    """
    if why := why_unreadable(file):
        raise error(argument, f"the path of {what}", f"{str(file)!r}, which {why}")
    try:
        with file.open("rb") as stream:
            data = stream.read(most + 1)
    except OSError as failure:
        came = f"{str(file)!r}: {failure.strerror or failure}"
        raise error(argument, f"{what} that can be read", came) from None
    if len(data) > most:
        raise error(argument, f"{what} of at most {most / 1e6:g} MB", f"{str(file)!r}, which is larger")
    return data


def read_text(argument: str, file: Path, what: str, most: int, error: InputErrorClass = InputError) -> str:
    """The contents of a file as text in UTF-8, without the mark (BOM) that some editors write before it."""
    try:
        return read_bytes(argument, file, what, most, error).decode("utf-8-sig")
    except UnicodeDecodeError as failure:
        raise error(argument, f"{what} in UTF-8", f"{str(file)!r}: {failure}") from None


# ---------------------------------------------------------------- XML.


class ElementCounter:
    """Counts elements, their attributes and how deep they are while expat reads, and builds nothing.

    Raises `error` as soon as there are too many, and for a DOCTYPE, which can define text that grows without bound.
    """

    def __init__(self, argument: str, shown: str, error: InputErrorClass) -> None:
        self._argument, self._shown, self._error = argument, shown, error
        self.count = self.depth = 0

    def make_error(self, expected: str, came: str) -> InputError:
        """The error to raise, which names this file."""
        return self._error(self._argument, expected, f"{self._shown} {came}")

    def start(self, tag: str, attributes: dict[str, str]) -> Any:
        """Count an element that begins, and its attributes."""
        self.count, self.depth = self.count + 1, self.depth + 1
        if self.count > MAX_ELEMENTS:
            raise self.make_error(f"at most {MAX_ELEMENTS} elements", "with more")
        if len(attributes) > MAX_ATTRIBUTES:
            came = f"with {len(attributes)} in <{tag[:40]}>"
            raise self.make_error(f"at most {MAX_ATTRIBUTES} attributes in an element", came)
        if self.depth > MAX_XML_DEPTH:
            raise self.make_error(f"elements nested at most {MAX_XML_DEPTH} deep", "with deeper ones")

    def end(self, tag: str) -> Any:
        """Leave an element that ends."""
        self.depth -= 1

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        """Refuse a DOCTYPE, which may define entities."""
        raise self.make_error("XML without a DOCTYPE", "with one")


class _TreeBuilder(ElementCounter):
    """Builds the tree of elements while it counts them."""

    def __init__(self, argument: str, shown: str, error: InputErrorClass) -> None:
        super().__init__(argument, shown, error)
        self._builder = ET.TreeBuilder()
        self.data, self.close = self._builder.data, self._builder.close

    def start(self, tag: str, attributes: dict[str, str]) -> Any:
        super().start(tag, attributes)
        return self._builder.start(tag, attributes)

    def end(self, tag: str) -> Any:
        super().end(tag)
        return self._builder.end(tag)


def walk_xml(data: bytes, counter: ElementCounter) -> Any:
    """Reads XML into the counter and returns what its `close` returns. Raises the counter's error, also for what is
    no XML.
    """
    if max(part.count(b"=") for part in data.split(b"<")) > _MAX_EQUALS_SIGNS:  # expat takes seconds for all of them
        raise counter.make_error(f"at most {MAX_ATTRIBUTES} attributes in an element", "with far more")
    parser = ET.XMLParser(target=counter)
    try:
        parser.feed(data)
        return parser.close()
    except ET.ParseError as failure:
        raise counter.make_error("well-formed XML", f"({failure})") from None
    except (ValueError, LookupError) as failure:  # an encoding that does not exist
        if isinstance(failure, InputError):
            raise
        raise counter.make_error("XML that can be read", f"({failure})") from None


def parse_xml(argument: str, data: bytes, shown: str, error: InputErrorClass = InputError) -> ET.Element:
    """The root element of an XML file, read within the limits that stand at the top of this module.

    argument : what the caller calls the file. shown : what to call it in messages.

    Raises `error` for what is no XML, and beyond the limits.
    """
    root: ET.Element = walk_xml(data, _TreeBuilder(argument, shown, error))
    return root


# ---------------------------------------------------------------- JSON, TOML, YAML.


def parse_json(text: str | bytes) -> Any:
    """What a text says. Raises ValueError alone, for whatever it is."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("brackets nested too deeply") from None


def parse_toml(argument: str, text: str, error: InputErrorClass = InputError) -> dict[str, Any]:
    """The tables of a text. Raises `error` for what is no TOML, and beyond the limits of this file."""
    if len(text) > MAX_TOML_BYTES:
        raise error(argument, f"at most {MAX_TOML_BYTES / 1e6:g} MB of TOML", f"{len(text) / 1e6:.3g} MB")
    if _most_dots(text) > _MAX_KEY_DOTS:
        raise error(argument, f"keys of at most {_MAX_KEY_DOTS} dots", "a longer one")
    nested = f"at most {MAX_NESTING} arrays or tables in each other"
    try:
        found = tomllib.loads(text)
    except tomllib.TOMLDecodeError as failure:
        raise error(argument, "TOML", str(failure)) from None
    except ValueError:  # Python reads no longer integers
        raise error(argument, "integers of 64 bits", "one of more than 4300 digits") from None
    except RecursionError:
        raise error(argument, nested, "more") from None
    level, depth, count = [found], 0, 0
    while level:
        count += len(level)
        if depth > MAX_NESTING:
            raise error(argument, nested, "more")
        if count > MAX_ELEMENTS:
            raise error(argument, f"at most {MAX_ELEMENTS} values", "more")
        if any(isinstance(value, int) and not -(2**63) <= value < 2**63 for value in level):
            raise error(argument, "integers of 64 bits", "a larger one")
        level, depth = [inner for value in level for inner in _inner_values(value)], depth + 1
    return found


def _most_dots(text: str) -> int:
    """The most dots between two of the marks that end a key. Runs inside strings count, too: none is as long."""
    marks = str.maketrans(dict.fromkeys(",=[]{}\r", "\n"))
    return max(part.count(".") for part in text.translate(marks).split("\n"))


def _inner_values(value: Any) -> Iterable[Any]:
    """The values that an array or a table holds."""
    return value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()


def parse_yaml(argument: str, text: str, shown: str, error: InputErrorClass = InputError) -> Any:
    """Mappings, lists, numbers and words of a text; dates, truth values and tags are words. Keys are words.

    Raises `error` for what is no YAML, and beyond the limits of this file; Unsupported without PyYAML.
    """
    try:
        import yaml
    except ImportError:
        raise Unsupported("a YAML file needs PyYAML: pip install pyyaml") from None
    built = _YamlBuilder(argument, shown, error)
    try:
        for event in yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
            built.add_event(event)
    except yaml.YAMLError as failure:
        raise error(argument, "a YAML file", f"{shown}: {str(failure).splitlines()[0]}") from None
    return built.documents[0] if built.documents else None


class _YamlBuilder:
    """Builds data from the events of a YAML parser.

    documents : those that are complete so far.
    """

    def __init__(self, argument: str, shown: str, error: InputErrorClass) -> None:
        self._argument, self._shown, self._error = argument, shown, error
        self.documents, self.count = list[Any](), 0
        self._open_containers = list[
            tuple[Any, str | None, int]
        ]()  # containers, their anchors, the count when they began
        self._keys = list[str | None]()  # of each container, the key whose value comes next
        self._anchors = dict[str, tuple[Any, int]]()  # anchor → value, and how much it counts

    def _make_error(self, expected: str, came: str) -> InputError:
        return self._error(self._argument, expected, f"{self._shown}, with {came}")

    def add_event(self, event: Any) -> None:
        """Add what the next event of the parser brings."""
        anchor, kind = getattr(event, "anchor", None), type(event).__name__
        if kind == "ScalarEvent":
            value = event.value if self._expects_key() else _parse_scalar(event)
            self._add_value(value, 1)
            if anchor is not None:
                self._anchors[anchor] = value, 1
        elif kind == "AliasEvent":
            if anchor not in self._anchors:  # such as an alias inside of what it stands for
                raise self._make_error("aliases of what came before", f"*{anchor}")
            self._add_value(*self._anchors[anchor])
        elif kind in ("MappingStartEvent", "SequenceStartEvent"):
            value = {} if kind == "MappingStartEvent" else []
            self._add_value(value, 1)
            self._open_containers.append((value, anchor, self.count))
            self._keys.append(None)
            if len(self._open_containers) > MAX_NESTING:
                raise self._make_error(f"at most {MAX_NESTING} lists or mappings in each other", "more")
        elif kind in ("MappingEndEvent", "SequenceEndEvent"):
            value, anchor, before = self._open_containers.pop()
            self._keys.pop()
            if anchor is not None:
                self._anchors[anchor] = value, self.count - before + 1

    def _expects_key(self) -> bool:
        return bool(self._open_containers) and isinstance(self._open_containers[-1][0], dict) and self._keys[-1] is None

    def _add_value(self, value: Any, size: int) -> None:
        self.count += size
        if self.count > MAX_YAML_NODES:
            raise self._make_error(f"at most {MAX_YAML_NODES} values, those of aliases counted each time", "more")
        if self._expects_key():
            if not isinstance(value, str):
                raise self._make_error("keys that are words", f"a {type(value).__name__}")
            self._keys[-1] = value
        elif not self._open_containers:
            self.documents.append(value)
        elif isinstance(within := self._open_containers[-1][0], dict):
            within[self._keys[-1]], self._keys[-1] = value, None
        else:
            within.append(value)


def _parse_scalar(event: Any) -> float | str:
    """A number where it is written as one, without quotes; else the words."""
    if event.implicit[0]:  # without quotes
        try:
            return float(event.value)
        except ValueError:
            pass
    return str(event.value)


# ---------------------------------------------------------------- Arrays.

_PICKLE_REFUSAL = (
    "a pickle, which can run anything; of a file that you made yourself, np.load(file, allow_pickle=True) reads it"
)


def read_arrays(argument: str, file: Path, what: str, most: int, error: InputErrorClass = InputError) -> dict[str, Any]:
    """The arrays of an .npz file by name; of an .npy file its only one, by "". Numbers, truth values and texts alone.

    most : bytes of the file, and of all arrays together where it is packed. Raises `error` for what is neither, and
    for arrays of objects, which numpy would unpickle.
    """
    data = read_bytes(argument, file, what, most, error)
    try:
        if not zipfile.is_zipfile(io.BytesIO(data)):
            return {"": _parse_array(data)}
        return dict(_unpack_arrays(data, most))
    except Exception as failure:  # zip, its compressions and numpy's header raise what they like
        came = f"{str(file)!r}: {str(failure)[:200] or type(failure).__name__}"
        raise error(argument, what, came) from None


def _unpack_arrays(data: bytes, most: int) -> Iterator[tuple[str, Any]]:
    left = most
    with zipfile.ZipFile(io.BytesIO(data)) as packed:
        for entry in packed.infolist():
            with packed.open(entry) as stream:
                array = stream.read(left + 1)
            left -= len(array)
            if left < 0:
                raise ValueError(f"more than {most / 1e6:g} MB when it is unpacked")
            yield entry.filename.removesuffix(".npy"), _parse_array(array)


def _parse_array(data: bytes) -> Any:
    """The array of an .npy file from its bytes; only the header is parsed. Raises ValueError, and what numpy raises."""
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    headers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    if version not in headers:
        raise ValueError(f"version {version} of the format")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of files that Python 2 wrote
        shape, by_column, dtype = headers[version](stream)
    if dtype.kind not in "biufU" or not dtype.itemsize:
        raise ValueError(_PICKLE_REFUSAL if dtype.hasobject else f"an array of {dtype}, which are no numbers")
    count, held = math.prod(shape), data[stream.tell() :]
    if min(shape, default=0) < 0 or count * dtype.itemsize != len(held):
        raise ValueError(f"{len(held)} bytes for an array of {dtype} of shape {shape}")
    if dtype.kind == "b" and held.strip(b"\0\1"):
        raise ValueError("truth values other than 0 and 1")
    if dtype.kind == "U" and (np.frombuffer(held, dtype.byteorder + "u4") > sys.maxunicode).any():
        raise ValueError("texts of letters that do not exist")
    return np.frombuffer(held, dtype, count).reshape(shape, order="F" if by_column else "C")
