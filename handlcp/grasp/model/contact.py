"""One contact: where, which way the finger pushes, what friction, and the frame its forces are measured in."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array, array, read_only, unit
from handlcp.errors import InputError
from handlcp.grasp.friction import Coulomb, FrictionLaw, as_law
from handlcp.keywords import helped_init, helped_methods


@helped_init()
@helped_methods
class Contact:
    """A contact of a finger on the object.

    Parameters
    ----------
    position : (3,) contact point [m], world axes; (2,) in a planar scene.
    normal : (3,) unit vector into the object, the way the finger pushes; (2,) in a planar scene. It is
        normalised, and refused where its length is off by 1e-3 or more.
    friction : a coefficient, as `Coulomb(mu)` (None: 0.5), `Frictionless()`, `AnisotropicCoulomb(mu_x, mu_y)` or
        `SoftFinger(mu, mu_torsion)`.
    tangent : direction of the contact's x axis, projected on the tangent plane; chosen deterministically when None
        (`along` of the friction, or the world axis nearest to the tangent plane, the first of equals).
    name : what reports call the finger; "finger 1", "finger 2", … when None.

    The contact frame is R = (x, y, z) with z the normal and y = z × x: Pinocchio's contact convention.
    A contact made of 2-vectors lies in the xy plane, with y = (0, 0, 1) and x in the plane.

    Attributes: position (3,), rotation (3, 3), friction, mu, name, planar, and plain: whether the law is a disc in the
    contact's own axes. Immutable by custom. Raises InputError for wrong shapes, numbers not finite, a normal not of
    unit length, a tangent along the normal.
    """

    __slots__ = ("friction", "mu", "name", "plain", "planar", "position", "rotation")

    position: Array
    rotation: Array
    friction: FrictionLaw
    mu: float
    plain: bool
    planar: bool
    name: str | None

    def __init__(
        self,
        position: Any,
        normal: Any,
        friction: FrictionLaw | float | None = None,
        tangent: Any = None,
        name: str | None = None,
    ) -> None:
        law = Coulomb(0.5) if friction is None else as_law(friction)
        if name is not None and not isinstance(name, str):
            raise InputError("name", "a string", repr(name))
        p = array("position", position, (3,), (2,))
        z = unit("normal", normal, (3,), (2,))
        if p.shape != z.shape:
            raise InputError("normal", f"as many components as position, {len(p)}", f"{len(z)}")
        planar = p.shape == (2,)
        tangent = law.x_axis if tangent is None else tangent
        x = None if tangent is None else array("tangent", tangent, p.shape)
        if planar:
            p, z = np.append(p, 0.0), np.append(z, 0.0)
            x = np.cross((0.0, 0.0, 1.0), z) if x is None else np.append(x, 0.0)
        self._take(read_only(p), frame(z, x), law, planar, name)

    def _take(self, position: Array, rotation: Array, friction: FrictionLaw, planar: bool, name: str | None) -> None:
        self.position, self.rotation, self.planar, self.name = position, rotation, planar, name
        self.friction, self.mu, self.plain = friction, friction.mu, friction.plain

    @property
    def normal(self) -> Array:
        """(3,) unit vector into the object, world axes."""
        return self.rotation[:, 2]

    @property
    def tangent(self) -> Array:
        """(3,) the contact's x axis, world axes."""
        return self.rotation[:, 0]

    @classmethod
    def placed(
        cls, position: Array, rotation: Array, friction: FrictionLaw, planar: bool = False, name: str | None = None
    ) -> Contact:
        """A contact of arrays that are known to be sound, read-only: position (3,), rotation (3, 3)."""
        made = object.__new__(cls)
        made._take(position, rotation, friction, planar, name)
        return made

    def with_friction(self, friction: FrictionLaw) -> Contact:
        """The same contact under another law, its axes kept."""
        return self.placed(self.position, self.rotation, friction, self.planar, self.name)

    def moved(self, position: Array, rotation: Array) -> Contact:
        """The same contact with these axes elsewhere: (3,), (3, 3), known to be sound."""
        return self.placed(position, rotation, self.friction, self.planar, self.name)

    def named(self, name: str) -> Contact:
        """The same contact under another name."""
        return (
            self if name == self.name else self.placed(self.position, self.rotation, self.friction, self.planar, name)
        )

    def __repr__(self) -> str:
        name = f"{self.name!r}, " if self.name else ""
        where = f"position={self.position.tolist()}, normal={self.normal.tolist()}"
        return f"Contact({name}{where}, friction={self.friction!r})"


def frame(normal: Array, tangent: Array | None = None) -> Array:
    """(3, 3) rotation with columns x, y, z for a unit `normal` = z; x is `tangent` projected on the tangent plane."""
    if tangent is None:
        tangent = np.eye(3)[int(np.argmin(np.round(abs(normal), 9)))]
    x = tangent - normal * (normal @ tangent)
    length = float(np.sqrt(x @ x))
    if length <= 1e-6 * float(np.sqrt(tangent @ tangent)):
        got = f"{tangent.tolist()} for normal {normal.tolist()}"
        raise InputError("tangent", "a direction that is not along the normal", got)
    x /= length
    # y = z × x, written out: numpy's cross product costs more than all the rest
    (a, b, c), (d, e, f) = normal, x
    return read_only(np.array([[d, b * f - c * e, a], [e, c * d - a * f, b], [f, a * e - b * d, c]]))
