"""Grip strength: the force that a cylinder of two halves measures in a power and in a pinch grasp."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from handlcp import words
from handlcp.check import Array, check_array, check_method_calls, read_only
from handlcp.errors import InputError
from handlcp.grasp.failure.failure_mode import FailureMode
from handlcp.grasp.model.contact import contact_frame
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.hand import HandGrasp, HandGraspSolution
from handlcp.lazy_property import lazy_property
from handlcp.record import Record
from handlcp.words import wrap_text

# ----------------------------------------------------------------
# The force across a plane that splits a cylinder in two halves, for all planes through its axis.
#
# A load cell joins the halves. With contacts at p_i from the axis that press with f_i, and a plane of normal n it bears
#
#     F(n) = -½ Σ sign(n·p_i) n·f_i        > 0: the halves are pressed together
#
# the mean of what the contacts on each side press towards the other. Both sides press alike where there is no load; a
# load, such as the weight, is borne half by half. What touches right at the split counts for neither.
#
# Between two planes through contacts the signs stay, and F(n) = n·A with A = -½ Σ sign f: as the plane turns, an arc of
# a cosine. So the largest and the least F are at planes through contacts, on either side of them, or where n is along
# A.

_ON_SPLIT_TOLERANCE = 1e-9  # of the cylinder's size, or of the circle: a contact that is as near to the split is on it
_MIN_FORCE_SHARE = 1e-9  # of the largest contact force: less is rounding
_SAME_FORCE_TOLERANCE = 1e-6  # of the largest: forces that press alike all around have no direction of their own


@dataclass(frozen=True, eq=False)
class ContactsAroundAxis:
    """The contacts around the axis of a cylinder, all in the same axes.

    positions (n, 3) : from a point of the axis [m]. forces (n, 3) : on the cylinder [N]. axis (3,) : a unit vector.
    """

    positions: Array
    forces: Array
    axis: Array

    @classmethod
    def from_solution(cls, solution: GraspSolution, axis: Any, point: Any) -> Self:
        """Contacts of a solution around the axis (3,) through a point (3,) [m], world axes. Raises InputError."""
        along, at = check_array("axis", axis, (3,)), check_array("point", point, (3,))
        if not along.any():
            raise InputError("axis", "an axis that is not zero", along.tolist())
        assert solution.spec is not None  # it was solved
        positions, forces = solution.spec.positions - at, np.array(solution.forces_world)
        return cls(read_only(positions), read_only(forces), read_only(along / np.linalg.norm(along)))

    def split_force(self, normal: Any) -> float:
        """The force [N] across the split with this normal (3,); what the normal has along the axis does not count.
        Raises InputError.
        """
        n = self.remove_axial_part(check_array("normal", normal, (3,)))
        size = float(np.linalg.norm(n))
        if not size > _ON_SPLIT_TOLERANCE * float(np.linalg.norm(normal)):
            raise InputError("normal", "a normal across the cylinder's axis", np.asarray(normal).tolist())
        return float(self._split_vector(n / size) @ n / size)

    def remove_axial_part(self, vectors: Array) -> Array:
        """(…, 3) without what they have along the axis."""
        return vectors - (vectors @ self.axis)[..., None] * self.axis

    @property
    def closing_normal(self) -> Array:
        """The normal (3,) across which the contacts press most in all, the largest axis of Σ f fᵀ across the cylinder.

        It points from thumb to fingers, or from palm to fingers. Where contacts press alike all around, it is the
        normal of the largest force.
        """
        pressed = self.remove_axial_part(self.forces)
        values, vectors = np.linalg.eigh(pressed.T @ pressed)
        if values[-1] - values[-2] <= _SAME_FORCE_TOLERANCE * values[-1]:
            return self.largest[1]
        return _orient_normal(vectors[:, -1])

    @property
    def largest(self) -> tuple[float, Array]:
        """The largest force [N] over all splits through the axis, and its normal (3,)."""
        return max(self._extreme_splits(1.0), key=lambda one: one[0])

    @property
    def least(self) -> tuple[float, Array]:
        """The least force [N] over all splits through the axis, and its normal (3,); below 0 it tears."""
        return min(self._extreme_splits(-1.0), key=lambda one: one[0])

    def _split_vector(self, n: Array) -> Array:
        """The vector A (3,) [N] of the force F = n·A across the split with the unit normal n (3,) across the axis."""
        height, arms = self.positions @ n, self.remove_axial_part(self.positions)
        least = _ON_SPLIT_TOLERANCE * float(np.linalg.norm(arms, axis=1).max(initial=0.0))
        return np.asarray(-0.5 * np.where(abs(height) <= least, 0.0, np.sign(height)) @ self.forces)

    def _extreme_splits(self, way: float) -> list[tuple[float, Array]]:
        """(force, normal) at the ends of every arc, and where the force is most (way 1) or least (-1) within it."""
        x, y = contact_frame(self.axis).T[:2]
        p = np.stack([self.positions @ x, self.positions @ y])
        ends = np.unique(np.round((np.arctan2(p[1], p[0]) + 0.5 * np.pi) % np.pi, 12))
        found, least = list[tuple[float, Array]](), _MIN_FORCE_SHARE * float(abs(self.forces).max(initial=0.0))
        for a, b in zip(ends, np.append(ends[1:], ends[:1] + np.pi), strict=True):
            middle = 0.5 * (a + b)
            borne = self._split_vector(np.cos(middle) * x + np.sin(middle) * y)
            best = float(np.arctan2(way * borne @ y, way * borne @ x))
            best += 2.0 * np.pi * round((middle - best) / (2.0 * np.pi))
            for angle in (a, b, *([best] if a < best < b else [])):
                n = np.cos(angle) * x + np.sin(angle) * y
                force = float(borne @ n)
                found.append((0.0 if abs(force) <= least else force, _orient_normal(n)))
        return found


def _orient_normal(n: Array) -> Array:
    """Of two normals of one plane the one whose largest entry is positive."""
    return read_only(np.asarray(n * np.sign(n[abs(n).argmax()])) + 0.0)


# ----------------------------------------------------------------
# A grip, and what a split cylinder measures in a hand.

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
