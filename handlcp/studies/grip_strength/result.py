"""Grip strength: the force that a cylinder of two halves measures in a power and in a pinch grasp."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from handlcp import words
from handlcp.check import Array, check_method_calls
from handlcp.grasp.failure.failure_mode import FailureMode
from handlcp.hand import HandGrasp, HandGraspSolution
from handlcp.lazy_property import lazy_property
from handlcp.record import Record
from handlcp.studies.grip_strength.split_force import ContactsAroundAxis
from handlcp.words import wrap_text

_SOURCE = "NIST SP 1227 (draft, October 2018), grasp strength; ASTM work item WK83863"


@dataclass(frozen=True, eq=False)
class Grip(Record):
    """One grasp of the cylinder, closed with all the torque that the hand has.

    kind : "power" or "pinch". normal (3,) : of the split across which `force` is measured, world axes. binds : what
    gives out with a harder grip; says : the same in words. word : of `grasp.check()`. grasp, solution : closed so.
    around : the contacts around the cylinder's axis.
    """

    entries = (
        "kind", "force_N", "normal (3,)", "largest_N", "largest_normal (3,) = around.largest.1", "least_N",
        "least_normal (3,) = around.least.1", "binds", "says", "word", "normal_force_N",
    )  # fmt: skip

    kind: str
    normal: Array
    binds: tuple[FailureMode, ...]
    says: str
    word: str
    grasp: HandGrasp
    solution: HandGraspSolution
    around: ContactsAroundAxis

    @lazy_property
    def force(self) -> float:
        """The internal force [N] across the split with `normal`, as a maker measures it."""
        return self.around.split_force(self.normal)

    @property
    def largest(self) -> float:
        """The largest force [N] across a split through the axis, however it is turned."""
        return self.around.largest[0]

    @property
    def least(self) -> float:
        """The least force [N] across a split through the axis, however it is turned."""
        return self.around.least[0]

    @property
    def normal_force(self) -> dict[str, float]:
        """How hard each contact presses, by name [N]."""
        return self.solution.pressed

    def __str__(self) -> str:
        turned = f"{words.format_force(self.least)} to {words.format_force(self.largest)} as the split turns"
        return f"{self.kind}: {words.format_force(self.force)} across the split ({turned}); {self.says}; {self.word}"


@check_method_calls
@dataclass(frozen=True, eq=False)
class SplitCylinder(Record):
    """What a split cylinder measures in a hand; made by `split_cylinder`.

    diameter, length [m] : of the cylinder. power, pinch : the grasps; None where there is none, or it was not asked
    for. missing : by kind, why there is none. source : the documents that have the test.
    """

    entries = ("source", "diameter_m", "length_m", "power", "pinch", "missing")

    diameter: float
    length: float
    power: Grip | None
    pinch: Grip | None
    missing: dict[str, str] = field(default_factory=dict)
    source: str = _SOURCE

    @property
    def grips(self) -> tuple[Grip, ...]:
        """Those that there are."""
        return tuple([grip for grip in (self.power, self.pinch) if grip is not None])

    def plot(self, path: Any = None, *, title: str = "") -> Any:
        """The cylinder seen along its axis, with contacts, forces and the split; and the force over the split's angle.
        A matplotlib figure, or the file that it was written to.

        path : of a png, svg, pdf or jpg file; None: the figure itself. Raises InputError for an unknown format;
        Unsupported without matplotlib.
        """
        from handlcp.viz import draw_or_save, draw_split_cylinder  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_split_cylinder, self, title)

    @property
    def headline(self) -> str:
        """What was measured with."""
        wide, long = words.format_lengths((self.diameter, self.length))
        return f"split cylinder, {wide} wide and {long} long, the hand closed with all its torque"

    def __str__(self) -> str:
        """A line for each grasp."""
        lines = [*map(str, self.grips), *[f"{kind}: none: {why}" for kind, why in self.missing.items()]]
        return "\n".join([wrap_text(line, "  ") for line in (self.headline, *lines)])

    def __repr__(self) -> str:
        forces = ", ".join([f"{grip.kind}={grip.force:.6g}" for grip in self.grips])
        return f"SplitCylinder(diameter={self.diameter:g}, {forces or 'no grasp'})"
