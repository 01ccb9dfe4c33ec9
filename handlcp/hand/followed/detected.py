"""Contacts of shapes that are detected: where they are, and how they turn and shift as a fingertip moves.

How follows from differences between detections a small step to either side. Two things jump between these. Where edges
or faces lie flush the nearest point jumps from one corner to another: `flush`. Where the contact comes to a sharp edge
its normal jumps. There it turns along a radius of 3 mm instead, as what bears on an edge has a pad: a turn that is
sharper than what the fingers can follow has no step that leads on.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.grasp.model.kind import cross_rows
from handlcp.grasp.path.newton.tangent import skew
from handlcp.hand.followed.flush import Flush, flush
from handlcp.hand.objects.corner import corner_contact
from handlcp.hand.objects.detect import Proximity, nearest, nearest_beside
from handlcp.hand.objects.object import Object

_STEP = 2e-3  # of the object's size: differences of detected contacts, whose points are good to a millionth or less
_SHARPEST = 300.0  # [1/m] how fast a normal turns at an edge at most
# Of an edge's normals on either side: they differ by this much, or from the one between them by this share more on one
# side than on the other
_EDGE, _UNEVEN = 0.3, 0.5


class _Seen(NamedTuple):
    """A fingertip that was detected: where it stood, its contact, and how that turns and shifts (3, 6). flush : None
    where it touches at a point.
    """

    at: Array
    own: Array
    near: Proximity
    turn: Array
    shift: Array
    flush: Flush | None

    def moved(self, by: Array) -> tuple[Array, Array, float, Array]:
        """Position and normal (3,), gap, and shift (3, 6) of the contact, once the fingertip has moved by (6,)."""
        near, shift = self.near, self.shift
        normal = near.normal + self.turn @ by
        normal /= np.linalg.norm(normal)
        if self.flush is None:
            moved = by[:3] + np.cross(by[3:], near.position - self.at)
            return near.position + shift @ by, normal, float(near.gap - near.normal @ moved), shift
        pressed, gap, along = self.flush.at(by)
        shift = self.flush.across @ shift
        return pressed + shift @ by, normal, gap, shift + along


class Detected:
    """Shapes that are detected, in the axes of the object where it was at the start: fingertips are moved back instead
    of the object. A fingertip that has moved by less than the steps of the differences since it was detected takes its
    contact along as they say: where an edge lies along the object, detection finds one of its ends or the other, and
    no step would converge.
    """

    noise = 1e-8

    def __init__(self, obj: Object, shapes: list[Any]) -> None:
        self.obj, self.shapes = obj, shapes
        self.step = _STEP * float(np.cbrt(obj.volume)) if obj.volume > 0.0 else _STEP * 0.05
        self.size = self.step / _STEP
        self.known = dict[int, _Seen]()

    def __call__(
        self, places: Array, turns: Array, R: Array, t: Array, out: tuple[Array, Array, Array, Array, Array]
    ) -> None:
        """See `Find`."""
        positions, normals, gaps, turn, shift = out
        for i, tip in enumerate(self.shapes):
            if tip[0].corner is not None:
                (Q, q), face = self.obj.frame, tip[0].face
                positions[i] = R @ (Q @ tip[0].corner + q) + t
                gaps[i] = corner_contact(
                    positions[i], places[i], turns[i], face.centre, face.spans, face.radius, normals[i], turn[i],
                    shift[i],
                )  # fmt: skip
                continue
            at, own = R.T @ (places[i] - t), R.T @ turns[i]
            known = self.known.get(i)
            if known is None or self._far(at, own, known) > self.step:
                known = self.known[i] = self._seen(tip, at, own)
            by = np.concatenate([at - known.at, pin.log3(own @ known.own.T)])
            position, normal, gaps[i], shifts = known.moved(by)
            positions[i], normals[i] = R @ position + t, R @ normal
            for rows, of in ((turn, known.turn), (shift, shifts)):
                rows[i, :, :3], rows[i, :, 3:] = R @ of[:, :3] @ R.T, R @ of[:, 3:] @ R.T

    def _far(self, at: Array, own: Array, known: _Seen) -> float:
        """How far a fingertip has moved [m]."""
        return float(np.linalg.norm(at - known.at) + self.size * np.linalg.norm(own - known.own))

    def _seen(self, tip: Any, at: Array, own: Array) -> _Seen:
        """A fingertip where it is, in the object's axes."""
        near, ends = nearest(tip, at, own, self.obj), list[tuple[Proximity, Proximity]]()
        for a in range(6):
            by = np.zeros(3)
            by[a % 3] = self.step / (1.0 if a < 3 else self.size)
            ends.append((self._moved(tip, at, own, near, by, a >= 3), self._moved(tip, at, own, near, -by, a >= 3)))
        steps = 2.0 * self.step * np.array([1.0] * 3 + [1.0 / self.size] * 3)
        turn = np.stack([some.normal - other.normal for some, other in ends], axis=1) / steps
        shift = np.stack([some.position - other.position for some, other in ends], axis=1) / steps
        if any(_edge(some.normal, near.normal, other.normal) for some, other in ends[:3]):
            turn = _blunted(turn, near.position - at)
        farthest = max(float(abs(one.position - near.position).max()) for pair in ends[3:] for one in pair)
        jumps = farthest > self.step  # on a curved surface, by its radius times the tilt, which is less
        lies = flush(tip, at, own, near, self.obj, 2.0 * self.step) if jumps else None
        return _Seen(at, own, near, turn, shift, lies)

    def _moved(self, tip: Any, at: Array, own: Array, near: Proximity, by: Array, turns: bool) -> Proximity:
        moved = cross_rows(by, near.tip_point - at) if turns else by
        at, own = (at, pin.exp3(by) @ own) if turns else (at + by, own)
        if len(tip) > 1:
            return nearest(tip, at, own, self.obj)
        return nearest_beside(tip[0], at, own, self.obj, near.gap - float(near.normal @ moved), self.step)


def _edge(some: Array, between: Array, other: Array) -> bool:
    """Whether normals (3,) on either side of a contact are those of an edge, not of a curved surface."""
    apart = float(np.linalg.norm(some - other))
    return apart > _EDGE or float(np.linalg.norm(some + other - 2.0 * between)) > _UNEVEN * apart > 1e-3 * _EDGE


def _blunted(turn: Array, arm: Array) -> Array:
    """The turn (3, 6) of an edge's normal, no faster than `_SHARPEST`, of a contact `arm` (3,) away from the place that
    the fingertip turns about.
    """
    fastest = float(np.linalg.norm(turn[:, :3], 2))
    if fastest <= _SHARPEST:
        return turn
    along = _SHARPEST / fastest * turn[:, :3]
    own = turn[:, 3:] + turn[:, :3] @ skew(arm)  # the contact moves by v + ω × arm; beside that it turns with a body
    own *= min(1.0, 1.0 / float(np.linalg.norm(own, 2)))
    return np.hstack([along, own - along @ skew(arm)])
