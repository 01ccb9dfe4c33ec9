"""`check_array` and its like: checks of what users pass, made where it enters. Each returns a clean read-only array or
raises one `InputError`.
"""

from __future__ import annotations

import inspect
import os
import re
import typing
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from functools import cached_property, wraps
from itertools import chain, repeat
from types import FunctionType, NoneType, UnionType
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
import numpy.typing as npt

from handlcp.errors import InputError, UnknownName, WrongCall, shorten_repr
from handlcp.tolerances import MAX_NUMBER, SEMIDEFINITE_TOLERANCE, SYMMETRY_TOLERANCE

_FLOAT = np.dtype(float)
# A normal off by less was rounded or computed, and is normalised; by more, it is a mistake
_UNIT_LENGTH_TOLERANCE = 1e-3

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


_NON_NUMBER_TYPES = (str, bytes, bool, complex, np.complexfloating, np.bool_, list, tuple, dict, set, np.ma.MaskedArray)


def read_only(a: Array) -> Array:
    """Switch writing to an array off, and return it."""
    a.setflags(write=False)
    return a


def freeze_arrays(state: dict[str, Any]) -> dict[str, Any]:
    """Make the arrays of an object's attributes read-only: those that were pickled come back writable."""
    for value in state.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return state


def check_array(
    argument: str, value: Any, *shapes: tuple[int, ...], what: str = "finite numbers", largest: float = MAX_NUMBER
) -> Array:
    """A fresh read-only float array of one of `shapes` (-1: any length), finite and at most `largest` in size."""
    try:
        raw = np.array(value)
        # Text, complex numbers and truth values convert too readily to be meant; integers beyond float64 not at all
        a = raw if raw.dtype == _FLOAT else raw.astype(float) if raw.dtype.kind in "iuf" or not raw.size else None
    except (TypeError, ValueError, OverflowError):
        a = None
    if a is None:
        raise InputError(argument, f"{what} of shape {_format_shapes(shapes)}", shorten_repr(value))
    if shapes and a.shape not in shapes and not any(_is_of_shape(a.shape, s) for s in shapes):
        raise InputError(argument, f"{what} of shape {_format_shapes(shapes)}", f"shape {a.shape}")
    size = abs(a)
    if not size.max(initial=0.0) <= largest:  # nor is it where one is not a number
        if odd := int((~np.isfinite(a)).sum()):
            raise InputError(argument, what, f"{shorten_repr(value)} with {odd} entries not finite")
        raise InputError(argument, f"{what} up to {largest:g} in size", f"{size.max():.3g}")
    a[size < 1.0 / largest**2] = 0.0  # their reciprocals would overflow
    return read_only(a)


def count_dimensions(value: Any) -> int:
    """How many dimensions an array of the value has; -1 for lists of different lengths, which make no array."""
    try:
        return int(np.ndim(value))
    except ValueError:
        return -1


def check_number(
    argument: str, value: Any, *, minimum: float = -np.inf, above: float = -np.inf, finite: bool = True
) -> float:
    """A real number ≥ `minimum` and > `above`, of a size that floats can square, unless infinity is welcome."""
    x = _as_float(value)
    if x is None:
        raise InputError(argument, describe_number(minimum, above, finite), shorten_repr(value))
    if abs(x) < 1.0 / MAX_NUMBER**2:
        x = 0.0  # its reciprocal would overflow
    if MAX_NUMBER < abs(x) < np.inf:
        expected = f"{describe_number(minimum, above, finite)}, at most {MAX_NUMBER:g} in size"
        raise InputError(argument, expected, f"{x:g}")
    low = x < minimum or (x <= above and above > -np.inf)
    if low or x != x or (finite and abs(x) == np.inf):
        raise InputError(argument, describe_number(minimum, above, finite), x)
    return x


def describe_number(minimum: float = -np.inf, above: float = -np.inf, finite: bool = True) -> str:
    """The numbers with these bounds in words, such as "a finite number ≥ 0"."""
    bound = f" ≥ {minimum:g}" if minimum > -np.inf else f" > {above:g}" if above > -np.inf else ""
    return f"a {'finite ' if finite else ''}number{bound}"


