"""What the tables of a scene file are made of, for pydantic: refusals in words, and tables known only when read."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pydantic import BaseModel, ConfigDict, PlainValidator, ValidationError, WrapValidator
from pydantic_core import PydanticCustomError


class Table(BaseModel):
    """A table of a scene file: no keys but its own, no conversions but integers to numbers."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Expected(WrapValidator):
    """Any refusal inside becomes one: `words`."""

    words: str

    def __init__(self, words: str) -> None:
        def check(value: Any, inner: Any) -> Any:
            try:
                return inner(value)
            except ValidationError:
                raise PydanticCustomError("expected", "{words}", {"words": words}) from None

        super().__init__(check)
        object.__setattr__(self, "words", words)


class MadeWhenRead(PlainValidator):
    """A table whose keys depend on what is imported by the time a file is read. model : returns it."""

    model: Callable[[], type[Table]]

    def __init__(self, model: Callable[[], type[Table]]) -> None:
        def check(value: Any) -> Table:
            return model().model_validate(value)

        super().__init__(check)
        object.__setattr__(self, "model", model)
