"""`keys`: every key of a file, read off its schema, so that it cannot go stale; and refusals that name these keys."""

from __future__ import annotations

import ast
import difflib
import inspect
import itertools
import sys
import textwrap
import typing
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from handlcp.errors import InputError, SceneFileError, as_path, shorten_repr
from handlcp.read_file import MAX_TOML_BYTES, parse_toml, read_text
from handlcp.scene.key_types import SHAPES, Checked, DeferredTable, ExpectedWords, FileTable, argument_of
from handlcp.scene.scene_tables import SceneTables

_MAX_ERRORS = 100  # of one file that are listed
_NAMED_TABLES_EXPECTED = "a table by name of tables"  # whose keys are those of the table that is called as one of them


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a scene file or a brief.

    table : that it is in: "" at the top, "hand", "object", "contact", "effects.prescribed_force", …
    key : its name.
    expected : what it holds, in words. meaning : what it says.
    required : whether the table needs it.
    default : what it is when left out, as TOML; "" where the meaning tells.
    shape : the object shape that has it, or "".
    many : whether there may be several of its table.
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
        """The key with its table, such as "object.radius_m"."""
        return f"{self.table}.{self.key}" if self.table else self.key


def keys(model: type[FileTable] = SceneTables) -> tuple[Key, ...]:
    """All keys of a file, in the order of its schema."""
    found = list(_walk_keys("", model))
    shapes = {k.shape for k in found if k.shape}
    alike = Counter(replace(k, shape="") for k in found)
    common = [replace(k, shape="") if alike[replace(k, shape="")] == len(shapes) else k for k in found]
    return tuple(dict.fromkeys(common))


def _walk_keys(table: str, model: type[BaseModel], shape: str = "", many: bool = False) -> Iterator[Key]:
    for field_name, field in model.model_fields.items():
        name = field.alias or field_name
        later = [m.model() for m in field.metadata if isinstance(m, DeferredTable)]
        named = _has_named_tables(field.annotation)
        inner = later or ([] if named else _inner_tables(field.annotation))
        if not inner:
            default = "" if field.is_required() else _format_toml(field.get_default(call_default_factory=True))
            words = next((m.words for m in field.metadata if isinstance(m, (Checked, ExpectedWords))), None)
            words = words or (_NAMED_TABLES_EXPECTED if named else _expected_words(field.annotation))
            meaning = (field.description or _field_docstrings(model).get(field_name, "")).strip()
            yield Key(table, name, words, meaning, field.is_required(), default, shape, many)
        for m in inner:
            several = typing.get_origin(field.annotation) is list
            yield from _walk_keys(f"{table}.{name}" if table else name, m, _table_shape(m), several)


@cache
def _field_docstrings(model: type[BaseModel]) -> dict[str, str]:
    """The strings below a table's fields. pydantic would look for them at every import, a tenth of a second."""
    found: dict[str, str] = {}
    for kind in reversed(model.__mro__):
        written = getattr(sys.modules[kind.__module__], kind.__name__, None) is kind  # others are made when read
        if issubclass(kind, FileTable) and written:
            body = ast.parse(textwrap.dedent(inspect.getsource(kind))).body[0]
            assert isinstance(body, ast.ClassDef)
            for field, text in itertools.pairwise(body.body):
                match field, text:
                    case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(words))):
                        found[name] = inspect.cleandoc(words)
    return found


def _inner_tables(annotation: Any) -> list[type[BaseModel]]:
    """The tables among the members of a type."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [m for a in typing.get_args(annotation) for m in _inner_tables(a)]


def _has_named_tables(annotation: Any) -> bool:
    """Whether the type is tables by names that a user chooses, whose keys stand elsewhere."""
    return any(typing.get_origin(a) is dict and _inner_tables(a) for a in (annotation, *typing.get_args(annotation)))


def _table_shape(model: type[BaseModel]) -> str:
    """Which object shape this table is for."""
    field = model.model_fields.get("shape")
    return "" if field is None else str(typing.get_args(field.annotation)[0])


def _expected_words(annotation: Any) -> str:
    """What the type expects, in words; the only one without words of its own is an object's shape."""
    for a in typing.get_args(annotation):
        for m in getattr(a, "__metadata__", ()):
            if isinstance(m, (Checked, ExpectedWords)):
                return m.words
    return "one of " + ", ".join(SHAPES)


