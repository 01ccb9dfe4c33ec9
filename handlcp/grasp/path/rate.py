"""How fast the object gives way while a load grows, and whether it slides through.

While something that presses sticks, fingers hold the object, and the fastest that it gives way then is what they allow.
Once nothing sticks, all that it goes beyond `FASTER` times that rate adds up, and what it falls short of that is taken
off again; at `RUNS` it slides through. A short burst of speed, as where a contact's slip turns to the next face of its
friction pyramid, goes nowhere, and does not count.
"""

from __future__ import annotations

from handlcp.tolerances import FASTER, RUNS

__all__ = ["Rate", "reached"]


class Rate:
    """Of a stage. least : the shortest step that tells, a shorter one lies between changes at one load. loads : whether
    a load changes in the stage. stuck : the fastest while something stuck. last : of the last step; 0 at the beginning
    and after a snap. beyond : how far the object has gone too far, as `Stepper.far` has it.
    """

    def __init__(self, least: float, loads: bool) -> None:
        self.least, self.loads, self.stuck, self.last, self.beyond = least, loads, 0.0, 0.0, 0.0

    def sticks(self, rate: float, size: float) -> None:
        """Note the rate of a step of this size in which something sticks."""
        self.beyond = 0.0
        if size >= self.least:
            self.stuck = max(self.stuck, rate)

    def runs(self, rate: float, size: float) -> float | None:
        """The part of a step of this size in which nothing sticks at which the object slides through; None: none."""
        more = (rate - FASTER * self.stuck) * size
        before, self.beyond = self.beyond, max(self.beyond + more, 0.0)
        return None if self.beyond < RUNS else min(max((RUNS - before) / more, 0.0), 1.0)

    def snaps(self, far: float) -> None:
        """The object has moved so far at one load."""
        self.last = 0.0
        self.beyond += far


def reached(first: float, second: float, a: float, b: float) -> float:
    """The rate at the end of a step, 1, on the exponential through those at a and b; no more than twice the second."""
    if not 0.0 < first < second:
        return second
    return float(second * min((second / first) ** ((1.0 - b) / (b - a)), 2.0))
