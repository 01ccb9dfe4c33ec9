"""`slip_resistance`: a grasped object is pulled along its axis until it slips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, check_array, check_call, check_number, read_only
from handlcp.errors import InputError
from handlcp.grasp import Grasp, LoadLimit, TorqueSaturation
from handlcp.grasp.failure.failure_mode import SLIDES, SLIPS
from handlcp.hand import Hand, HandGrasp
from handlcp.lazy_property import lazy_property
from handlcp.record import Record
from handlcp.studies.grip_strength import split_cylinder
from handlcp.studies.grip_strength.measure import POWER
from handlcp.words import wrap_text

_SOURCE = "NIST SP 1227 (draft, October 2018), slip resistance"


@dataclass(frozen=True, eq=False)
class SlipResistance(Record):
    """How hard a grasped object is pulled along an axis before it slips; made by `slip_resistance`.

    axis (3,) : of the pull, a unit vector, world axes. along, against : the load limits of 1 N one way and the other,
    so that their factors are newtons. source : the document that has the test.
    """

    entries = (
        "source", "force_N", "slips", "says", "axis (3,)", "first_slip_N", "along_N = along.factor",
        "against_N = against.factor",
    )  # fmt: skip

    axis: Array
    along: LoadLimit
    against: LoadLimit
    source: str = _SOURCE

    @property
    def weaker(self) -> LoadLimit:
        """The limit of the way in which less is held."""
        return min((self.along, self.against), key=lambda limit: limit.factor)

    @property
    def force(self) -> float:
        """The pull [N] that is held both ways: with more the object slips, or something else gives out before; inf
        where nothing does.
        """
        return self.weaker.factor

    @property
    def first_slip(self) -> float | None:
        """The pull [N] with which a contact begins to slide, while others still hold the object; None: none does."""
        return self.weaker.first_slip

    @lazy_property
    def slips(self) -> bool:
        """Whether the object slips there; False where a joint is at its limit before, or nothing gives out."""
        return any(cause.kind in (SLIPS, SLIDES) for cause in self.weaker.binds)

    @property
    def says(self) -> str:
        """In words, what gives out."""
        return self.weaker.why

    def __str__(self) -> str:
        one, other = (words.format_force(limit.factor) for limit in (self.along, self.against))
        x, y, z = (self.axis + 0.0).round(3).tolist()
        head = (
            f"slip resistance: {words.format_force(self.force)} ({one} along ({x:g}, {y:g}, {z:g}), {other} against it)"
        )
        first = "" if self.first_slip is None else f"a contact begins to slide at {words.format_force(self.first_slip)}"
        return "\n".join([wrap_text(text, "  ") for text in (head, self.says, first) if text])

    def __repr__(self) -> str:
        return f"SlipResistance(force={self.force:.6g}, slips={self.slips})"


@check_call()
def slip_resistance(
    held: Grasp | Hand,
    axis: Any = None,
    *,
    diameter: Any = None,
    friction: Any = None,
    length: Any = None,
    kind: str = POWER,
    accuracy: Any = None,
) -> SlipResistance:
    """The pull [N] along an object's axis with which it begins to slip out of the hand, as in NIST's test of slip
    resistance (NIST SP 1227).

    held : a grasp; or a hand, which then closes with all its torque on a cylinder of this diameter [m], as in
        `split_cylinder`: friction, length as there, kind "power" or "pinch". While the object is pulled, joints give
        way at their torque limits, and go on pulling with them.
    axis : (3,) of the pull, world axes; None: the z axis of the object, a cylinder's own.
    accuracy : as in `load_limit`.

    The pull acts at the grasp's reference, the object's centre of mass, and grows slowly, both ways. It comes beside
    the object's weight, if it has one. Raises InputError, and what `split_cylinder` and `load_limit` raise.
    """
    if isinstance(held, Hand):
        wide = check_number("diameter", diameter, above=0.0)
        strength = split_cylinder(held, wide, length=length, friction=friction, grasps=[kind])
        grasp: Grasp = strength.grips[0].grasp.replace(effects=(TorqueSaturation(),))
    elif not isinstance(held, Grasp):
        raise InputError("held", "a grasp or a Hand", repr(held)[:80])
    elif any(value is not None for value in (diameter, friction, length)):
        raise InputError("diameter", "None beside a grasp: diameter, friction and length are for a hand", diameter)
    else:
        grasp = held
    n = _pull_axis(grasp, axis)
    pull = np.append(n, np.zeros(3))
    along, against = (grasp.load_limit(way, accuracy=accuracy) for way in (pull, -pull))
    return SlipResistance(n, along, against)


def _pull_axis(grasp: Grasp, axis: Any) -> Array:
    """The axis (3,) of the pull, a unit vector in world axes: as given, or the object's z axis. Raises InputError."""
    if axis is not None:
        n = check_array("axis", axis, (3,))
        if not n.any():
            raise InputError("axis", "an axis that is not zero", n.tolist())
        return read_only(n / np.linalg.norm(n))
    if not isinstance(grasp, HandGrasp) or grasp.target is None:
        raise InputError("axis", "the axis of the pull, as this grasp has no object", None)
    return read_only(grasp.target.frame[0][:, 2].copy())
