"""Reading a file of tables: TOML in, checked tables out, or one error that lists everything wrong with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from handlcp.errors import InputError, SceneFileError, as_path
from handlcp.read_file import MOST_TOML, parse_toml, read_text
from handlcp.scene.keys import refused
from handlcp.scene.kinds import Table

Tables = TypeVar("Tables", bound=Table)


def text_of(path: Any, kind: str) -> tuple[str, Path]:
    """The text of a file, and its path. Raises InputError, SceneFileError.

    kind : of file, such as "a scene file".
    """
    wanted = f"the path of {kind}"
    file = as_path("path", path, wanted)
    if path == "":
        raise SceneFileError("path", wanted, "'', which is empty")
    return read_text("path", file, kind, MOST_TOML, SceneFileError), file


def checked(model: type[Tables], text: Any, label: str) -> Tables:
    """The tables that a text describes. Raises InputError, SceneFileError, which starts with `label`."""
    if not isinstance(text, str):
        raise InputError("text", "a string of TOML", type(text).__name__)
    try:
        return model.model_validate(parse_toml(label, text, SceneFileError))
    except ValidationError as error:
        raise refused(label, error, model) from None
