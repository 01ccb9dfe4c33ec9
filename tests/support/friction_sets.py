"""What a contact may transmit in its tangents, per newton of normal force: convex sets around zero, one class a law.

Written for the second opinion in `laws` and sharing nothing with the package. Points and directions are in the law's
coordinates, in which ellipses are circles and ellipsoids balls: two of them, or three with the moment over its lever.

    nearest(y, push)   the point nearest to y of the set that a normal force `push` allows; below zero it allows nothing
    most(d, push)      the most that a point of it has along d: what the work of friction against a slip -d has to be
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, tan
from typing import Protocol

import numpy as np
from scipy.optimize import nnls
from scipy.spatial import ConvexHull, HalfspaceIntersection


class Set(Protocol):
    """Any of them."""

    def nearest(self, y, push):
        """See above."""

    def most(self, d, push):
        """See above."""


@dataclass(frozen=True)
class Smooth:
    """No friction: nothing but zero."""

    def nearest(self, y, push):
        return np.zeros(len(y))

    def most(self, d, push):
        return 0.0


@dataclass(frozen=True)
class Interval:
    """In a plane: along x, as far as mu."""

    mu: float

    def nearest(self, y, push):
        most, out = self.mu * max(push, 0.0), np.zeros(len(y))
        out[0] = min(max(y[0], -most), most)
        return out

    def most(self, d, push):
        return self.mu * max(push, 0.0) * abs(d[0])


@dataclass(frozen=True)
class Ball:
    """Of radius mu: a disc of two tangents, a ball of two and a moment."""

    mu: float

    def nearest(self, y, push):
        radius, size = self.mu * max(push, 0.0), float(np.linalg.norm(y))
        return y if size <= radius else y * (radius / size)

    def most(self, d, push):
        return self.mu * max(push, 0.0) * float(np.linalg.norm(d))


@dataclass(frozen=True)
class Polygon:
    """Of so many sides, the normal of the first along x, at this distance from zero."""

    distance: float
    sides: int

    def nearest(self, y, push):
        """Among the point itself, if inside, and its nearest points on all sides, one after the other."""
        radius = self.distance * max(push, 0.0)
        a = 2 * pi * np.arange(self.sides) / self.sides
        out = np.column_stack([np.cos(a), np.sin(a)])
        if (out @ y <= radius).all():
            return y
        along, half = np.column_stack([-out[:, 1], out[:, 0]]), radius * tan(pi / self.sides)
        feet = radius * out + np.clip(along @ y, -half, half)[:, None] * along
        return feet[np.argmin(((feet - y) ** 2).sum(1))]

    def most(self, d, push):
        return self.distance * max(push, 0.0) * float((corners(self.sides) @ d).max())


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """With unit normals (f, 3) of its faces, all at this distance from zero, and corners (p, 3)."""

    normals: np.ndarray
    distance: float
    corners: np.ndarray

    def nearest(self, y, push):
        """By the shortest way into all faces, which Lawson and Hanson find by nonnegative least squares."""
        if push <= 0.0:
            return np.zeros(3)
        over = self.normals @ y - self.distance * push
        if (over <= 0).all():
            return y
        E = np.vstack([-self.normals.T, over])
        rest = E @ nnls(E, np.r_[0.0, 0.0, 0.0, 1.0])[0] - [0.0, 0.0, 0.0, 1.0]
        return y - rest[:3] / rest[3]

    def most(self, d, push):
        return max(push, 0.0) * float((self.corners @ d).max())


def corners(sides):
    """(m, 2) corners of the polygon whose sides are at distance one, the first side's normal along x."""
    a = 2 * pi * (np.arange(sides) + 0.5) / sides
    return np.column_stack([np.cos(a), np.sin(a)]) / cos(pi / sides)


def reach(mu, faces):
    """Distance of the sides of an inscribed polygon from the axis, per newton of normal force."""
    return mu * cos(pi / faces) if isinstance(faces, int) and faces > 2 else mu


def polyhedron(mu, faces):
    """Inscribed in the ball of radius mu: two poles, and as many faces on each parallel as a quarter turn asks for."""
    a, k = 2 * pi * np.arange(faces) / faces, max(1, round(faces / 4))
    normals = [[0, 0, 1.0], [0, 0, -1.0]]
    for phi in 0.5 * pi * np.arange(-k + 1, k) / k:
        normals += [[cos(phi) * np.cos(t), cos(phi) * np.sin(t), np.sin(phi)] for t in a]
    normals = np.array(normals)
    V = HalfspaceIntersection(np.column_stack([normals, -np.ones(len(normals))]), np.zeros(3)).intersections
    V = V[ConvexHull(V).vertices]
    share = mu / np.linalg.norm(V, axis=1).max()
    return Polyhedron(normals, share, V * share)


def limit(mu, faces, moment=False):
    """Of a coefficient with so many faces, "cone" for all of them, 2 in a plane; with a moment for soft fingers."""
    if mu == 0.0:
        return Smooth()
    if faces == 2:
        return Interval(mu)
    if faces == "cone":
        return Ball(mu)
    return polyhedron(mu, faces) if moment else Polygon(reach(mu, faces), faces)
