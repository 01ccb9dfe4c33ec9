"""What pydantic has to say about a scene file, said in the package's own words: key path, expected, came."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence
from typing import Any

from pydantic import ValidationError

from handlcp.errors import InputError, SceneFileError
from handlcp.scene.keys import Key, keys
from handlcp.scene.kinds import SHAPES


class SceneFileErrors(SceneFileError):
    """Several at once: `each` of them, the first one's argument, expected and got, and a message that lists all."""

    def __init__(self, label: str, each: Sequence[SceneFileError]) -> None:
        self.each = tuple(each)
        first = each[0]
        super().__init__(first.argument, first.expected, first.got)
        self.args = ("\n  ".join([f"{label}: {len(each)} errors", *(str(e) for e in each)]),)


def refused(label: str, error: ValidationError) -> SceneFileError:
    """One error to raise for all that does not follow the schema, with the file's name in front."""
    found = list(_each(error, ()))
    if len(found) > 1:
        return SceneFileErrors(label, found)
    found[0].args = (f"{label}: {found[0]}",)
    return found[0]


def _each(error: ValidationError, above: tuple[Any, ...]) -> Iterator[SceneFileError]:
    """One for each thing that is wrong; above : path of the table that was being read."""
    for e in error.errors():
        told: dict[str, Any] = {**e, "loc": (*above, *e["loc"])}
        inner = e.get("ctx", {}).get("error")
        if isinstance(inner, ValidationError):  # of a table made when it is read
            yield from _each(inner, told["loc"])
        else:
            yield _one(told)


def _one(e: dict[str, Any]) -> SceneFileError:
    loc, shape = e["loc"], ""
    if len(loc) > 1 and loc[0] == "object" and loc[1] in SHAPES:  # pydantic takes the shape for a table
        loc, shape = ("object", *loc[2:]), loc[1]
    path, kind, came = _path(loc), e["type"], e.get("input")
    if kind == "extra_forbidden":
        return _unknown(loc, shape)
    if kind == "missing":
        return SceneFileError(path, _words(loc, shape), "nothing: the key is missing")
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        given = came.get("shape") if isinstance(came, dict) else None
        return SceneFileError(f"{path}.shape", "one of " + ", ".join(SHAPES), _show(given))
    if kind == "value_error" and isinstance(inner := e["ctx"]["error"], InputError):
        return SceneFileError(".".join(p for p in (path, inner.argument) if p), inner.expected, inner.got)
    if kind == "expected":
        return SceneFileError(path, e["ctx"]["words"], _show(came))
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return SceneFileError(path, f"a table [{_table(loc)}]", _show(came))
    if kind == "list_type":
        return SceneFileError(path, f"tables [[{_table(loc)}]]", _show(came))
    if kind == "literal_error":
        return SceneFileError(path, str(e["ctx"]["expected"]), _show(came))
    return SceneFileError(path, str(e["msg"]), _show(came))


def _unknown(loc: tuple[Any, ...], shape: str) -> SceneFileError:
    """An unknown key: the valid ones, the nearest of them, or the table where it belongs."""
    table, key, every = _table(loc[:-1]), str(loc[-1]), keys()
    valid = list(dict.fromkeys(_names(every, table, shape)))
    hint = ""
    if near := difflib.get_close_matches(key.lower(), [v.lower() for v in valid], 1, 0.6):
        hint = f"; did you mean {next(v for v in valid if v.lower() == near[0])!r}?"
    elif homes := list(dict.fromkeys(k.table for k in every if k.key == key and k.table != table)):
        hint = "; it belongs to " + " or ".join(f"[{h}]" if h else "the top of the file" for h in homes)
    elif any(k.key == key for k in every if k.table == table):
        others = ", ".join(k.shape for k in every if k.table == table and k.key == key)
        hint = f"; it goes with shape {others}"
    return SceneFileError(_path(loc), "one of the keys [" + ", ".join(valid) + "]", f"the unknown key {key!r}{hint}")


def _names(every: tuple[Key, ...], table: str, shape: str) -> list[str]:
    own = [k.key for k in every if k.table == table and k.shape in ("", shape)]
    start = f"{table}." if table else ""
    return own + [k.table[len(start) :].split(".")[0] for k in every if k.table != table and k.table.startswith(start)]


def _words(loc: tuple[Any, ...], shape: str) -> str:
    """What the schema expects at a path."""
    table, key = _table(loc[:-1]), loc[-1]
    found = [k for k in keys() if k.table == table and k.key == key and k.shape in ("", shape)]
    return f"{found[0].expected} ({found[0].meaning})" if found else f"a table [{_table(loc)}]"


def _table(loc: tuple[Any, ...]) -> str:
    return ".".join(str(part) for part in loc if not isinstance(part, int))


def _path(loc: tuple[Any, ...]) -> str:
    out = ""
    for part in loc:
        out += f"[{part}]" if isinstance(part, int) else f".{part}" if out else str(part)
    return out


def _show(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
