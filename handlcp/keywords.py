"""What a public call takes: its keywords, as many arguments as it has, and the kinds that its annotations name.

Public functions, classes that users make, and classes with public methods have a decorator of this file each. Numbers
and arrays are checked by the functions themselves, which know bounds and shapes (`check.py`).
"""

from __future__ import annotations

import inspect
import re
import typing
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import cached_property, wraps
from types import FunctionType, NoneType, UnionType
from typing import Any, NamedTuple, TypeVar, cast

from handlcp.errors import InputError, WrongCall, shown

_F = TypeVar("_F", bound=Callable[..., Any])
_C = TypeVar("_C", bound=type)
_UNION = re.compile(r"\|(?![^\[]*\])")  # between the alternatives of an annotation, not within brackets


def helped(*told: str, **elsewhere: str) -> Callable[[_F], _F]:
    """Decorate a function or method so that calls which do not fit it are refused in words that help.

    WrongCall is raised for a keyword that it does not know, with the nearest that it has, or with where it belongs; and
    for too few or too many arguments. InputError is raised where the annotation names a flag, a text, a mapping, a
    function or a class, and something else came.

    told : parameters that the function itself checks, in words that help more.
    elsewhere : keyword that it does not know → where what it means belongs.
    """

    def decorate(function: _F) -> _F:
        call = _Call(function, told, elsewhere)

        @wraps(function)
        def checked_function(*args: Any, **given: Any) -> Any:
            for kind, value in zip(call.in_order, args, strict=False):
                if kind is not None:
                    kind.check(value)
            if call.rest is not None:
                for value in args[len(call.in_order) :]:
                    call.rest.check(value)
            for name, value in given.items():
                if (kind := call.kinds.get(name)) is not None:
                    kind.check(value)
            try:
                return function(*args, **given)
            except TypeError:
                call.check(args, given)
                raise

        checked_function._is_helped = True  # type: ignore[attr-defined]
        return cast(_F, checked_function)

    return decorate


def helped_init(*told: str) -> Callable[[_C], _C]:
    """Decorate a class that users make, such as a dataclass, so that calls of it are checked as those of a function."""

    def decorate(kind: _C) -> _C:
        kind.__init__ = helped(*told)(kind.__init__)  # type: ignore[misc]
        return kind

    return decorate


def helped_methods(kind: _C) -> _C:
    """Decorate a class so that calls of its public methods are checked; inherited methods stay as they are."""
    for name, member in list(vars(kind).items()):
        if not name.startswith("_") and isinstance(member, FunctionType):
            setattr(kind, name, _helped_once(member))
        elif not name.startswith("_") and isinstance(member, (classmethod, staticmethod)):
            setattr(kind, name, type(member)(_helped_once(member.__func__)))
    return kind


def _helped_once(function: _F) -> _F:
    return function if hasattr(function, "_is_helped") else helped()(function)


def needed(name: str, expected: str, unless: str = "") -> Callable[[_F], _F]:
    """Decorate a function with a required keyword: leaving it out raises InputError, which says what is expected.

    name : the keyword.
    expected : in words.
    unless : another keyword, which may say the same; "": there is none.
    """

    def decorate(function: _F) -> _F:
        @wraps(function)
        def checked_function(*args: Any, **given: Any) -> Any:
            if name not in given and unless not in given:
                raise InputError(name, expected, "none")
            return function(*args, **given)

        return cast(_F, checked_function)

    return decorate


class _Kind(NamedTuple):
    """The values that a parameter takes.

    name : of the parameter.
    types : of the values.
    function : whether functions may come.
    said : what is expected, in words, for refusals.
    """

    name: str
    types: tuple[type, ...]
    function: bool
    said: str

    def check(self, value: object) -> None:
        """Check that a value is one of them; a class, which makes things, is no function. Raises InputError."""
        called = self.function and callable(value) and not isinstance(value, type)
        if not (isinstance(value, self.types) or called):
            raise InputError(self.name, self.said, shown(value))