def _format_toml(value: Any) -> str:
    if value is None or value == {}:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else f"{value}"


# ----------------------------------------------------------------
# What pydantic has to say about a scene file, said in the package's own words: key path, expected, came.


class SceneFileErrors(SceneFileError):
    """Several errors of one scene file, raised together.

    each : of them. argument, expected, got : those of the first. The message lists all.
    """

    def __init__(self, label: str, each: Sequence[SceneFileError]) -> None:
        self.each = tuple(each)
        first = each[0]
        super().__init__(first.argument, first.expected, first.got)
        more = "more than " if len(each) > _MAX_ERRORS else ""
        told = [str(e) for e in each[:_MAX_ERRORS]]
        self.args = ("\n  ".join([f"{label}: {more}{len(told)} errors", *told]),)


def schema_error(label: str, error: ValidationError, model: type[FileTable]) -> SceneFileError:
    """One error to raise for all that does not follow the schema `model`, with the file's name in front."""
    found = list(itertools.islice(_validation_errors(error, (), keys(model)), _MAX_ERRORS + 1))
    if len(found) > 1:
        return SceneFileErrors(label, found)
    found[0].args = (f"{label}: {found[0]}",)
    return found[0]


def _validation_errors(
    error: ValidationError, above: tuple[Any, ...], every: tuple[Key, ...]
) -> Iterator[SceneFileError]:
    """An error for each thing that pydantic found wrong.

    above : path of the table that was being read.
    every : keys that there are.
    """
    for e in error.errors():
        told: dict[str, Any] = {**e, "loc": (*above, *e["loc"])}
        inner = e.get("ctx", {}).get("error")
        if isinstance(inner, ValidationError):  # of a table made when it is read
            yield from _validation_errors(inner, told["loc"], every)
        else:
            yield _validation_error(told, every)


def _validation_error(e: dict[str, Any], every: tuple[Key, ...]) -> SceneFileError:
    loc, shape = e["loc"], ""
    at = {"object": 1, "objects": 2}.get(loc[0] if loc else "", 0)
    if 0 < at < len(loc) and loc[at] in SHAPES:  # pydantic takes the shape for a table
        loc, shape = (*loc[:at], *loc[at + 1 :]), loc[at]
    path, kind, came = _key_path(loc), e["type"], e.get("input")
    if kind == "extra_forbidden":
        return _unknown_key_error(loc, shape, every)
    if kind == "missing":
        return SceneFileError(path, _expected_at(loc, shape, every), "nothing: the key is missing")
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        given = came.get("shape") if isinstance(came, dict) else None
        return SceneFileError(f"{path}.shape", "one of " + ", ".join(SHAPES), shorten_repr(given))
    if kind == "value_error" and isinstance(inner := e["ctx"]["error"], InputError):
        head, bracket, rest = inner.argument.partition("[")
        if loc and head == argument_of(str(loc[-1])):  # of the value itself, or of one of its entries
            return SceneFileError(f"{path}{bracket}{rest}", inner.expected, inner.got)
        return SceneFileError(".".join(part for part in (path, inner.argument) if part), inner.expected, inner.got)
    if kind == "expected":
        return SceneFileError(path, e["ctx"]["words"], shorten_repr(came))
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return SceneFileError(path, f"a table [{_table_path(loc)}]", shorten_repr(came))
    if kind == "list_type":
        return SceneFileError(path, f"tables [[{_table_path(loc)}]]", shorten_repr(came))
    if kind == "literal_error":
        return SceneFileError(path, str(e["ctx"]["expected"]), shorten_repr(came))
    return SceneFileError(path, str(e["msg"]), shorten_repr(came))


