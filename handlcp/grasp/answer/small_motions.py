"""How far an answer goes beyond the equations of small motions, and by how much its forces may be off.

share = max(turn, move / R, slip / R, squeeze / 10R, yield / 2)

A contact that shifts by δ over a surface of radius R turns its normal by δ / R, and an object that turns by ω turns all
its contacts by ω. Forces turn with them, by that share of their size. R is the distance of the contacts from their
centre, which is the radius of a ball, and about that of other objects. The fingers give way to a squeeze, and the tips
stay: it bends fingers that are several times as long as R. A joint that yields at its torque limit changes levers by
half its angle or less.

Of an object that nothing keeps where it was gripped, every contact that the squeeze presses on it slides or lets go.
Where it comes to rest then hangs on its way there, on what the fingers touch while they close on, and on contacts that
were never looked for, since it was elsewhere. So the share from which an answer says nothing is less there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools

NOTICED = 0.05  # of the forces: what may be off by more is said; an object adrift may be anywhere
TOO_LARGE = 1.0  # of the forces: beyond this the equations say nothing


def share_of(turn: Any, move: Any, slip: Any, squeeze: Any, size: Any, yielded: Any = 0.0) -> Any:
    """By how much forces may be off, of their size: of one answer, or of many (m,). [rad, m, m, m, m, rad]"""
    way = np.maximum(np.maximum(move, slip), 0.1 * np.asarray(squeeze)) / size
    return np.maximum(np.maximum(turn, way), 0.5 * np.asarray(yielded))


def is_adrift(offset: Array, sticks: Bools, slides: Bools, mu: Array) -> Any:
    """Whether every finger that the squeeze presses on the object slides or has let go, and there are such fingers.

    offset (…, n) of fingers along the normals, below 0 where they are pressed [m]. sticks, slides, mu (…, n) : states
    and friction; what has none slides without being overcome.
    """
    pressed, keeps = offset < 0.0, sticks | (slides & (mu == 0.0))
    return pressed.any(axis=-1) & ~(pressed & keeps).any(axis=-1)


def say_nothing(share: Any, adrift: Any) -> Any:
    """Whether the equations of small motions say nothing of an answer, or of which of many (m,)."""
    return np.asarray(share) >= np.where(adrift, NOTICED, TOO_LARGE)


@dataclass(frozen=True, slots=True)
class Motions:
    """move : of the object's contact points, at most [m]. turn [rad]. slip, squeeze : the largest [m]. size : R [m].
    yielded : the largest, of a joint at its torque limit [rad]. adrift : see `is_adrift`.
    """

    move: float
    turn: float
    slip: float
    squeeze: float
    size: float
    yielded: float = 0.0
    adrift: bool = False

    @property
    def share(self) -> float:
        """By how much forces may be off, of their size."""
        return float(share_of(self.turn, self.move, self.slip, self.squeeze, self.size, self.yielded))

    @property
    def too_large(self) -> bool:
        """Whether the equations of small motions say nothing."""
        return bool(say_nothing(self.share, self.adrift))

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
        if self.share >= TOO_LARGE:
            return f"{', '.join(parts)}: the equations of small motions say nothing about that"
        if self.too_large:
            way = "everything that closing presses on the object slides or lets go: where it ends one solve cannot tell"
            return f"{', '.join(parts)}, and {way}; check() follows it"
        return (
            f"{', '.join(parts)}: the equations are of small motions, and forces may be off by about "
            f"{words.percent(self.share)}"
        )


def motions(s: Any) -> Motions:
    """Of a `GraspSolution` with an answer."""
    scene, size, fingers = s.scene, s.scene.units.length, s.scene.n - s.scene.environment
    shift, turn = (float(np.linalg.norm(part)) for part in (s.object_displacement[:3], s.object_displacement[3:]))
    offset = scene.lawful(scene.offset)[2 : 3 * scene.n : 3]
    slip, yielded = float(np.hypot(*s.slip.T).max(initial=0.0)), getattr(s, "joint_yield", np.zeros(1))
    sticks, slides = (np.array([state == word for state in s.contact_state]) for word in ("sticking", "sliding"))
    adrift = is_adrift(offset[:fingers], sticks[:fingers], slides[:fingers], scene.mu[:fingers])
    squeeze = -float(offset.min(initial=0.0))
    return Motions(
        max(shift, turn * size), turn, slip, squeeze, size, float(abs(yielded).max(initial=0.0)), bool(adrift)
    )
