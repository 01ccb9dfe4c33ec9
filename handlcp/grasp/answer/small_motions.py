"""How far an answer goes beyond the equations of small motions, and by how much its forces may be off.

    share = max(turn, move / R, slip / R, squeeze / 10R, yield / 2)

A contact that shifts by δ over a surface of radius R turns its normal by δ / R, and an object that turns by ω turns all
its contacts by ω. Forces turn with them, by that share of their size. R is the distance of the contacts from their
centre, which is the radius of a ball, and about that of other objects. The fingers give way to a squeeze, and the tips
stay: it bends fingers that are several times as long as R. A joint that yields at its torque limit changes levers by
half its angle or less.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words

NOTICED = 0.05  # of the forces: what may be off by more is said
TOO_LARGE = 1.0  # of the forces: beyond this the equations say nothing


@dataclass(frozen=True, slots=True)
class Motions:
    """move : of the object's contact points, at most [m]. turn [rad]. slip, squeeze : the largest [m]. size : R [m].
    yielded : the largest, of a joint at its torque limit [rad].
    """

    move: float
    turn: float
    slip: float
    squeeze: float
    size: float
    yielded: float = 0.0

    @property
    def share(self) -> float:
        """By how much forces may be off, of their size."""
        return max(
            self.turn, self.move / self.size, self.slip / self.size, 0.1 * self.squeeze / self.size, 0.5 * self.yielded
        )

    @property
    def too_large(self) -> bool:
        """Whether the equations of small motions say nothing."""
        return self.share >= TOO_LARGE

    @property
    def sentence(self) -> str:
        """What is large, and what that means for the forces; "" where nothing is."""
        parts = []
        if max(self.turn, self.move / self.size) > NOTICED:
            parts.append(f"the object moves {words.length(self.move)} and turns {words.angle(self.turn)}")
        if self.slip > NOTICED * self.size:
            parts.append(f"a contact slips {words.length(self.slip)}")
        if 0.1 * self.squeeze > NOTICED * self.size:
            parts.append(f"the fingers squeeze by {words.length(self.squeeze)}")
        if 0.5 * self.yielded > NOTICED:
            parts.append(f"a joint yields by {words.angle(self.yielded)}")
        if not parts:
            return ""
        if self.too_large:
            return f"{', '.join(parts)}: the equations of small motions say nothing about that"
        return f"{', '.join(parts)}: the equations are of small motions, and forces may be off by {_about(self.share)}"


def motions(s: Any) -> Motions:
    """Of a `GraspSolution` with an answer."""
    n, size = s.scene.n, s.scene.units.length
    shift, turn = (float(np.linalg.norm(part)) for part in (s.object_displacement[:3], s.object_displacement[3:]))
    squeeze = -float(s.scene.lawful(s.scene.offset)[2 : 3 * n : 3].min(initial=0.0))
    slip, yielded = float(np.hypot(*s.slip.T).max(initial=0.0)), getattr(s, "joint_yield", np.zeros(1))
    return Motions(max(shift, turn * size), turn, slip, squeeze, size, float(abs(yielded).max(initial=0.0)))


def _about(share: float) -> str:
    return f"about {words.percent(share)}"