def _as_float(value: Any) -> float | None:
    """The value as a float; None for what is no real number."""
    if isinstance(value, _NON_NUMBER_TYPES):
        return None
    if isinstance(value, np.ndarray) and (value.ndim > 0 or value.dtype.kind not in "iuf"):
        return None
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return None


class NumbersByName(NamedTuple):
    """What an argument takes that has a number for each of some names: one for all, as many as there are names, or a
    mapping by name.

    kind : of the names, such as "joint".
    minimum, above, finite : bounds of each number, as in `check_number`.
    rest : number of the names that a mapping leaves out.
    only_common_bounded : whether the bounds are those of one number for all, and other numbers need only be finite.
    has_common : whether one number for all may come.
    """

    kind: str
    minimum: float = -np.inf
    above: float = -np.inf
    finite: bool = True
    rest: float = 0.0
    only_common_bounded: bool = False
    has_common: bool = True

    @property
    def expected(self) -> str:
        """What the argument takes, in words."""
        number = describe_number(self.minimum, self.above, self.finite)
        if not self.has_common:
            return f"{number} for each {self.kind}, or a table of them by {self.kind} name"
        other = "one finite number" if self.only_common_bounded else "one"
        return f"{number}, {other} for each {self.kind}, or a table of them by {self.kind} name"

    def read(self, argument: str, value: Any, names: Sequence[str] | None = None) -> Array:
        """(k,) the numbers, in the order of the k names. Raises InputError, UnknownName.

        names : None: not known yet, as where a file is read; the numbers alone are checked then.
        """
        if isinstance(value, Mapping):
            given = value if names is None else check_keys(argument, value, names, f"a {self.kind}")
            found = {name: self._check_one(f"{argument}[{name!r}]", x) for name, x in given.items()}
            return read_only(np.array([found.get(name, self.rest) for name in (found if names is None else names)]))
        depth = count_dimensions(value)
        if depth == 0 and self.has_common and _as_float(value) is not None:
            number = check_number(argument, value, minimum=self.minimum, above=self.above, finite=self.finite)
            return read_only(np.full(1 if names is None else len(names), number))
        if depth != 1:
            raise InputError(argument, self.expected, shorten_repr(value))
        if names is not None and len(value) != len(names):
            expected = f"{len(names)} values, one for each of {', '.join(names)}"
            raise InputError(argument, expected, f"{len(value)} of them")
        try:
            return read_only(np.array([self._check_one(argument, x) for x in value]))
        except InputError as error:
            raise InputError(argument, error.expected, shorten_repr(value)) from None

    def _check_one(self, argument: str, value: Any) -> float:
        """One of several numbers."""
        if self.only_common_bounded:
            return check_number(argument, value)
        return check_number(argument, value, minimum=self.minimum, above=self.above, finite=self.finite)


def check_integer(argument: str, value: Any, least: int, most: int = 2**63 - 1) -> int:
    """A whole number from `least` to `most`."""
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, (bool, np.bool_))
    if not whole or not least <= int(value) <= most:
        bounds = f"≥ {least}{f' and ≤ {most}' if most < 2**63 - 1 else ''}"
        raise InputError(argument, f"an integer {bounds}", shorten_repr(value))
    return int(value)


def check_workers(workers: Any) -> int:
    """How many work at a time on this machine: an integer ≥ 1, or None for one a core."""
    return (os.cpu_count() or 1) if workers is None else check_integer("workers", workers, 1)


def check_flag(argument: str, value: Any) -> bool:
    """True or False, and nothing that is only taken for one of them. Raises InputError."""
    if not isinstance(value, bool):
        raise InputError(argument, "True or False", repr(value)[:80])
    return value


