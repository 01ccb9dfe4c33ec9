"""What users pass where a friction law is meant: the law, or a number for Coulomb's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from handlcp.check import number, per_name
from handlcp.errors import InputError, shown
from handlcp.grasp.friction.coulomb import Coulomb
from handlcp.grasp.friction.law import FrictionLaw, law_words

_MOST = 10.0  # of a coefficient that is given as a number: soft rubber has 3, and sticky pads little more


def as_law(value: Any, argument: str = "friction", instead: str = "") -> FrictionLaw:
    """A law as it is; a number from 0 to 10 as `Coulomb` with that coefficient. instead : what else it may be, for the
    InputError that it raises.
    """
    if isinstance(value, FrictionLaw):
        return value
    try:
        mu = number(argument, value, minimum=0.0)
    except InputError:
        expected = f"a coefficient ≥ 0, {law_words()}{instead}"
        raise InputError(argument, expected, shown(value)) from None
    if mu > _MOST:
        expected = f"a coefficient of at most {_MOST:g}, or Coulomb({mu:g}) where that is meant"
        raise InputError(argument, expected, f"{mu:g} (per cent? {mu / 100:g})")
    return Coulomb(mu)


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
