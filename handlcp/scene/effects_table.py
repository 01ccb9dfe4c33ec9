"""The [effects] table of a scene file: a key for each effect that has one, as the effect itself describes it."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Any

from pydantic import Field, create_model

from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.model.limit import FileKey
from handlcp.scene.table import Expected, Table


def kinds_with_keys() -> tuple[tuple[type[Effect], FileKey], ...]:
    """The effects that a scene file may ask for, in order, each with its key."""
    return tuple([(kind, kind.file_key) for kind in effect_kinds() if kind.file_key is not None])


def effects_table() -> type[Table]:
    """The table of all effects that there are by now."""
    return _made("EffectsTable", tuple([key for _, key in kinds_with_keys()]))


def asked(table: Table) -> dict[str, Any]:
    """What the file says, by key: values, and tables as mappings of what is written in them."""
    said: dict[str, Any] = table.model_dump(exclude_unset=True)
    return {key: value for key, value in said.items() if value is not False and value is not None and value != []}


@lru_cache(maxsize=64)
def _made(name: str, keys: tuple[FileKey, ...]) -> type[Table]:
    fields: dict[str, Any] = {key.name: _field(key) for key in keys}
    return create_model(name, __base__=Table, **fields)


def _field(key: FileKey) -> tuple[Any, Any]:
    """Type and default of a key."""
    if key.many:
        return list[_made(key.name, key.table)], Field(default_factory=list, description=key.meaning)  # type: ignore[misc]
    held: Any = _made(key.name, key.table) if key.table else Annotated[key.holds, Expected(key.expected)]
    if key.required:
        return held, Field(description=key.meaning)
    return (held | None if key.default is None else held), Field(default=key.default, description=key.meaning)