def check_sequence(argument: str, value: Any, expected: str) -> tuple[Any, ...]:
    """What a sequence, a set or an array holds; a text, a mapping and a single number hold nothing. Raises InputError,
    which says what is `expected`.
    """
    try:
        if isinstance(value, (str, bytes, Mapping)):
            raise TypeError
        return tuple(value)
    except TypeError:  # nor does an array without dimensions
        raise InputError(argument, expected, shorten_repr(value)) from None


def check_keys(argument: str, values: Mapping[Any, Any], names: Sequence[str], kind: str) -> dict[str, Any]:
    """The mapping with its keys checked against `names`. Raises UnknownName, listing them."""
    unknown = [str(key) for key in values if key not in names]
    if unknown:
        raise UnknownName(argument, kind, unknown, names)
    return dict(values)


def check_unit_vector(argument: str, value: Any, *shapes: tuple[int, ...]) -> Array:
    """A unit vector, normalised to the last bit; its length may differ from one by less than 1e-3."""
    a = check_array(argument, value, *shapes)
    norm = float(np.linalg.norm(a))
    if not abs(norm - 1) < _UNIT_LENGTH_TOLERANCE:
        meant = "" if norm == 0.0 else f"; is {[round(x, 6) for x in (a / norm).tolist()]} meant?"
        raise InputError(argument, "a unit vector", f"{a.tolist()} of length {norm:.6g}{meant}")
    return read_only(a / norm)


def check_symmetric(argument: str, a: Array) -> Array:
    """The symmetric part of a matrix that is symmetric to rounding."""
    size = float(abs(a).max(initial=0.0))
    skew = float(abs(a - a.T).max(initial=0.0))
    if skew > SYMMETRY_TOLERANCE * size:
        found = f"one whose entries differ from its transpose by up to {skew:.3g}"
        raise InputError(argument, "a symmetric matrix", found)
    return read_only((a + a.T) / 2)


def check_psd(argument: str, a: Array) -> Array:
    """A symmetric positive semidefinite matrix: no eigenvalue is below 0 but for rounding."""
    a = check_symmetric(argument, a)
    if a.size:
        eig = np.linalg.eigvalsh(a)
        if eig[0] < -SEMIDEFINITE_TOLERANCE * max(float(eig[-1]), 0.0) or eig[-1] < 0:
            raise InputError(argument, "a positive semidefinite matrix", f"one with the eigenvalue {eig[0]:.6g}")
    return a


def check_spd(argument: str, a: Array) -> Array:
    """A symmetric positive definite matrix."""
    a = check_symmetric(argument, a)
    if a.size:
        eig = np.linalg.eigvalsh(a)
        if eig[0] <= SEMIDEFINITE_TOLERANCE * abs(float(eig[-1])):
            raise InputError(argument, "a positive definite matrix", f"one with the eigenvalue {eig[0]:.6g}")
    return a


def _is_of_shape(shape: tuple[int, ...], wanted: tuple[int, ...]) -> bool:
    return len(shape) == len(wanted) and all(w in (-1, s) for s, w in zip(shape, wanted, strict=True))


def _format_shapes(shapes: Sequence[tuple[int, ...]]) -> str:
    return " or ".join(str(s).replace("-1", "n") for s in shapes) or "any"


# ----------------------------------------------------------------
# What a public call takes: its keywords, as many arguments as it has, and the kinds that its annotations name.
#
# Public functions, classes that users make, and classes with public methods have a decorator of this part each. Numbers
# and arrays are checked by the functions themselves, which know bounds and shapes.


_F = TypeVar("_F", bound=Callable[..., Any])
_C = TypeVar("_C", bound=type)
_PLAIN_TYPES: dict[str, type] = {
    "bool": bool, "str": str, "None": NoneType, "Mapping": Mapping, "dict": dict, "Callable": FunctionType
}  # fmt: skip
_UNION_SEPARATOR = re.compile(r"\|(?![^\[]*\])")  # between the alternatives of an annotation, not within brackets


