"""Lift and shake: a ball and a cube that a hand lifts and shakes, as shares of a rated payload."""

from __future__ import annotations

from dataclasses import dataclass, field

from handlcp import words
from handlcp.grasp import Loading
from handlcp.hand import HandGrasp
from handlcp.record import Record
from handlcp.study.payload.result import kilograms
from handlcp.text_table import wrapped

_SOURCE = "NVIDIA SimReady Foundation, FET028, gripper_close_lift_sphere and gripper_close_lift_cube 1.4.0"


@dataclass(frozen=True, eq=False)
class Shaken(Record):
    """One object, lifted and shaken in the best grasp that was found.

    shape : "sphere" or "cube".
    size : its diameter or edge [m].
    mass : of the object [kg].
    held : whether it is held from the lift to the end of the shake, moves less than `allowed` and no joint is over its
        limit.
    says : how it ends, in words.
    moved : how far its centre moves at most in the hand once that has closed [m].
    allowed : how far it may move [m].
    used : the largest share of a torque limit on the way; 0 where none is known.
    most : the mass [kg] that the same grip holds under the largest acceleration, its joints giving way at their torque
        limits.
    period : of the object's swing along gravity in this grasp [s]; statics is right where that is short beside the
        period of the shake. NaN where the object is not held, or some motion of it is left open.
    grasp : closed, its object under the largest acceleration.
    loading : the whole path.
    """

    entries = (
        "shape",
        "size_m",
        "mass_kg",
        "held",
        "says",
        "moved_m",
        "allowed_m",
        "used",
        "mass_held_kg = most",
        "period_s",
        "normal_force_N",
    )

    shape: str
    size: float
    mass: float
    held: bool
    says: str
    moved: float
    allowed: float
    used: float
    most: float
    period: float
    grasp: HandGrasp
    loading: Loading

    @property
    def normal_force(self) -> dict[str, float]:
        """How hard each contact presses at the end, by name [N]."""
        return self.loading.solution.pressed

    def __str__(self) -> str:
        held = "held" if self.held else "not held"
        what = f"{self.shape}, {words.length(self.size)}, {kilograms(self.mass)}: {held}"
        return f"{what}: {self.says}; this grip holds up to {kilograms(self.most)}"


@dataclass(frozen=True, eq=False)
class LiftAndShake(Record):
    """A ball and a cube, lifted and shaken; made by `lift_and_shake`.

    rated : the payload that is tested [kg]. opening : of the hand [m]. acceleration : the largest of the shake [m/s²].
    sphere, cube : what becomes of them; None where the hand has no grasp of it, with the reason in `missing`.
    source : the document that has the test.
    """

    entries = (
        "source",
        "passed",
        "rated_payload_kg = rated",
        "opening_m",
        "acceleration_m_per_s2",
        "sphere",
        "cube",
        "missing",
    )

    rated: float
    opening: float
    acceleration: float
    sphere: Shaken | None
    cube: Shaken | None
    missing: dict[str, str] = field(default_factory=dict)
    source: str = _SOURCE

    @property
    def passed(self) -> bool:
        """Whether both are held."""
        return all(row is not None and row.held for row in (self.sphere, self.cube))

    def __str__(self) -> str:
        """What was asked, and a line for each object."""
        asked = f"lift and shake at a rated payload of {kilograms(self.rated)}, up to {self.acceleration:.3g} m/s²"
        lines = [f"{asked}: {'passed' if self.passed else 'not passed'}"]
        lines += [str(row) for row in (self.sphere, self.cube) if row is not None]
        lines += [f"{shape}: not held: {why}" for shape, why in self.missing.items()]
        return "\n".join([wrapped(line, "  ") for line in lines])

    def __repr__(self) -> str:
        return f"LiftAndShake(rated={self.rated:g}, passed={self.passed})"
