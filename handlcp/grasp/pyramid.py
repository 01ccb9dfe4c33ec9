"""Pyramids for friction cones: how many faces, inside or around."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError, Unsupported

__all__ = ["Pyramid", "as_pyramid"]


@dataclass(frozen=True, slots=True)
class Pyramid:
    """A pyramid of `faces` ≥ 3 faces in place of the friction cone.

    The outward normal of face j lies at the angle 2πj/m from the contact's x axis towards its y axis.
    inscribed : its edges lie on the cone, so no force leaves the cone; False: its faces touch the cone from outside.
    """

    faces: int
    inscribed: bool = True

    def __post_init__(self) -> None:
        """Check the number of faces."""
        if isinstance(self.faces, bool) or not isinstance(self.faces, (int, np.integer)) or self.faces < 3:
            raise InputError("faces", "an integer ≥ 3", repr(self.faces))

    @property
    def normals(self) -> Array:
        """(2, m) outward unit normals of the faces in the contact's x, y axes."""
        return _normals(int(self.faces))

    def limit(self, mu: Array) -> Array:
        """(n,) distance of the faces from the axis, per newton of normal force [-]."""
        return mu * math.cos(math.pi / self.faces) if self.inscribed else mu

    @property
    def name(self) -> str:
        """For reports."""
        return f"{self.faces}-face {'inscribed' if self.inscribed else 'circumscribed'} pyramid"


@lru_cache(maxsize=256)
def _normals(m: int) -> Array:
    a = 2 * np.pi * np.arange(m) / m
    normals = np.vstack([np.cos(a), np.sin(a)])
    normals[abs(normals) < 1e-15] = 0.0  # cos(π/2) and its like: an exact zero couples nothing
    return read_only(normals)


def as_pyramid(faces: int | str | Pyramid) -> Pyramid:
    """What users pass as `faces`. Raises InputError, and Unsupported for the exact cone."""
    if isinstance(faces, Pyramid):
        return faces
    if isinstance(faces, str):
        if faces == "cone":
            raise Unsupported('faces="cone": this version solves pyramids only; 16 faces are within 2 % of the cone')
        raise InputError("faces", "an integer ≥ 3 or a Pyramid", repr(faces))
    return Pyramid(faces)
