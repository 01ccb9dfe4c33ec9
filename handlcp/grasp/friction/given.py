"""What users pass where a friction law is meant: the law, or a number for Coulomb's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from handlcp.check import number, per_name
from handlcp.errors import InputError
from handlcp.grasp.friction.coulomb import Coulomb
from handlcp.grasp.friction.law import FrictionLaw, law_words


def as_law(value: Any, argument: str = "friction", instead: str = "") -> FrictionLaw:
    """A law as it is; a number μ ≥ 0 as `Coulomb(μ)`. Raises InputError; instead : what else it may be, for that."""
    if isinstance(value, FrictionLaw):
        return value
    try:
        return Coulomb(number(argument, value, minimum=0.0))
    except InputError:
        expected = f"a coefficient ≥ 0, {law_words()}{instead}"
        raise InputError(argument, expected, repr(value)[:80]) from None


def laws_by_name(value: Any, names: Sequence[str], others: Sequence[FrictionLaw]) -> list[FrictionLaw]:
    """A law for each of `names`: one for all, or a mapping by fingertip in which those not named have that of `others`.

    Raises InputError, UnknownName.
    """
    if not isinstance(value, Mapping):
        return [as_law(value, instead=", or a mapping of fingertips to them")] * len(names)
    given = per_name("friction", value, names, "a fingertip")
    return [
        as_law(given[name], f"friction[{name!r}]") if name in given else law
        for name, law in zip(names, others, strict=True)
    ]
