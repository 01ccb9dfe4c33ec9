"""Names in a scene file: its keys in errors, its fingers in tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from handlcp.errors import InputError, UnknownName


def known(key: str, names: Any, valid: Sequence[str]) -> None:
    """Raises UnknownName for names that are not among the valid ones."""
    if unknown := [n for n in names if n not in valid]:
        raise UnknownName(key, "a joint" if key == "posture.q_rad" else "a finger", unknown, valid)


@contextmanager
def keyed(keys: dict[str, str], prefix: str = "") -> Iterator[None]:
    """Name the scene file's key in an InputError instead of the argument that it became; the error's type stays."""
    try:
        yield
    except InputError as error:
        head, dot, rest = error.argument.partition("[")
        named = keys.get(head, prefix + head) + dot + rest
        for listed, key in keys.items():  # such as "effects[1]", whose number no file knows
            if "[" in listed and error.argument.startswith(listed):
                named = key + error.argument[len(listed) :]
        if named != error.argument:
            error.argument, error.args = named, (f"{named}{str(error)[len(error.argument) :]}",)
        raise
