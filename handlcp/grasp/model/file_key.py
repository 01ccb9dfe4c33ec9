"""What asks for an effect in a scene file: a key of [effects], what it holds, and what it means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from annotated_types import Ge, Gt, Len, Predicate

from handlcp.errors import InputError, UnknownName

Finite = Annotated[float, Predicate(math.isfinite)]
Above0 = Annotated[float, Gt(0)]  # inf is welcome: no bound
From0 = Annotated[float, Ge(0), Predicate(math.isfinite)]
Three = Annotated[list[Finite], Len(3, 3)]


@dataclass(frozen=True, slots=True, eq=False)
class FileKey:
    """name : of the key. holds : its type, in Python's annotations; or the keys of a table. expected : the same in
    words, for refusals. meaning : for `handlcp keys`. many : several tables, one [[effects.name]] each.
    required : whether a table needs it. default : what it is when left out.
    """

    name: str
    holds: Any
    expected: str
    meaning: str
    many: bool = False
    required: bool = False
    default: Any = None

    @property
    def table(self) -> tuple[FileKey, ...]:
        """The keys of a table; none: it holds a value."""
        return self.holds if isinstance(self.holds, tuple) else ()


CONTACT_KEY = FileKey(
    "contact",
    Annotated[int, Ge(0)] | str,
    "a finger's name or a contact's number, counted from 0",
    "which one",
    required=True,
)


def by_finger(key: str, value: Any, fingers: Sequence[str], otherwise: Any) -> Any:
    """A table by finger as a list in the fingers' order, `otherwise` for those left out. Raises UnknownName."""
    if not isinstance(value, dict):
        return value
    if unknown := [name for name in value if name not in fingers]:
        raise UnknownName(key, "a finger", unknown, fingers)
    return [value.get(name, otherwise) for name in fingers]


def contact_number(key: str, value: Any, fingers: Sequence[str]) -> int:
    """Of a contact given by name or by number, counted from 0. Raises UnknownName, InputError."""
    if isinstance(value, str):
        if value not in fingers:
            raise UnknownName(key, "a finger", [value], fingers)
        return list(fingers).index(value)
    if not 0 <= value < len(fingers):
        raise InputError(key, f"a contact's number from 0 to {len(fingers) - 1}", value)
    return int(value)
