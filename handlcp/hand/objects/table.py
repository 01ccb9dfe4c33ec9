"""A plane that the object rests on or leans against. Its contacts are found by geometry."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, number, read_only, unit
from handlcp.errors import InputError, NotReached
from handlcp.grasp.friction import Coulomb, FrictionLaw, Frictionless, as_law
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.environment import Environment, joined
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.plane_contacts import plane_contacts


class Table:
    """A half-space: a table under the object, a wall beside it. Immutable.

    point : (3,) on its surface [m], world axes. normal : (3,) unit vector out of it, to the object's side.
    friction : a coefficient, `Coulomb(mu)` or `Frictionless()`, of all its contacts; None: 0.5.
    flexibility : [m/N] of each contact, a number or a (3,) diagonal (two tangents, the normal); 0: rigid. On a rigid
        table the forces at four corners are seldom determined, on a flexible one they are.
    max_gap : [m] points of the object that are farther from the plane are no contacts.
    name : prefix of its contacts in reports: "table 1", "table 2", …

    `state.grasp(obj, environment=table)` finds the contacts itself; `table.under(obj)` is for grasps without a hand.
    A planar scene refuses contacts off its plane: pass an `Environment` with those that you mean.
    Raises InputError.
    """

    __slots__ = ("flexibility", "friction", "max_gap", "name", "normal", "point")

    point: Array
    normal: Array
    friction: FrictionLaw
    flexibility: Array
    max_gap: float
    name: str

    def __init__(
        self,
        point: Any,
        normal: Any = (0.0, 0.0, 1.0),
        friction: FrictionLaw | float | None = None,
        flexibility: Any = 0.0,
        max_gap: Any = 1e-3,
        name: str = "table",
    ) -> None:
        law = Coulomb(0.5) if friction is None else as_law(friction)
        if not isinstance(law, (Coulomb, Frictionless)):
            raise InputError("friction", "a coefficient, Coulomb(mu) or Frictionless()", repr(friction))
        if not isinstance(name, str):
            raise InputError("name", "a string", repr(name))
        if dimensions(flexibility) == 0:
            soft = read_only(np.full(3, number("flexibility", flexibility, minimum=0.0)))
        elif ((soft := array("flexibility", flexibility, (3,))) < 0).any():
            raise InputError("flexibility", "entries ≥ 0", soft.tolist())
        object.__setattr__(self, "point", array("point", point, (3,)))
        object.__setattr__(self, "normal", unit("normal", normal, (3,)))
        object.__setattr__(self, "friction", law)
        object.__setattr__(self, "flexibility", soft)
        object.__setattr__(self, "max_gap", number("max_gap", max_gap, minimum=0.0))
        object.__setattr__(self, "name", name)

    def under(self, obj: Object) -> Environment:
        """Its contacts with an object, within `max_gap`: corners of a box, points on a cylinder's rims (eight on the
        rim that it stands on), one point of a ball or an ellipsoid, vertices of a mesh's hull. Of a flat patch the
        corners of its convex hull count. Gaps are measured; an overlap is a negative gap.

        Raises NotReached with the object's distance where nothing is near; InputError for an object behind the plane.
        """
        if not isinstance(obj, Object):
            raise InputError("obj", "an object (Box, Sphere, …)", repr(obj)[:80])
        if (behind := float((self.point - obj.center_of_mass) @ self.normal)) > 0.0:
            expected = f"an object whose centre is on the side of the {self.name} that its normal points to"
            came = f"one {behind * 1e3:.3g} mm behind it: is the normal turned round?"
            raise InputError("environment", expected, came)
        points, gaps, least = plane_contacts(obj, self.point, self.normal, self.max_gap)
        if not len(points):
            expected = f"an object within max_gap = {self.max_gap * 1e3:g} mm of the {self.name}"
            raise NotReached("environment", expected, {self.name: least})
        contacts = [Contact(p, self.normal, self.friction, None, f"{self.name} {k + 1}") for k, p in enumerate(points)]
        return Environment(contacts, self.flexibility, gaps)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Table is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        return (Table, (self.point, self.normal, self.friction, self.flexibility, self.max_gap, self.name))

    def __repr__(self) -> str:
        return f"Table({self.point.tolist()}, normal={self.normal.tolist()}, friction={self.friction!r})"


def surrounding(value: Any, obj: Object | None) -> Environment:
    """The environment meant by an `Environment`, a `Table`, or a sequence of them. Raises InputError, NotReached."""
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
