"""`load_brief`: a brief as TOML, with the tables of objects, loads and friction that scene files have."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar, cast, get_args

import numpy as np
from pydantic import Field, model_validator

from handlcp.contact.friction import as_law
from handlcp.errors import InputError, translate_arguments
from handlcp.geometry import Mesh, Object
from handlcp.scene import key_types as k
from handlcp.scene.build import OBJECT_KINDS, make_object
from handlcp.scene.key_types import FileTable, argument_of
from handlcp.scene.keys import read_tables, read_text_file
from handlcp.scene.scene_tables import make_law
from handlcp.scene.schema import AnyObjectTable, LoadTable, ObjectTable

BriefT = TypeVar("BriefT")

# ----------------------------------------------------------------


class BriefTables(FileTable):
    """What a hand must do."""

    friction: k.Friction = 0.6
    """of all contacts"""
    orientations: k.Orientations = 6
    """in which directions gravity pulls"""
    acceleration_m_per_s2: k.NotNegative = 0.0
    """of the hand, the worst of six ways beside gravity"""
    motion_m: k.Positive | None = None
    """how far an object may move under its weight or a load; left out: any distance"""
    most_force_N: k.Positive | None = None
    """normal force that an object bears at a contact; left out: any"""
    safety: k.Positive = 1.0
    """how many times the weight, and each load, must be held"""
    kind: k.Kind = "pinch"
    """of grasp"""
    squeeze_m: k.ByTip | None = None
    """how much deeper than touching the joints are commanded to take the tips"""
    grip_force_N: k.ByTip | None = None
    """instead of squeeze_m: normal forces that the commanded joints make on an object that stays where it is"""
    closing_torque_Nm: k.ClosingTorque | None = None
    """with which each joint that bends closes a power grasp"""
    tries: k.Count = 256
    """placements of each object that are tried"""
    seed: k.Seed = 0
    """of the search"""
    objects: dict[str, ObjectTable] = Field(default_factory=dict)
    """by name, such as [objects.ball], with the keys of [object]; where they are does not count"""
    loads: dict[str, LoadTable] = Field(default_factory=dict)
    """by name, such as [loads.pull], with the keys of [load]: beside the weight, in the axes of the hand's base"""
    object: ObjectTable | None = None
    """instead of objects: the only one"""
    load: LoadTable | None = None
    """instead of loads: the only one"""

    @model_validator(mode="after")
    def _check_said_once(self) -> BriefTables:
        """An object, or several by name; and at most one way of saying loads."""
        if (self.object is None) == (not self.objects):
            came = "neither" if self.object is None else "both"
            raise InputError("objects", "tables [objects.NAME], or one [object]", came)
        if self.load is not None and self.loads:
            raise InputError("loads", "tables [loads.NAME], or one [load]", "both")
        return self


def load_brief(path: Any, make: Callable[..., BriefT]) -> BriefT:
    """Read the brief of a TOML file; see `Brief.from_toml`.

    make : what makes a brief of its arguments, such as the class `Brief`.
    """
    text, file = read_text_file(path, "a brief (TOML)")
    table = read_tables(BriefTables, text, file.name)
    try:
        objects: Any = {name: make_object(one, file.parent, f"objects.{name}") for name, one in table.objects.items()}
        loads: Any = {name: [*one.force_N, *one.torque_Nm] for name, one in table.loads.items()}
        if table.object is not None:
            objects = make_object(table.object, file.parent)
        if table.load is not None:
            loads = [*table.load.force_N, *table.load.torque_Nm]
        given = table.arguments("object", "objects", "load", "loads", "friction")
        with translate_arguments(BriefTables.keys_by_argument("")):
            return make(objects, loads, make_law(table.friction, "friction"), **given)
    except InputError as error:
        error.args = (f"{file.name}: {error}",)
        raise


# ----------------------------------------------------------------
# Writing: numbers as Python prints them, which reads back to the same bits.


def brief_to_toml(brief: Any, folder: Path) -> str:
    """A brief as TOML, with files of meshes relative to the folder. Raises InputError for what has no key."""
    said = {"friction": _friction_to_toml(brief.friction)}
    for key, field in BriefTables.model_fields.items():
        value = _to_python(getattr(brief, argument_of(key), None))
        if key not in ("friction", "objects", "loads") and value is not None and value != field.default:
            said[key] = value
    tables = {("objects", name): _object_table(name, obj, folder) for name, obj in brief.objects.items()}
    for name, load in brief.loads.items():
        tables["loads", name] = {"force_N": load[:3].tolist(), "torque_Nm": load[3:].tolist()}
    return "\n".join(
        [*_format_lines(said), *[line for path, table in tables.items() for line in _format_section(path, table)], ""]
    )


def _friction_to_toml(given: Any) -> Any:
    law = as_law(given)
    written = law.to_file()
    if make_law(written) != law:
        raise InputError("friction", "a law that files have keys for", repr(given)[:80])
    return written


def _object_table(name: str, obj: Object, folder: Path) -> dict[str, Any]:
    """The table of an object."""
    kind = next((kind for kind in OBJECT_KINDS if isinstance(obj, kind)), None)
    file = getattr(obj, "path", None)
    if kind is None or (kind is Mesh and not isinstance(file, Path)):
        raise InputError(f"objects[{name!r}]", "a shape that files have, a mesh from a file", repr(obj)[:80])
    fields = OBJECT_KINDS[kind].model_fields
    table: dict[str, Any] = {"shape": get_args(fields["shape"].annotation)[0]}
    for key in fields:
        if key == "file":
            table[key] = _relative_path(cast(Path, file), folder)
        elif key not in AnyObjectTable.model_fields:
            table[key] = _to_python(getattr(obj, argument_of(key)))
    return table | {"mass_kg": obj.mass}


def _relative_path(file: Path, folder: Path) -> str:
    """A path from the folder to the file; the whole of it where they have no root in common."""
    try:
        return Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
    except ValueError:
        return file.resolve().as_posix()


def _format_section(path: tuple[str, ...], table: Mapping[str, Any]) -> list[str]:
    return ["", f"[{'.'.join(_format_key(part) for part in path)}]", *_format_lines(table)]


def _format_lines(table: Mapping[str, Any]) -> Iterator[str]:
    return (f"{_format_key(key)} = {_format_value(value)}" for key, value in table.items())


def _format_value(value: Any) -> str:
    """A value as TOML."""
    match value:
        case str():
            return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
        case dict():
            return f"{{ {', '.join(_format_lines(value))} }}"
        case list() | tuple():
            return f"[{', '.join(map(_format_value, value))}]"
        case _:
            return repr(value)


def _format_key(name: str) -> str:
    return name if name.isascii() and name.replace("-", "_").isidentifier() else _format_value(name)


def _to_python(value: Any) -> Any:
    """Arrays and their numbers as lists and Python's numbers."""
    if isinstance(value, Mapping):
        return {str(key): _to_python(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple, np.ndarray, np.generic)):
        return [_to_python(one) for one in value] if isinstance(value, (list, tuple)) else value.tolist()
    return value
