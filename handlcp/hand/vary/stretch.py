"""A length between two joints, or a joint and its fingertip, made another: what becomes of all that is on the way.

    t' = t,  t < 0;    t' = t s,  0 ≤ t ≤ L;    t' = t + (s - 1) L,  t > L,    s = L'/L

with t along the line from the joint to the end, L long before. What is on the way becomes longer or shorter along this
line, what is beyond the end moves along as it is, and what is behind the joint stays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array

_ALONG = 0.996  # cosine of 5°: an edge or axis that is no farther off the line runs along it
_END = 1e-9  # of the length: a link that begins so close to the end is beyond it


@dataclass(frozen=True, slots=True)
class Stretch:
    """direction (3,) : of the line, a unit vector. before, after : the lengths L, L' [m]. start : t of the origin of
    the frame in which direction and points are given [m]; 0 in that of the joint.
    """

    direction: Array
    before: float
    after: float
    start: float = 0.0

    def in_link(self, placement: Any) -> Stretch | None:
        """In the frame of a link, whose placement in this one's frame is given; None beyond the end, where all of the
        link stays as it is in its frame.
        """
        t = self.start + float(self.direction @ placement.translation)
        if t >= self.before * (1.0 - _END):
            return None
        return Stretch(placement.rotation.T @ self.direction, self.before, self.after, t)

    def point(self, x: Array) -> Array:
        """(3,) where the point x (3,) comes to be in the frame, which moves itself."""
        return x + self.direction * (self._by(self.start + float(self.direction @ x)) - self._by(self.start))

    def solid(self, rotation: Array, position: Array, sizes: Array) -> tuple[Array, Array]:
        """Position (3,) and sizes (3,) [m] of a solid about its position, with these sizes along its axes: the columns
        of rotation (3, 3). Only along an axis that runs along the line can it become longer.
        """
        k, cosine = self._axis(rotation)
        if cosine < _ALONG:
            return self.point(position), sizes
        t, half = self.start + float(self.direction @ position), 0.5 * cosine * float(sizes[k])
        low, high = self._by(t - half), self._by(t + half)
        made = np.array(sizes, dtype=float)
        made[k] += (high - low) / cosine
        return position + self.direction * (0.5 * (low + high) - self._by(self.start)), made

    def mesh(self, rotation: Array, position: Array, scale: Array) -> tuple[Array, Array] | None:
        """Position (3,) and scale (3,) of a mesh, which becomes longer by L'/L everywhere; None where none of its axes
        runs along the line.
        """
        k, cosine = self._axis(rotation)
        if cosine < _ALONG:
            return None
        made, more = np.array(scale, dtype=float), self.after / self.before
        made[k] *= more
        t = self.start + float(self.direction @ position)
        return position + self.direction * ((more - 1.0) * t - self._by(self.start)), made

    def _axis(self, rotation: Array) -> tuple[int, float]:
        """Which column is nearest to the line, and the cosine of the angle between them."""
        cosines = abs(rotation.T @ self.direction)
        k = int(cosines.argmax())
        return k, min(float(cosines[k]), 1.0)

    def _by(self, t: float) -> float:
        """T' - t [m]."""
        return (self.after - self.before) * min(max(t / self.before, 0.0), 1.0)
