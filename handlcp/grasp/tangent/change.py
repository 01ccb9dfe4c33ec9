"""What parameters change in the laws of a grasp while forces and motion stay, and what an answer does about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.tangent.answer import Answer


@dataclass(frozen=True, eq=False)
class Change:
    """By p parameters, SI, each (…, p). Contacts' motions in the coordinates of the friction laws.

    motion (c, p) : δv, of the object relative to the tips [m]. balance (6, p) : δb, of the wrench that is left over,
    about the reference. friction (n, p) : δμ of the coefficients of the sections (`Scene.limits`) [-].
    torque (nv, p) : of what the joints hold [N·m].
    torque_limits (nv, p) : of the joints' limits [N·m]. deeper : what comes on top where fingertips go deeper into an
    object that they just touch; None: nothing does.
    """

    motion: Array
    balance: Array
    friction: Array
    torque: Array
    torque_limits: Array
    deeper: Deeper | None = None

    def toward(self, direction: Array) -> Change:
        """(…, 1) along a direction (p,)."""
        straight = _of([(part @ direction)[:, None] for part in self._parts])
        if self.deeper is None:
            return straight
        return replace(straight, deeper=self.deeper.by(self.deeper.rates @ direction[:, None])).ahead

    @property
    def ahead(self) -> Change:
        """Of parameters that grow, one at a time."""
        if self.deeper is None:
            return self
        depth = np.maximum(self.deeper.rates, 0.0)
        pairs = zip(self._parts, self.deeper.change._parts, strict=True)
        return _of([part + more @ depth for part, more in pairs])

    def some(self, which: Bools) -> Change:
        """Of these (p,) of the parameters."""
        return _of([part[:, which] for part in self._parts])

    def bent_at(self, touches: Bools) -> Change:
        """Where only these (t,) of the fingertips in `deeper` just touch: the others are inside already, and what takes
        them deeper counts on both sides.
        """
        if self.deeper is None:
            return self
        rates, more = self.deeper.rates, self.deeper.change._parts
        already = np.where(touches[:, None], 0.0, rates)
        straight = [part + of @ already for part, of in zip(self._parts, more, strict=True)]
        left = Deeper(self.deeper.contacts[touches], rates[touches], self.deeper.change.some(touches))
        return replace(_of(straight), deeper=left if touches.any() else None)

    @property
    def _parts(self) -> tuple[Array, ...]:
        return self.motion, self.balance, self.friction, self.torque, self.torque_limits


def _of(parts: Sequence[Array]) -> Change:
    motion, balance, friction, torque, torque_limits = parts
    return Change(motion, balance, friction, torque, torque_limits)


@dataclass(frozen=True, eq=False)
class Deeper:
    """Fingertips that just touch the object they were detected on. One that goes deeper counts as squeezed, and its
    joints take it sideways; one that leaves a gap does not.

    contacts (t,) : their numbers. rates (t, p) : how fast p parameters take them deeper [m]. change : by depth
    (…, t) [1/m].
    """

    contacts: Ints
    rates: Array
    change: Change

    def by(self, rates: Array) -> Deeper:
        """With other parameters."""
        return replace(self, rates=rates)


def no_change(answer: Answer, p: int) -> Change:
    """Of p parameters that change nothing: a place to write to."""
    scene, nv = answer.scene, answer.rows.shape[1]
    sizes = (scene.components, 6, scene.n, nv, nv)
    return _of([np.zeros((size, p)) for size in sizes])


def in_plane(answer: Answer, change: Change) -> Change:
    """In a planar scene nothing moves across the plane."""
    if answer.spec.planar:
        change.motion[1 : 3 * answer.scene.n : 3] = 0.0
    return change


class Rates(NamedTuple):
    """What p parameters do to an answer, SI, each (…, p). forces (c, p) in contact axes, moments of soft contacts last;
    motion (6, p) of the object about the reference; slip (c, p) of v, contact axes. NaN where it is not determined.
    """

    forces: Array
    motion: Array
    slip: Array
