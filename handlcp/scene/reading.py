"""Reading a file of tables: TOML in, checked tables out, or one error that lists everything wrong with it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from handlcp.errors import InputError, SceneFileError, as_path, unreadable
from handlcp.scene.keys import refused
from handlcp.scene.kinds import Table

_DEEPEST = 32  # what a scene file needs is six: a matrix in a law in a table by finger
_NESTED = f"at most {_DEEPEST} arrays or tables in each other"

Tables = TypeVar("Tables", bound=Table)


def text_of(path: Any, kind: str) -> tuple[str, Path]:
    """What a file holds, and where it is. kind : of file, such as "a scene file". Raises InputError, SceneFileError."""
    wanted = f"the path of {kind}"
    file = as_path("path", path, wanted)
    if path == "":
        raise SceneFileError("path", wanted, "'', which is empty")
    if why := unreadable(file):
        raise SceneFileError("path", wanted, f"{str(file)!r}, which {why}")
    try:
        return file.read_bytes().decode("utf-8-sig"), file  # some editors write a mark before the text
    except (OSError, UnicodeDecodeError) as error:
        raise SceneFileError("path", f"{kind} in UTF-8", f"{str(file)!r}: {error}") from None


def checked(model: type[Tables], text: Any, label: str) -> Tables:
    """The tables that a text describes. Raises InputError, SceneFileError, which starts with `label`."""
    if not isinstance(text, str):
        raise InputError("text", "a string of TOML", type(text).__name__)
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneFileError(label, "TOML", str(error)) from None
    except ValueError:  # Python reads no longer integers
        raise SceneFileError(label, "integers of 64 bits", "one of more than 4300 digits") from None
    except RecursionError:
        raise SceneFileError(label, _NESTED, "more") from None
    _check(raw, label)
    try:
        return model.model_validate(raw)
    except ValidationError as error:
        raise refused(label, error, model) from None


def _check(raw: Any, label: str) -> None:
    """Raises SceneFileError for what is nested too deeply to be read, and integers that TOML does not have."""
    level, depth = [raw], 0
    while level:
        if depth > _DEEPEST:
            raise SceneFileError(label, _NESTED, "more")
        if any(isinstance(value, int) and not -(2**63) <= value < 2**63 for value in level):
            raise SceneFileError(label, "integers of 64 bits", "a larger one")
        level, depth = [inner for value in level for inner in _within(value)], depth + 1


def _within(value: Any) -> Iterable[Any]:
    """What an array or a table holds."""
    return value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