def check_call(*told: str, **elsewhere: str) -> Callable[[_F], _F]:
    """Decorate a function or method so that calls which do not fit it are refused in words that help.

    WrongCall is raised for a keyword that it does not know, with the nearest that it has, or with where it belongs; and
    for too few or too many arguments. InputError is raised where the annotation names a flag, a text, a mapping, a
    function or a class, and something else came.

    told : parameters that the function itself checks, in words that help more.
    elsewhere : keyword that it does not know → where what it means belongs.
    """

    def decorate(function: _F) -> _F:
        call = _CallRules(function, told, elsewhere)

        @wraps(function)
        def checked_function(*args: Any, **given: Any) -> Any:
            named, rest = call.accepted_in_order
            for kind, value in zip(chain(named, repeat(rest)), args, strict=False):
                if kind is not None:
                    kind.check(value)
            for name, value in given.items():
                if (kind := call.accepted_values.get(name)) is not None:
                    kind.check(value)
            try:
                return function(*args, **given)
            except TypeError:
                call.check(args, given)
                raise

        checked_function._is_helped = True  # type: ignore[attr-defined]
        return cast(_F, checked_function)

    return decorate


def check_init_call(*told: str) -> Callable[[_C], _C]:
    """Decorate a class that users make, such as a dataclass, so that calls of it are checked as those of a function."""

    def decorate(kind: _C) -> _C:
        kind.__init__ = check_call(*told)(kind.__init__)  # type: ignore[misc]
        return kind

    return decorate


def check_method_calls(kind: _C) -> _C:
    """Decorate a class so that calls of its public methods are checked; inherited methods stay as they are."""
    for name, member in list(vars(kind).items()):
        if not name.startswith("_") and isinstance(member, FunctionType):
            setattr(kind, name, _check_call_once(member))
        elif not name.startswith("_") and isinstance(member, (classmethod, staticmethod)):
            setattr(kind, name, type(member)(_check_call_once(member.__func__)))
    return kind


def _check_call_once(function: _F) -> _F:
    return function if hasattr(function, "_is_helped") else check_call()(function)


def require_keyword(name: str, expected: str, unless: str = "") -> Callable[[_F], _F]:
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


class _AcceptedValues(NamedTuple):
    """The values that a parameter takes.

    name : of the parameter.
    types : of the values.
    takes_functions : whether functions may come.
    expected : what is expected, in words, for refusals.
    """

    name: str
    types: tuple[type, ...]
    takes_functions: bool
    expected: str

    def check(self, value: object) -> None:
        """Check that a value is one of them; a class, which makes things, is no function. Raises InputError."""
        called = self.takes_functions and callable(value) and not isinstance(value, type)
        if not (isinstance(value, self.types) or called):
            raise InputError(self.name, self.expected, shorten_repr(value))