def _unknown_key_error(loc: tuple[Any, ...], shape: str, every: tuple[Key, ...]) -> SceneFileError:
    """The error of an unknown key names the valid ones, and the nearest of them or the table where it belongs."""
    table, key = _schema_table(loc[:-1], every), str(loc[-1])
    valid = list(dict.fromkeys(_valid_names(every, table, shape)))
    hint = ""
    if near := difflib.get_close_matches(key.lower(), [v.lower() for v in valid], 1, 0.6):
        hint = f"; did you mean {next(v for v in valid if v.lower() == near[0])!r}?"
    elif homes := list(dict.fromkeys(k.table for k in every if k.key == key and k.table != table)):
        hint = "; it belongs to " + " or ".join(f"[{h}]" if h else "the top of the file" for h in homes)
    elif any(k.key == key for k in every if k.table == table):
        others = ", ".join(k.shape for k in every if k.table == table and k.key == key)
        hint = f"; it goes with shape {others}"
    return SceneFileError(
        _key_path(loc), "one of the keys [" + ", ".join(valid) + "]", f"the unknown key {key!r}{hint}"
    )


def _valid_names(every: tuple[Key, ...], table: str, shape: str) -> list[str]:
    own = [k.key for k in every if k.table == table and k.shape in ("", shape)]
    start = f"{table}." if table else ""
    return own + [k.table[len(start) :].split(".")[0] for k in every if k.table != table and k.table.startswith(start)]


def _expected_at(loc: tuple[Any, ...], shape: str, every: tuple[Key, ...]) -> str:
    """What the schema expects at a path."""
    table, key = _schema_table(loc[:-1], every), loc[-1]
    found = [k for k in every if k.table == table and k.key == key and k.shape in ("", shape)]
    return f"{found[0].expected} ({found[0].meaning})" if found else f"a table [{_table_path(loc)}]"


def _schema_table(loc: tuple[Any, ...], every: tuple[Key, ...]) -> str:
    """The table whose keys are those of a table by a name of the user's: [hand.motor] for [hand.motors.NAME]."""
    above = _table_path(loc[:-1])
    return (
        above.removesuffix("s")
        if any(k.path == above and k.expected == _NAMED_TABLES_EXPECTED for k in every)
        else _table_path(loc)
    )


def _table_path(loc: tuple[Any, ...]) -> str:
    return ".".join(str(part) for part in loc if not isinstance(part, int))


def _key_path(loc: tuple[Any, ...]) -> str:
    out = ""
    for part in loc:
        out += f"[{part}]" if isinstance(part, int) else f".{part}" if out else str(part)
    return out


# ----------------------------------------------------------------
# Reading a file of tables: TOML in, checked tables out, or one error that lists everything wrong with it.


TableT = TypeVar("TableT", bound=FileTable)


def read_text_file(path: Any, kind: str) -> tuple[str, Path]:
    """The text of a file, and its path. Raises InputError, SceneFileError.

    kind : of file, such as "a scene file".
    """
    wanted = f"the path of {kind}"
    file = as_path("path", path, wanted)
    if path == "":
        raise SceneFileError("path", wanted, "'', which is empty")
    return read_text("path", file, kind, MAX_TOML_BYTES, SceneFileError), file


def read_tables(model: type[TableT], text: Any, label: str) -> TableT:
    """The tables that a text describes. Raises InputError, SceneFileError, which starts with `label`."""
    if not isinstance(text, str):
        raise InputError("text", "a string of TOML", type(text).__name__)
    try:
        return model.model_validate(parse_toml(label, text, SceneFileError))
    except ValidationError as error:
        raise schema_error(label, error, model) from None
