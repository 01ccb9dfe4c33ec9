"""Moments and turns as arcs about their axes, with a head at the end that shows their sense."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.contact import frame
from handlcp.show.picture.camera import Camera

_OPEN = 0.42  # cosine between the axis and the line of sight from which on an arc looks like one
_LEAST, _MOST = 110.0, 290.0  # [degrees] of an arc
_POINTS = 60


@dataclass(frozen=True, slots=True)
class Turn:
    """centre (3,) [m], axis (3,) unit, in the sense of a right-hand screw. radius [m]. share : of the largest moment
    that is drawn in this way, from 0 to 1, which is the arc's length.
    """

    centre: Array
    axis: Array
    radius: float
    share: float = 1.0

    def reach(self) -> Array:
        """(k, 3) points around everything that an arc can cover."""
        return np.asarray(self.centre + self.radius * np.vstack([np.eye(3), -np.eye(3)]))

    def arc(self, camera: Camera) -> Array:
        """(k, 2) points on the screen, the last one at the head.

        An axis that lies across the line of sight would make the arc a line: it is tilted towards or away from the
        viewer until the arc is open, which keeps its sense.
        """
        sight = camera.axes[2]
        along = float(self.axis @ sight)
        axis = self.axis
        if abs(along) < _OPEN:
            across = axis - along * sight
            across /= np.linalg.norm(across)
            axis = np.sqrt(1 - _OPEN**2) * across + (_OPEN if along >= 0 else -_OPEN) * sight
        x, y, _ = frame(axis, camera.axes[0] if abs(axis @ camera.axes[0]) < 0.9 else camera.axes[1]).T
        sweep = np.radians(_LEAST + (_MOST - _LEAST) * self.share)
        a = np.pi / 2 + np.linspace(-sweep / 2, sweep / 2, _POINTS)
        points = self.centre + self.radius * (np.cos(a)[:, None] * x + np.sin(a)[:, None] * y)
        return camera.project(points)
