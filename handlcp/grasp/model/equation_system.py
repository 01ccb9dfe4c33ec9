"""Named groups of unknowns, and the system w = M x + q into which effects stamp the blocks between them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.grasp.model.scene import Scene
from handlcp.lcp.kernels.dense import kernel


@dataclass(frozen=True, slots=True)
class Unknown:
    """A group of unknowns that an effect brings, each with a row of its own.

    name : of the group ("r_N", "u", …); blocks are addressed by it.
    count : how many.
    free : rows are equations and the unknowns have no sign; otherwise 0 ≤ x ⟂ w ≥ 0.
    measure : what x is, and therefore its natural unit; its row w is what does work on it: a "force" [N] on a "motion"
        [m], and the other way round; a wrench on a "twist".
    levers : (count,) [m], of a "motion" alone, where x is an angle and w a torque:
        what makes a motion of one, and a force of the other.
    """

    name: str
    count: int
    free: bool
    measure: Literal["force", "motion", "twist"]
    levers: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Raises InputError for levers of what is no motion, or not one for each."""
        if self.levers and self.measure != "motion":
            raise InputError(f"Unknown({self.name!r}).levers", 'none, or measure "motion"', f"measure {self.measure!r}")
        if self.levers and len(self.levers) != self.count:
            raise InputError(f"Unknown({self.name!r}).levers", f"{self.count} of them, or none", len(self.levers))

    def sizes(self, scene: Scene) -> tuple[float | Array, float | Array]:
        """SI sizes of one natural unit of x and of w, one or one each."""
        if self.levers:
            levers = np.array(self.levers)
            return scene.units.motion_unit / levers, scene.units.force_unit * levers
        u = scene.units
        if self.measure == "twist":
            return scene.twist_units, u.force_unit * u.motion_unit / scene.twist_units
        return (u.force_unit, u.motion_unit) if self.measure == "force" else (u.motion_unit, u.force_unit)


_MECHANICAL_GROUPS = ("r_N", "r_T", "r_S", "u")
_EMPTY_SLICE = slice(0, 0)


@dataclass(frozen=True, slots=True)
class Layout:
    """Where the unknowns go: complementary groups first, free groups last.

    groups : in that order. at : the slice of each. size : unknowns in all. extra : groups other than forces and object
    motion. forces : where the normal unknowns begin, how many they are, and where the tangential ones begin, those of
    points and then those of soft contacts; 0: there are none.
    """

    groups: tuple[Unknown, ...]
    at: dict[str, slice]
    size: int
    extra: tuple[Unknown, ...]
    forces: tuple[int, int, int]


def unknown_labels(groups: tuple[Unknown, ...]) -> tuple[str, ...]:
    """A name for every unknown of these groups, such as "r_T[2]"."""
    return tuple(f"{g.name}[{k}]" for g in groups for k in range(g.count))


def make_layout(unknowns: Iterable[Unknown]) -> Layout:
    """The layout of these groups; empty ones are left out."""
    present = [u for u in unknowns if u.count]
    groups = tuple(sorted(present, key=lambda u: u.free))
    ends = np.cumsum([g.count for g in groups]).tolist()
    at = {g.name: slice(end - g.count, end) for g, end in zip(groups, ends, strict=True)}
    extra = tuple(g for g in groups if g.name not in _MECHANICAL_GROUPS)
    normal, tangents = at.get("r_N", _EMPTY_SLICE), at.get("r_T") or at.get("r_S", _EMPTY_SLICE)
    forces = (normal.start, normal.stop - normal.start, tangents.start)
    return Layout(groups, at, ends[-1] if ends else 0, extra, forces)


class EquationSystem:
    """M (N, N) and q (N,) in natural units, as a `Layout` orders the unknowns."""

    __slots__ = ("M", "at", "layout", "q")

    def __init__(self, where: Layout) -> None:
        self.layout, self.at = where, where.at
        self.M, self.q = np.zeros((where.size, where.size)), np.zeros(where.size)

    def load(self, row: str, values: Array | float) -> None:
        """q[row] += values, when the scene has that group."""
        if row in self.at:
            self.q[self.at[row]] += values

    def load_tangents(self, name: str, scene: Scene) -> None:
        """q[name] += the offsets along these tangential unknowns."""
        at, d = self.at[name], scene.natural.d
        _, normals, tangential = self.layout.forces
        first = normals + at.start - tangential
        self.q[at] += d[first : first + at.stop - at.start]

    def couple(self, row: str, block: Array, sign: float) -> None:
        """Add sign · block (rows, k) from force components, normals first, to a group's rows; its transpose back."""
        couple_block(self.M, self.at[row].start, self.layout.forces, block, sign)

    def add_between_forces(self, block: Array) -> None:
        """Add block (k, k) between all unknown force components, normals first."""
        add_force_block(self.M, self.layout.forces, block)

    def sizes(self, scene: Scene) -> tuple[Array, Array]:
        """(N,) SI sizes of one natural unit of every x and every w."""
        x, w = np.empty(len(self.q)), np.empty(len(self.q))
        for g in self.layout.groups:
            x[self.at[g.name]], w[self.at[g.name]] = g.sizes(scene)
        return x, w


@kernel
def add_force_block(M: Array, forces: tuple[int, int, int], block: Array) -> None:
    """M += block between force components; `forces` as in `Layout`."""
    normal, count, tangential = forces
    for a in range(block.shape[0]):
        i = normal + a if a < count else tangential + a - count
        for b in range(block.shape[1]):
            M[i, normal + b if b < count else tangential + b - count] += block[a, b]


@kernel
def couple_block(M: Array, row: int, forces: tuple[int, int, int], block: Array, sign: float) -> None:
    """M += sign · block in rows row, row + 1, … and block' in their columns."""
    normal, count, tangential = forces
    for b in range(block.shape[1]):
        j = normal + b if b < count else tangential + b - count
        for a in range(block.shape[0]):
            M[row + a, j] += sign * block[a, b]
            M[j, row + a] += block[a, b]
