"""What motors have to give for torques of joints and tensions of tendons, and with which gear they do.

    peak = max(closing + τ_f, largest - τ_f),    continuous = held - τ_f
    N η ≥ max(peak / τ_peak, continuous / τ_continuous)

τ_f is the dry friction of a drive, in newtons at a tendon: of the hand's own, or of the motor that takes its place. It
is against closing, and carries its part of what is held. `held` is nothing where a gear carries all of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.hand.elasticity.motor import Drives, Motor
from handlcp.record import columns, plain, rows
from handlcp.text_table import TextTable

_NO_TENSION = 1e-6  # of the largest tension: less is rounding


def at_peak(closing: Array, largest: Array, drives: Drives | None) -> Array:
    """(k,) that each motor gives for a moment, where the largest effort is (k,) while it closes and (k,) at all."""
    rubs = _friction(drives)
    return read_only(np.maximum(closing + rubs, largest - rubs))


def for_good(held: Array, drives: Drives | None) -> Array:
    """(k,) that each motor gives for good, where (k,) is held [N·m, N]."""
    carried = np.zeros(len(held))
    if drives is not None:
        carried = np.array([0.0 if m is None else m.holding or 0.0 for m in drives.of])
    return read_only(np.where(held <= carried, 0.0, np.maximum(held - _friction(drives), 0.0)))


def reductions(motor: Motor, closing: Array, largest: Array, held: Array) -> Array:
    """(k,) the least reduction with which a motor does for these efforts, (k,) each [N·m, N]. Raises InputError."""
    if not isinstance(motor, Motor):
        raise InputError("motor", "a Motor", repr(motor)[:80])
    bought, own = Drives((motor,) * len(held)), replace(motor, reduction=1.0, friction=0.0, holding=None)
    return read_only(np.maximum(at_peak(closing, largest, bought) / own.at_peak, for_good(held, bought) / own.for_good))


def _friction(drives: Drives | None) -> Array | float:
    return 0.0 if drives is None else drives.friction


@dataclass(frozen=True, slots=True, eq=False)
class RequiredTension:
    """What tendons pull with, under any load of a brief, from the first touch to the whole load; how much harder than
    at first, of those that are taut whatever comes.

    tendons : t names. tension, held : (t,) [N] the largest, and the largest under any whole load, 0 where a tendon only
    lets go. least : (t,) [N] the smallest; below 0 the tendon goes slack, and as much more of pretension keeps it taut:
    half of it does where an equal one works against it. moved : joints that tendons with motors move. drives : motors
    of the tendons, whose dry friction counts in what they give; None: none are known.
    """

    tendons: tuple[str, ...]
    tension: Array
    held: Array
    least: Array
    moved: tuple[str, ...] = ()
    drives: Drives | None = None

    @property
    def peak(self) -> Array:
        """(t,) [N] that each motor gives at the tendon for a moment: `tension`, and the drive's dry friction."""
        return at_peak(self.tension, self.tension, self.drives)

    @property
    def continuous(self) -> Array:
        """(t,) [N] that each motor gives at the tendon for good, as of joints."""
        return for_good(self.held, self.drives)

    def reductions(self, motor: Motor) -> Array:
        """(t,) the least reduction [N/(N·m)] with which this motor serves at each tendon, as of joints. Raises
        InputError.
        """
        return reductions(motor, self.tension, self.tension, self.held)

    @property
    def slack(self) -> tuple[str, ...]:
        """Those that go slack, by more than rounding."""
        size = _NO_TENSION * float(self.tension.max(initial=0.0))
        return tuple([name for name, least in zip(self.tendons, self.least.tolist(), strict=True) if least < -size])

    @property
    def table(self) -> TextTable:
        """Tendon by tendon."""
        numbers = words.column(self.peak.tolist()), words.column(self.continuous.tolist())
        least = zip(self.tendons, self.least.tolist(), strict=True)
        says = [
            f"goes slack; {words.force(-low)} more of pretension at most keep it taut" if name in self.slack else ""
            for name, low in least
        ]
        every = tuple(zip(self.tendons, *numbers, says, strict=True))
        return TextTable(("tendon", "peak\nN", "continuous\nN", ""), every, "<>><")

    def to_dict(self) -> list[dict[str, Any]]:
        """A dictionary for each tendon."""
        lines = (
            "tendon = tendons", "tension_N = tension", "held_N = held", "peak_N = peak", "continuous_N = continuous",
            "least_N = least",
        )  # fmt: skip
        found: list[dict[str, Any]] = plain(rows(columns(self, *lines)))
        return found
