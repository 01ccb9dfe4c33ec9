"""A plane that the object rests on or leans against, whose contacts are found by geometry."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, number, read_only, unit
from handlcp.errors import InputError, NotReached
from handlcp.grasp.contact import Contact
from handlcp.grasp.environment import Environment, joined
from handlcp.grasp.friction import Coulomb, Friction, Frictionless
from handlcp.hand.objects import Object
from handlcp.hand.patch import patch

__all__ = ["Table", "surrounding"]


class Table:
    """A half-space: a table under the object, a wall beside it. Immutable.

    point : (3,) of its surface [m], world axes. normal : (3,) unit vector out of it, to the object's side.
    friction : `Coulomb(mu)` or `Frictionless()`, of all its contacts; None: Coulomb(0.5).
    flexibility : [m/N] of each contact, a number or a (3,) diagonal (two tangents, the normal); 0: rigid. Forces at
        four corners on a rigid table are seldom determined, and those on a flexible one are.
    max_gap : [m] the farthest a point of the object may be from the plane and still count as near enough to touch.
    name : what reports call its contacts: "table 1", "table 2", …

    `state.grasp(obj, environment=table)` finds the contacts itself; `table.under(obj)` is for grasps without a hand.
    Points that it finds off the plane of a planar scene are refused there: an `Environment` says which are meant.
    Raises InputError.
    """

    __slots__ = ("flexibility", "friction", "max_gap", "name", "normal", "point")

    point: Array
    normal: Array
    friction: Friction
    flexibility: Array
    max_gap: float
    name: str

    def __init__(
        self,
        point: Any,
        normal: Any = (0.0, 0.0, 1.0),
        friction: Friction | None = None,
        flexibility: Any = 0.0,
        max_gap: Any = 1e-3,
        name: str = "table",
    ) -> None:
        law = Coulomb(0.5) if friction is None else friction
        if not isinstance(law, (Coulomb, Frictionless)):
            raise InputError("friction", "Coulomb(mu) or Frictionless()", repr(friction))
        if not isinstance(name, str):
            raise InputError("name", "a string", repr(name))
        if dimensions(flexibility) == 0:
            soft = read_only(np.full(3, number("flexibility", flexibility, minimum=0.0)))
        elif ((soft := array("flexibility", flexibility, (3,))) < 0).any():
            raise InputError("flexibility", "entries ≥ 0", soft.tolist())
        values = {
            "point": array("point", point, (3,)), "normal": unit("normal", normal, (3,)), "friction": law,
            "flexibility": soft, "max_gap": number("max_gap", max_gap, minimum=0.0), "name": name,
        }  # fmt: skip
        for key, value in values.items():
            object.__setattr__(self, key, value)

    def under(self, obj: Object) -> Environment:
        """Its contacts with an object: the corners of a box, the points of a cylinder's rims (eight of one that it
        stands on), one point of a ball or an ellipsoid, the vertices of a mesh's hull, as far as they are within
        `max_gap`; of a flat patch its convex hull. Gaps are measured; an overlap is a squeeze.

        Raises NotReached, which says how far the object is, where there is none; InputError for an object behind it.
        """
        if not isinstance(obj, Object):
            raise InputError("obj", "an object (Box, Sphere, …)", repr(obj)[:80])
        if (behind := float((self.point - obj.center_of_mass) @ self.normal)) > 0.0:
            expected = f"an object whose centre is on the side of the {self.name} that its normal points to"
            raise InputError(
                "environment", expected, f"one {behind * 1e3:.3g} mm behind it: is the normal turned round?"
            )
        points, gaps, least = patch(obj, self.point, self.normal, self.max_gap)
        if not len(points):
            expected = f"an object within max_gap = {self.max_gap * 1e3:g} mm of the {self.name}"
            raise NotReached("environment", expected, {self.name: least})
        contacts = [Contact(p, self.normal, self.friction, None, f"{self.name} {k + 1}") for k, p in enumerate(points)]
        return Environment(contacts, self.flexibility, gaps)

    def __setattr__(self, name: str, value: object) -> None:
        """Everything is set once."""
        raise AttributeError(f"a Table is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as the call that made it."""
        return (Table, (self.point, self.normal, self.friction, self.flexibility, self.max_gap, self.name))

    def __repr__(self) -> str:
        """The call, roughly."""
        return f"Table({self.point.tolist()}, normal={self.normal.tolist()}, friction={self.friction!r})"


def surrounding(value: Any, obj: Object | None) -> Environment:
    """One environment of what `state.grasp(obj, environment=...)` takes: an `Environment`, a `Table`, or several."""
    if isinstance(value, (str, bytes)) or not isinstance(value, (Environment, Table, Iterable)):
        raise InputError("environment", "a Table, an Environment, or a sequence of them", repr(value)[:80])
    parts = []
    for k, part in enumerate([value] if isinstance(value, (Environment, Table)) else value):
        if isinstance(part, Table):
            if obj is None:
                expected = "an Environment where contacts are given: a Table finds its contacts with an object"
                raise InputError("environment", expected, repr(part)[:80])
            part = part.under(obj)
        elif not isinstance(part, Environment):
            raise InputError(f"environment[{k}]", "a Table or an Environment", repr(part)[:80])
        parts.append(part)
    return joined(parts)
