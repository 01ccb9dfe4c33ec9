"""What gives out, as data. The judge makes it (`judge.py`), the table of words says it (`wording.py`)."""

from __future__ import annotations

from dataclasses import dataclass, field

SLIPS, OPENS, TORQUE, RANGE = "slips", "opens", "torque", "range"
EQUILIBRIUM, MOTION, SLIDES, UNDECIDED = "equilibrium", "motion", "slides through", "undecided"
OBJECT = "the object"


@dataclass(frozen=True, slots=True)
class Cause:
    """What gives out. kind : "slips" (a finger that slips), "opens" (a contact that lets go), "torque" (a joint at its
    torque limit), "range" (a joint at the end of its range), "equilibrium" (forces can no longer balance the load),
    "motion" (the object moves farther than was allowed), "slides through" (the object, where no contact that presses
    sticks), "undecided" (something does, and it is not known what).
    who : the finger, the joint or "the object". margin : share of the limit that is left; 0 at the limit, below 0
    beyond it. Causes of the same kind and name are equal, whatever their margins.
    """

    kind: str
    who: str
    margin: float = field(default=0.0, compare=False)

    def __repr__(self) -> str:
        left = f", margin={self.margin:.3g}" if self.margin else ""
        return f"Cause({self.kind!r}, {self.who!r}{left})"


Bind = Cause
