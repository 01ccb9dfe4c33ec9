"""Keywords that a call does not know, or lacks, with a word on what was meant."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from difflib import get_close_matches
from functools import wraps
from typing import Any, TypeVar, cast

from handlcp.errors import InputError

_F = TypeVar("_F", bound=Callable[..., Any])


def helped(**elsewhere: str) -> Callable[[_F], _F]:
    """Decorates a function, or an `__init__`: TypeError for an unknown keyword says the nearest that it has, or where
    `elsewhere` it belongs.
    """

    def of(function: _F) -> _F:
        known = [p.name for p in inspect.signature(function).parameters.values() if p.name != "self"]
        called_as = function.__qualname__.removesuffix(".__init__").rpartition(".")[2]
        names = frozenset(known)

        @wraps(function)
        def called(*args: Any, **given: Any) -> Any:
            if not given.keys() <= names and (unknown := [name for name in given if name not in names]):
                raise TypeError("; ".join(_word(called_as, name, known, elsewhere) for name in unknown))
            return function(*args, **given)

        return cast(_F, called)

    return of


def needed(name: str, expected: str, unless: str = "") -> Callable[[_F], _F]:
    """Decorates a function with a required keyword: InputError that says what is expected where it is left out. unless
    : another keyword, which may say the same.
    """

    def of(function: _F) -> _F:
        @wraps(function)
        def called(*args: Any, **given: Any) -> Any:
            if name not in given and unless not in given:
                raise InputError(name, expected, "none")
            return function(*args, **given)

        return cast(_F, called)

    return of


def _word(function: str, name: str, known: list[str], elsewhere: dict[str, str]) -> str:
    text = f"{function}() takes no {name!r}"
    if name in elsewhere:
        return f"{text}: {elsewhere[name]}"
    near = get_close_matches(name, known, 1, 0.6)
    return f"{text}; did you mean {near[0]!r}?" if near else f"{text}; it takes {', '.join(known)}"
