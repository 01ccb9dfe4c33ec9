"""What a contact may transmit in its tangent plane, per newton of normal force: a disc, a polygon, or an interval."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, TypeAlias

import numpy as np

from handlcp.check import Array, array, integer, read_only
from handlcp.errors import InputError
from handlcp.keywords import helped_init, helped_methods


@helped_init()
@helped_methods
@dataclass(frozen=True, slots=True)
class Pyramid:
    """A pyramid of `faces` ≥ 3 faces in place of the friction cone.

    The outward normal of face j lies at the angle 2πj/m from the contact's x axis towards its y axis.
    inscribed : its edges lie on the cone, so no force leaves the cone; False: its faces touch the cone from outside.
    """

    faces: int
    inscribed: bool = True

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "faces", integer("faces", self.faces, 3, MOST_FACES))
        except InputError:
            expected = f'an integer from 3 to {MOST_FACES}, "cone" or a Pyramid'
            raise InputError("faces", expected, repr(self.faces)[:80]) from None

    @property
    def normals(self) -> Array:
        """(2, m) outward unit normals of the faces in the contact's x, y axes."""
        return _ring(self.faces, 0.0)

    @property
    def edges(self) -> Array:
        """(2, m) tangential force along the edges, as multiples of `limit`."""
        return _ring(self.faces, 0.5) / math.cos(math.pi / self.faces)

    @property
    def share(self) -> float:
        """Distance of the faces from the axis, per newton of normal force and coefficient [-]: cos(π/m), inscribed."""
        return math.cos(math.pi / self.faces) if self.inscribed else 1.0

    def limit(self, mu: Array) -> Array:
        """(n,) the same per newton of normal force [-]."""
        return array("mu", mu) * self.share

    @property
    def name(self) -> str:
        """For reports."""
        return f"{self.faces}-face {'inscribed' if self.inscribed else 'circumscribed'} pyramid"


@dataclass(frozen=True, slots=True)
class Cone:
    """Coulomb's circular cone itself. `faces` = 0 stands for it in compiled code."""

    faces: int = 0

    share: ClassVar[float] = 1.0
    name: ClassVar[str] = "exact cone"


@dataclass(frozen=True, slots=True)
class Interval:
    """The friction cone of a planar contact: two directions, exact. `faces` = 2 stands for it in compiled code."""

    faces: int = 2

    share: ClassVar[float] = 1.0
    name: ClassVar[str] = "planar, exact"


Section: TypeAlias = Pyramid | Cone | Interval

MOST_FACES = 1024  # the pyramid is then within 5e-6 of the cone; the cone itself is cheaper from 8 faces on


@lru_cache(maxsize=256)
def _ring(m: int, shift: float) -> Array:
    a = 2 * np.pi * (np.arange(m) + shift) / m
    ring = np.vstack([np.cos(a), np.sin(a)])
    ring[abs(ring) < 1e-15] = 0.0  # cos(π/2) and its like: an exact zero couples nothing
    return read_only(ring)


_pyramid = lru_cache(maxsize=64)(Pyramid)  # the same few are asked for again and again


def as_section(faces: int | str | Section, planar: bool = False) -> Section:
    """What users pass as `faces`; a planar scene has its own, whatever they pass. Raises InputError."""
    if isinstance(faces, str):
        if faces != "cone":
            raise InputError("faces", 'an integer ≥ 3, "cone" or a Pyramid', repr(faces))
        faces = Cone()
    elif not isinstance(faces, (Pyramid, Cone, Interval)):
        faces = _pyramid(faces) if type(faces) is int else Pyramid(faces)
    return Interval() if planar else faces
