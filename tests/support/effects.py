"""Doors into the catalogue of effects: all classes by their title, compliances, limits as an effect keeps them."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

import handlcp as hl
from handlcp.grasp import effects as _effects
from handlcp.grasp.catalogue import BY_NAME, FROM_DATA
from handlcp.grasp.entry import Entry, entry_of
from handlcp.grasp.environment import ENVIRONMENT as _ENVIRONMENT
from tests.support.grasp import arrays

__all__ = [
    "ENVIRONMENT",
    "KINDS",
    "compliances",
    "entry_for",
    "has_an_equation_of_its_own",
    "kinds_in_the_catalogue",
    "limits_kept",
    "limits_of",
    "made_up_entry",
    "page_of",
    "softened",
    "stamps",
]

ENVIRONMENT: str = _ENVIRONMENT.title
_BASES = {_effects.Effect, _effects.Compliance}
# Every effect there is, by its title
KINDS: dict[str, type] = {
    kind.title: kind
    for kind in vars(_effects).values()
    if isinstance(kind, type) and issubclass(kind, _effects.Effect) and kind not in _BASES
}


def kinds_in_the_catalogue() -> tuple[type, ...]:
    """Those that follow from the data, then those asked for by name."""
    return FROM_DATA + BY_NAME


def page_of(kind: type) -> str:
    """The text on top of the file in which an effect is."""
    return sys.modules[kind.__module__].__doc__ or ""


def entry_for(kind: type) -> Entry:
    """What the catalogue prints of an effect."""
    return entry_of(kind)


def made_up_entry(in_python: str) -> Entry:
    """An entry of nothing but what to type."""
    return Entry("x", "", "", in_python, "", "", "", "handlcp.x")


# ---------------------------------------------------------------- compliances
def compliances() -> list[type]:
    """The effects that become part of the flexibility."""
    return _effects.Compliance.__subclasses__()


def has_an_equation_of_its_own(kind: type) -> bool:
    """Whether a compliance says more than all compliances do."""
    return kind.equation != _effects.Compliance.equation


def stamps(*asked: Any) -> tuple[Any, ...]:
    """Those of these effects that have rows of their own."""
    return _effects.stamped(asked)


def softened(grasp: hl.Grasp, flexibility: np.ndarray, positions: Any = None) -> np.ndarray:
    """A flexibility with that of the grasp's effects added, at other positions where given."""
    a = arrays(grasp)
    where = a.positions if positions is None else positions
    return _effects.softened(flexibility, grasp.effects, where, a.frames, a.plane is not None)


# ---------------------------------------------------------------- limits
def limits_of(effect: Any, grasp: hl.Grasp) -> tuple[Any, ...]:
    """The limits that an effect makes of a grasp; made once."""
    return effect.present(arrays(grasp))


def limits_kept(grasp: hl.Grasp) -> list[tuple[Any, Any]]:
    """(effect, its limits) as far as the grasp keeps them."""
    return arrays(grasp).made
