"""Every key of a scene file, with what it holds and what it means: read off the schema, so that it cannot go stale."""

from __future__ import annotations

import ast
import inspect
import itertools
import sys
import textwrap
import typing
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from pydantic import BaseModel

from handlcp.scene.kinds import SHAPES, Expected, MadeWhenRead, Table
from handlcp.scene.scene_tables import SceneTables


@dataclass(frozen=True, slots=True)
class Key:
    """table : "" at the top, "hand", "object", "contact", "effects.prescribed_force", …; key : its name.

    expected : what it holds, in words. meaning : what it says. required : whether the table needs it.
    default : what it is when left out, as TOML; "" where the meaning tells.
    shape : the object shape that has it, or "". many : whether there may be several of its table.
    """

    table: str
    key: str
    expected: str
    meaning: str
    required: bool
    default: str
    shape: str = ""
    many: bool = False

    @property
    def path(self) -> str:
        """Such as "object.radius_m"."""
        return f"{self.table}.{self.key}" if self.table else self.key


def keys() -> tuple[Key, ...]:
    """All keys, in the order of the schema."""
    found = list(_walk("", SceneTables))
    shapes = {k.shape for k in found if k.shape}
    alike = Counter(replace(k, shape="") for k in found)
    common = [replace(k, shape="") if alike[replace(k, shape="")] == len(shapes) else k for k in found]
    return tuple(dict.fromkeys(common))


def _walk(table: str, model: type[BaseModel], shape: str = "", many: bool = False) -> Iterator[Key]:
    for field_name, field in model.model_fields.items():
        name = field.alias or field_name
        later = [m.model() for m in field.metadata if isinstance(m, MadeWhenRead)]
        inner = later or _models(field.annotation)
        if not inner:
            default = "" if field.is_required() else _toml(field.get_default(call_default_factory=True))
            words = next((m.words for m in field.metadata if isinstance(m, Expected)), None)
            words = words or _words(field.annotation)
            meaning = (field.description or _docstrings(model).get(field_name, "")).strip()
            yield Key(table, name, words, meaning, field.is_required(), default, shape, many)
        for m in inner:
            several = typing.get_origin(field.annotation) is list
            yield from _walk(f"{table}.{name}" if table else name, m, _shape(m), several)


@cache
def _docstrings(model: type[BaseModel]) -> dict[str, str]:
    """The strings below a table's fields. pydantic would look for them at every import, a tenth of a second."""
    found: dict[str, str] = {}
    for kind in reversed(model.__mro__):
        written = getattr(sys.modules[kind.__module__], kind.__name__, None) is kind  # others are made when read
        if issubclass(kind, Table) and written:
            body = ast.parse(textwrap.dedent(inspect.getsource(kind))).body[0]
            assert isinstance(body, ast.ClassDef)
            for field, text in itertools.pairwise(body.body):
                match field, text:
                    case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(words))):
                        found[name] = inspect.cleandoc(words)
    return found


def _models(annotation: Any) -> list[type[BaseModel]]:
    """The tables among the members of a type."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [m for a in typing.get_args(annotation) for m in _models(a)]


def _shape(model: type[BaseModel]) -> str:
    """Which object shape this table is for."""
    field = model.model_fields.get("shape")
    return "" if field is None else str(typing.get_args(field.annotation)[0])


def _words(annotation: Any) -> str:
    """What the type expects, in words; the only one without words of its own is an object's shape."""
    for a in typing.get_args(annotation):
        for m in getattr(a, "__metadata__", ()):
            if isinstance(m, Expected):
                return m.words
    return "one of " + ", ".join(SHAPES)


def _toml(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else f"{value}"