class _Call:
    """What is known of a function that users call, looked up when it is first called."""

    def __init__(self, function: Callable[..., Any], told: tuple[str, ...], elsewhere: dict[str, str]) -> None:
        self.function, self.told, self.elsewhere = function, told, elsewhere

    @cached_property
    def signature(self) -> inspect.Signature:
        return inspect.signature(self.function)

    @cached_property
    def kinds(self) -> dict[str, _Kind]:
        """Values that parameters take, by name; those that take anything, or that the function checks, are left out."""
        known = inspect.unwrap(self.function).__globals__
        found = {p.name: _kind(p, known) for p in self.signature.parameters.values() if p.name not in self.told}
        return {name: kind for name, kind in found.items() if kind is not None}

    @cached_property
    def in_order(self) -> list[_Kind | None]:
        """Values of the parameters that may be passed without a name, in their order."""
        named = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
        return [self.kinds.get(p.name) for p in self.signature.parameters.values() if p.kind in named]

    @cached_property
    def rest(self) -> _Kind | None:
        """Values of the parameter that takes any number of arguments more, such as `*texts`; None: there is none."""
        every = [p for p in self.signature.parameters.values() if p.kind is p.VAR_POSITIONAL]
        return self.kinds.get(every[0].name) if every else None

    def check(self, args: tuple[Any, ...], given: dict[str, Any]) -> None:
        """Check that the function takes these arguments. Raises WrongCall."""
        every = self.signature.parameters
        known = [p.name for p in every.values() if p.name not in ("self", "cls")]
        called_as = self.function.__qualname__.removesuffix(".__init__").rpartition(".")[2]
        if not any(p.kind is p.VAR_KEYWORD for p in every.values()) and (new := [k for k in given if k not in every]):
            raise WrongCall(new[0], "; ".join(_word(called_as, name, known, self.elsewhere) for name in new))
        try:
            self.signature.bind(*args, **given)
        except TypeError as error:
            name = next((name for name in known if repr(name) in str(error)), "")
            raise WrongCall(name, f"{called_as}(): {error}; it takes {', '.join(known) or 'nothing'}") from None


def _kind(parameter: inspect.Parameter, known: Mapping[str, Any]) -> _Kind | None:
    """The values that a parameter's annotation allows; None where it allows anything."""
    annotation = parameter.annotation
    if not isinstance(annotation, str) or parameter.kind is parameter.VAR_KEYWORD:
        return None
    parts = _UNION.split(annotation.strip("'\""))
    found = [_types(part.strip(), known) for part in parts]
    if not all(found):
        return None
    types = {kind for few in found for kind in few}
    if parameter.default is not parameter.empty:
        types.add(type(parameter.default))  # such as ... for "not given"
    said = _said(types)
    return _Kind(parameter.name, tuple(types - {FunctionType}), FunctionType in types, said)


def _types(part: str, known: Mapping[str, Any]) -> tuple[type, ...]:
    """The types that one alternative of an annotation names; () where the function itself checks its values."""
    plain = {"bool": bool, "str": str, "None": NoneType, "Mapping": Mapping, "dict": dict, "Callable": FunctionType}
    head = part.partition("[")[0]
    return (plain[head],) if head in plain else _of_alias(known.get(head))


def _of_alias(value: Any) -> tuple[type, ...]:
    """The types that a name in an annotation stands for: a class of the package, or a union of such kinds."""
    if isinstance(value, UnionType) or typing.get_origin(value) is typing.Union:
        found = [_of_alias(one) for one in typing.get_args(value)]
        return tuple([kind for few in found for kind in few]) if all(found) else ()
    if typing.get_origin(value) in (Callable, dict):
        return (FunctionType,) if typing.get_origin(value) is Callable else (Mapping,)
    if value in (bool, str, NoneType):
        return (value,)
    own = isinstance(value, type) and value.__module__.startswith("handlcp") and not getattr(value, "_is_protocol", 0)
    return (value,) if own else ()


_SAID = {bool: "True or False", str: "a text", NoneType: "None", FunctionType: "a function", Mapping: "a mapping"}
_OTHERWISE = (type(...), int, float, tuple)  # of defaults, which need no word


def _said(types: set[type]) -> str:
    """The types in words for refusals, such as "a text or None"."""
    words = [
        _SAID.get(kind) or f"{'an' if kind.__name__[0] in 'AEIOU' else 'a'} {kind.__name__}"
        for kind in types
        if kind not in _OTHERWISE
    ]
    words.sort(key=lambda word: (word == "None", word))
    return " or ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)


# What other books and programs call parameters of ours
_OTHERS_SAY = {
    "mu": ("friction",),
    "friction_coefficient": ("friction",),
    "load": ("wrench",),
    "force": ("wrench", "load"),
    "object": ("target",),
    "angles": ("q",),
    "posture": ("q",),
    "stiffness": ("joint_stiffness",),
}


def _word(function: str, name: str, known: list[str], elsewhere: dict[str, str]) -> str:
    """What is said of a keyword that a function does not know: where it belongs, the nearest, or all there are."""
    text = f"{function}() takes no {name!r}"
    if name in elsewhere:
        return f"{text}: {elsewhere[name]}"
    near = [word for word in _OTHERS_SAY.get(name, ()) if word in known] or get_close_matches(name, known, 1, 0.6)
    return f"{text}; did you mean {near[0]!r}?" if near else f"{text}; it takes {', '.join(known) or 'nothing'}"
