"""`Cone`, `Pyramid`, `LimitSet`: what a contact may transmit along its tangents for a newton of normal force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, TypeAlias

import numpy as np

from handlcp.check import Array, check_array, check_init_call, check_integer, check_method_calls, read_only
from handlcp.errors import InputError
from handlcp.lcp.contact_problem import ring_vectors


@check_init_call()
@check_method_calls
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
            object.__setattr__(self, "faces", check_integer("faces", self.faces, 3, MOST_FACES))
        except InputError:
            expected = f'an integer from 3 to {MOST_FACES}, "cone" or a Pyramid'
            raise InputError("faces", expected, repr(self.faces)[:80]) from None

    @property
    def normals(self) -> Array:
        """(2, m) outward unit normals of the faces in the contact's x, y axes."""
        return ring_vectors(self.faces, 0.0)

    @property
    def edges(self) -> Array:
        """(2, m) tangential force along the edges, as multiples of `limit`."""
        return ring_vectors(self.faces, 0.5) / math.cos(math.pi / self.faces)

    @property
    def share(self) -> float:
        """Distance of the faces from the axis, per newton of normal force and coefficient [-]: cos(π/m), inscribed."""
        return math.cos(math.pi / self.faces) if self.inscribed else 1.0

    def limit(self, mu: Array) -> Array:
        """(n,) the same per newton of normal force [-]."""
        return check_array("mu", mu) * self.share

    @property
    def name(self) -> str:
        """The section's name in reports, such as "8-face inscribed pyramid"."""
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


# ----------------------------------------------------------------
# What a contact may transmit along its tangents, per newton of normal force, in the coordinates of its law.
#
# A law is a ball in one, two or three tangents (x, y, moment over lever). A section takes it as it is, or puts a set
# with flat faces nᵀ y ≤ 1 in its place:
#
#     tangents   cone   pyramid of m faces                                   interval
#     1          –      –                                                    both ends, exact
#     2          disc   regular polygon, normals at 2πj/m                    –
#     3          ball   polyhedron with a normal n at every meeting of m     –
#                       meridians and the parallels between them
#
#     n = (cos φ cos α, cos φ sin α, sin φ),    α = 2πj/m,  φ = (π/2) l/k,  |l| ≤ k = max(1, round(m/4))
#
# Along the equator the meridians are the faces of the polygon. By symmetry the polyhedron's vertices lie halfway
# between meridians, where two neighbouring parallels' planes meet. Source: Howe & Cutkosky, Int. J. Robotics Research
# 15 (1996), the ellipsoid, here in (r_T, r_τ / lever).


_CIRCUMSCRIBED_DISC = Pyramid(64, inscribed=False)  # stands for the disc; its edges lie outside by 0.12 %
_BALL_MERIDIANS = 24  # of the polyhedron that stands for the ball


@dataclass(frozen=True, slots=True, eq=False)
class LimitSet:
    """The set for one coefficient of friction.

    normals : (d, f) outward unit normals of the faces. vertices : (d, p) corners of the set whose faces touch the unit
    ball. share : of the coefficient, at which the faces lie (1: they touch the ball; less: the vertices do). The set of
    the cone is the ball itself; normals and vertices are then those of a set around it, for statements that are linear
    programs: what lies outside that lies outside the ball.
    """

    normals: Array
    vertices: Array
    share: float


@lru_cache(maxsize=64)
def limit_set(section: Section, tangent_count: int) -> LimitSet:
    """Of contacts with so many tangents; an interval has one."""
    if tangent_count == 1 or isinstance(section, Interval):
        ends = read_only(np.array([[1.0, -1.0]]))
        return LimitSet(ends, ends, 1.0)
    if tangent_count == 2:
        polygon = _CIRCUMSCRIBED_DISC if isinstance(section, Cone) else section
        return LimitSet(polygon.normals, polygon.edges, polygon.share)
    normals, vertices = _polyhedron(section.faces or _BALL_MERIDIANS)
    reach = float(np.sqrt((vertices**2).sum(axis=0)).max())
    return LimitSet(read_only(normals), read_only(vertices), 1.0 / reach if section.share < 1.0 else 1.0)


def _polyhedron(m: int) -> tuple[Array, Array]:
    """The polyhedron about a ball with m meridians: its normals (3, f) and vertices (3, p)."""
    k = max(1, round(m / 4))
    meridian, parallel = 2 * np.pi * np.arange(m) / m, 0.5 * np.pi * np.arange(-k + 1, k) / k
    rings = [[np.cos(p) * np.cos(meridian), np.cos(p) * np.sin(meridian), np.full(m, np.sin(p))] for p in parallel]
    poles = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, -1.0]])
    normals = np.hstack([*(np.array(r) for r in rings), poles])
    normals[abs(normals) < 1e-15] = 0.0
    between, corners = meridian + np.pi / m, []
    for low, high in zip(*(0.5 * np.pi * np.arange(a, a + k) / k for a in (0, 1)), strict=True):
        # nᵀ y = 1 on both parallels, in the plane halfway between two meridians
        planes = np.array([[np.cos(p) * np.cos(np.pi / m), np.sin(p)] for p in (low, high)])
        a, b = np.linalg.solve(planes, np.ones(2))
        for side in (b, -b):
            corners.append(np.array([a * np.cos(between), a * np.sin(between), np.full(m, side)]))
    return normals, np.hstack(corners)
