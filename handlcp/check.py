"""Checks of what users pass, made where it enters. Each returns a clean read-only array or raises one `InputError`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from handlcp.errors import InputError, UnknownName, shown
from handlcp.tolerances import LARGEST, SEMIDEFINITE, SYMMETRY

_FLOAT = np.dtype(float)
_NEARLY_UNIT = 1e-3  # a normal off by less was rounded or computed, and is normalised; by more, it is a mistake

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


_NO_NUMBERS = (str, bytes, bool, complex, np.complexfloating, np.bool_, list, tuple, dict, set, np.ma.MaskedArray)


def read_only(a: Array) -> Array:
    """Switch writing to an array off, and return it."""
    a.setflags(write=False)
    return a


_NOTHING = read_only(np.zeros(0))


def nothing() -> Array:
    """An empty read-only array (0,), the default of fields that most scenes leave empty."""
    return _NOTHING


def sealed(state: dict[str, Any]) -> dict[str, Any]:
    """Make the arrays of an object's attributes read-only: those that were pickled come back writable."""
    for value in state.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return state


def array(
    argument: str, value: Any, *shapes: tuple[int, ...], what: str = "finite numbers", largest: float = LARGEST
) -> Array:
    """A fresh read-only float array of one of `shapes` (-1: any length), finite and at most `largest` in size."""
    try:
        raw = np.array(value)
        # Text, complex numbers and truth values convert too readily to be meant; integers beyond float64 not at all
        a = raw if raw.dtype == _FLOAT else raw.astype(float) if raw.dtype.kind in "iuf" or not raw.size else None
    except (TypeError, ValueError, OverflowError):
        a = None
    if a is None:
        raise InputError(argument, f"{what} of shape {_names(shapes)}", shown(value))
    if shapes and a.shape not in shapes and not any(_fits(a.shape, s) for s in shapes):
        raise InputError(argument, f"{what} of shape {_names(shapes)}", f"shape {a.shape}")
    size = abs(a)
    if not size.max(initial=0.0) <= largest:  # nor is it where one is not a number
        if not np.isfinite(a).all():
            raise InputError(argument, what, f"{shown(value)} with {int((~np.isfinite(a)).sum())} entries not finite")
        raise InputError(argument, f"{what} up to {largest:g} in size", f"{size.max():.3g}")
    a[size < 1.0 / largest**2] = 0.0  # their reciprocals would overflow
    return read_only(a)


def dimensions(value: Any) -> int:
    """How many dimensions an array of the value has; -1 for lists of different lengths, which make no array."""
    try:
        return int(np.ndim(value))
    except ValueError:
        return -1


def number(
    argument: str, value: Any, *, minimum: float = -np.inf, above: float = -np.inf, finite: bool = True
) -> float:
    """A real number ≥ `minimum` and > `above`, of a size that floats can square, unless infinity is welcome."""
    bound = f" ≥ {minimum:g}" if minimum > -np.inf else f" > {above:g}" if above > -np.inf else ""
    expected = f"a {'finite ' if finite else ''}number{bound}"
    if isinstance(value, _NO_NUMBERS) or (
        isinstance(value, np.ndarray) and (value.ndim > 0 or value.dtype.kind not in "iuf")
    ):
        raise InputError(argument, expected, shown(value))
    try:
        x = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(argument, expected, shown(value)) from None
    if abs(x) < 1.0 / LARGEST**2:
        x = 0.0  # its reciprocal would overflow
    if LARGEST < abs(x) < np.inf:
        raise InputError(argument, f"{expected}, at most {LARGEST:g} in size", f"{x:g}")
    low = x < minimum or (x <= above and above > -np.inf)
    if low or x != x or (finite and abs(x) == np.inf):
        raise InputError(argument, expected, x)
    return x


def integer(argument: str, value: Any, least: int, most: int = 2**63 - 1) -> int:
    """A whole number from `least` to `most`."""
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, (bool, np.bool_))
    if not whole or not least <= int(value) <= most:
        raise InputError(argument, f"an integer ≥ {least}{f' and ≤ {most}' if most < 2**63 - 1 else ''}", shown(value))
    return int(value)


def cores(workers: Any) -> int:
    """How many work at a time on this machine: an integer ≥ 1, or None for one a core."""
    return (os.cpu_count() or 1) if workers is None else integer("workers", workers, 1)


def yes_or_no(argument: str, value: Any) -> bool:
    """True or False, and nothing that is only taken for one of them. Raises InputError."""
    if not isinstance(value, bool):
        raise InputError(argument, "True or False", repr(value)[:80])
    return value


def several(argument: str, value: Any, expected: str) -> tuple[Any, ...]:
    """What a sequence, a set or an array holds; a text, a mapping and a single number hold nothing. Raises InputError,
    which says what is `expected`.
    """
    try:
        if isinstance(value, (str, bytes, Mapping)):
            raise TypeError
        return tuple(value)
    except TypeError:  # nor does an array without dimensions
        raise InputError(argument, expected, shown(value)) from None


def per_name(argument: str, values: Mapping[Any, Any], names: Sequence[str], kind: str) -> dict[str, Any]:
    """The mapping with its keys checked against `names`. Raises UnknownName, listing them."""
    unknown = [str(key) for key in values if key not in names]
    if unknown:
        raise UnknownName(argument, kind, unknown, names)
    return dict(values)


def unit(argument: str, value: Any, *shapes: tuple[int, ...]) -> Array:
    """A unit vector, normalised to the last bit; its length may differ from one by less than 1e-3."""
    a = array(argument, value, *shapes)
    norm = float(np.linalg.norm(a))
    if not abs(norm - 1) < _NEARLY_UNIT:
        meant = "" if norm == 0.0 else f"; is {[round(x, 6) for x in (a / norm).tolist()]} meant?"
        raise InputError(argument, "a unit vector", f"{a.tolist()} of length {norm:.6g}{meant}")
    return read_only(a / norm)


def symmetric(argument: str, a: Array) -> Array:
    """The symmetric part of a matrix that is symmetric to rounding."""
    size = float(abs(a).max(initial=0.0))
    skew = float(abs(a - a.T).max(initial=0.0))
    if skew > SYMMETRY * size:
        found = f"one whose entries differ from its transpose by up to {skew:.3g}"
        raise InputError(argument, "a symmetric matrix", found)
    return read_only((a + a.T) / 2)


def psd(argument: str, a: Array) -> Array:
    """A symmetric positive semidefinite matrix: no eigenvalue is below 0 but for rounding."""
    a = symmetric(argument, a)
    if a.size:
        eig = np.linalg.eigvalsh(a)
        if eig[0] < -SEMIDEFINITE * max(float(eig[-1]), 0.0) or eig[-1] < 0:
            raise InputError(argument, "a positive semidefinite matrix", f"one with the eigenvalue {eig[0]:.6g}")
    return a


def spd(argument: str, a: Array) -> Array:
    """A symmetric positive definite matrix."""
    a = symmetric(argument, a)
    if a.size:
        eig = np.linalg.eigvalsh(a)
        if eig[0] <= SEMIDEFINITE * abs(float(eig[-1])):
            raise InputError(argument, "a positive definite matrix", f"one with the eigenvalue {eig[0]:.6g}")
    return a


def _fits(shape: tuple[int, ...], wanted: tuple[int, ...]) -> bool:
    return len(shape) == len(wanted) and all(w in (-1, s) for s, w in zip(shape, wanted, strict=True))


def _names(shapes: Sequence[tuple[int, ...]]) -> str:
    return " or ".join(str(s).replace("-1", "n") for s in shapes) or "any"