class _CallRules:
    """What is known of a function that users call, looked up when it is first called."""

    def __init__(self, function: Callable[..., Any], told: tuple[str, ...], elsewhere: dict[str, str]) -> None:
        self.function, self.self_checked, self.hints = function, told, elsewhere

    @cached_property
    def signature(self) -> inspect.Signature:
        return inspect.signature(self.function)

    @cached_property
    def accepted_values(self) -> dict[str, _AcceptedValues]:
        """Values that parameters take, by name; those that take anything, or that the function checks, are left out."""
        known = inspect.unwrap(self.function).__globals__
        found = {
            p.name: _accepted_values(p, known)
            for p in self.signature.parameters.values()
            if p.name not in self.self_checked
        }
        return {name: kind for name, kind in found.items() if kind is not None}

    @cached_property
    def accepted_in_order(self) -> tuple[list[_AcceptedValues | None], _AcceptedValues | None]:
        """Values of the parameters that may be passed without a name, in their order, then of one such as `*texts`."""
        every, of = self.signature.parameters.values(), self.accepted_values.get
        named = [of(p.name) for p in every if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
        return named, next((of(p.name) for p in every if p.kind is p.VAR_POSITIONAL), None)

    def check(self, args: tuple[Any, ...], given: dict[str, Any]) -> None:
        """Check that the function takes these arguments. Raises WrongCall."""
        every = self.signature.parameters
        known = [p.name for p in every.values() if p.name not in ("self", "cls")]
        called_as = self.function.__qualname__.removesuffix(".__init__").rpartition(".")[2]
        if not any(p.kind is p.VAR_KEYWORD for p in every.values()) and (new := [k for k in given if k not in every]):
            raise WrongCall(new[0], "; ".join(_describe_unknown(called_as, name, known, self.hints) for name in new))
        try:
            self.signature.bind(*args, **given)
        except TypeError as error:
            name = next((name for name in known if repr(name) in str(error)), "")
            raise WrongCall(name, f"{called_as}(): {error}; it takes {', '.join(known) or 'nothing'}") from None


def _accepted_values(parameter: inspect.Parameter, known: Mapping[str, Any]) -> _AcceptedValues | None:
    """The values that a parameter's annotation allows; None where it allows anything."""
    annotation = parameter.annotation
    if not isinstance(annotation, str) or parameter.kind is parameter.VAR_KEYWORD:
        return None
    parts = _UNION_SEPARATOR.split(annotation.strip("'\""))
    heads = [part.strip().partition("[")[0] for part in parts]
    # One that names other types is checked by the function itself
    found = [(_PLAIN_TYPES[head],) if head in _PLAIN_TYPES else _types_of_alias(known.get(head)) for head in heads]
    if not all(found):
        return None
    types = {kind for few in found for kind in few}
    if parameter.default is not parameter.empty:
        types.add(type(parameter.default))  # such as ... for "not given"
    said = _describe_types(types)
    return _AcceptedValues(parameter.name, tuple(types - {FunctionType}), FunctionType in types, said)


def _types_of_alias(value: Any) -> tuple[type, ...]:
    """The types that a name in an annotation stands for: a class of the package, or a union of such kinds."""
    if isinstance(value, UnionType) or typing.get_origin(value) is typing.Union:
        found = [_types_of_alias(one) for one in typing.get_args(value)]
        return tuple([kind for few in found for kind in few]) if all(found) else ()
    if typing.get_origin(value) in (Callable, dict):
        return (FunctionType,) if typing.get_origin(value) is Callable else (Mapping,)
    if value in (bool, str, NoneType):
        return (value,)
    own = isinstance(value, type) and value.__module__.startswith("handlcp") and not getattr(value, "_is_protocol", 0)
    return (value,) if own else ()


_TYPE_DESCRIPTIONS = {
    bool: "True or False",
    str: "a text",
    NoneType: "None",
    FunctionType: "a function",
    Mapping: "a mapping",
}
_UNDESCRIBED_TYPES = (type(...), int, float, tuple)  # of defaults, which need no word


def _describe_types(types: set[type]) -> str:
    """The types in words for refusals, such as "a text or None"."""
    words = [
        _TYPE_DESCRIPTIONS.get(kind) or f"{'an' if kind.__name__[0] in 'AEIOU' else 'a'} {kind.__name__}"
        for kind in types
        if kind not in _UNDESCRIBED_TYPES
    ]
    words.sort(key=lambda word: (word == "None", word))
    return " or ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)


# What other books and programs call parameters of ours
_FOREIGN_NAMES = {
    "mu": ("friction",),
    "friction_coefficient": ("friction",),
    "load": ("wrench",),
    "force": ("wrench", "load"),
    "object": ("target",),
    "angles": ("q",),
    "posture": ("q",),
    "stiffness": ("joint_stiffness",),
}


def _describe_unknown(function: str, name: str, known: list[str], elsewhere: dict[str, str]) -> str:
    """What is said of a keyword that a function does not know: where it belongs, the nearest, or all there are."""
    text = f"{function}() takes no {name!r}"
    if name in elsewhere:
        return f"{text}: {elsewhere[name]}"
    near = [word for word in _FOREIGN_NAMES.get(name, ()) if word in known] or get_close_matches(name, known, 1, 0.6)
    return f"{text}; did you mean {near[0]!r}?" if near else f"{text}; it takes {', '.join(known) or 'nothing'}"
