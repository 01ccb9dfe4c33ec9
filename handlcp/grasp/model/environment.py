"""What the object touches besides the hand: a table, a wall, a fixture.

    E = blkdiag(E_fingers, E_environment),    J_environment = 0

An environment contact is a contact like any other (unilateral, with friction and a gap) whose finger is the world. No
joint moves it, so that its rows of the Jacobian are zero, no preload squeezes it and no soft wrist carries it; what
gives way is the environment itself: 0, a rigid one. In all arrays the fingers come first, the environment's contacts
last.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, number, read_only, several
from handlcp.errors import InputError
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Contact
from handlcp.keywords import helped_init


@helped_init()
class Environment:
    """m contacts of the world with the object, for `Grasp(..., environment=...)` and `state.grasp(..., environment=)`.

    contacts : sequence of `Contact`, m of them, normals into the object; one without a name becomes "environment 1", …
    flexibility : [m/N] as in `Grasp`: a number, a (3,) diagonal for each, (m, 3, 3) blocks or the (3m, 3m) matrix in
        contact axes; 0: rigid. Several contacts on something rigid seldom have determined forces.
    gap : [m] a number or (m,), from the object to each; < 0: it overlaps, and is squeezed by as much.

    Attributes: contacts, flexibility (3m, 3m), gap (m,). Immutable. Raises InputError.
    """

    __slots__ = ("contacts", "flexibility", "gap")

    contacts: tuple[Contact, ...]
    flexibility: Array
    gap: Array

    def __init__(self, contacts: Iterable[Contact], flexibility: Any = 0.0, gap: Any = 0.0) -> None:
        cs = validate.contacts(contacts)
        m = len(cs)
        given = np.full(m, number("gap", gap)) if dimensions(gap) == 0 else array("gap", gap, (m,))
        E = validate.flexibility(flexibility, m, cs[0].planar)
        for name, value in (("contacts", cs), ("flexibility", E), ("gap", read_only(given))):
            object.__setattr__(self, name, value)

    @property
    def offset(self) -> Array:
        """(m, 3) the gaps as offsets in contact axes [m]."""
        return np.column_stack([np.zeros((len(self.gap), 2)), self.gap])

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"an Environment is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        return (Environment, (self.contacts, self.flexibility, self.gap))

    def __repr__(self) -> str:
        return f"Environment({list(self.contacts)!r})"


def joined(value: Any) -> Environment:
    """One environment of one or several, every contact with a name of its own. Raises InputError."""
    expected = "an Environment (of a Table: table.under(obj)), or a sequence of them"
    parts = (value,) if isinstance(value, Environment) else several("environment", value, expected)
    for k, part in enumerate(parts):
        if not isinstance(part, Environment):
            raise InputError(f"environment[{k}]", "an Environment", repr(part)[:80])
    if not parts:
        raise InputError("environment", "at least one Environment, or None", "an empty sequence")
    given = [c for part in parts for c in part.contacts]
    names = [c.name or f"environment {k}" for k, c in enumerate(given, 1)]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise InputError("environment", "a different name for each contact", f"several called {', '.join(twice)}")
    blocks = reduce(beside, [part.flexibility for part in parts])
    contacts = [c.named(name) for c, name in zip(given, names, strict=True)]
    return Environment(contacts, blocks, np.concatenate([part.gap for part in parts]))


def beside(first: Array, last: Array) -> Array:
    """blkdiag(first, last), read-only: neither moves under the other's forces."""
    both = np.pad(first, (0, len(last)))
    both[len(first) :, len(first) :] = last
    return read_only(both)


def offset_beside(value: Any, preload: Any, fingers: int, last: Array) -> Array:
    """(n, 3) offsets of all contacts, from those of the fingers, `last` being the environment's, or from all of them.

    value, preload : as in `Grasp`; a preload is the fingers' alone.
    """
    n = fingers + len(last)
    if value is not None and dimensions(value) == 2 and len(value) == n:
        every = array("offset", value, (n, 3))
        value, last = every[:fingers], every[fingers:]
    return read_only(np.concatenate([validate.offset(value, preload, fingers), last]))
