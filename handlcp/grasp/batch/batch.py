"""What a batch asks: its grasps, and how each of them is solved."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from handlcp.check import yes_or_no
from handlcp.errors import InputError
from handlcp.grasp.friction import Pyramid, Section, as_section
from handlcp.grasp.grasp import Grasp
from handlcp.lcp.solve import AnySolver


@dataclass(frozen=True, slots=True)
class Batch:
    """m grasps and the arguments of their solves.

    spatial, planar : the friction sets of spatial and of planar grasps. solver, proof : as in `Grasp.solve`.
    """

    grasps: tuple[Grasp, ...]
    spatial: Section
    planar: Section
    solver: AnySolver
    proof: bool

    def __len__(self) -> int:
        return len(self.grasps)

    def section(self, k: int) -> Section:
        """The friction sets of grasp k."""
        return self.planar if self.grasps[k].scene.kind.planar else self.spatial


def batch_of(grasps: Iterable[Grasp], faces: int | str | Pyramid, solver: AnySolver, proof: bool) -> Batch:
    """The batch with everything checked. Raises InputError."""
    if isinstance(grasps, Grasp) or not isinstance(grasps, Iterable):
        raise InputError("grasps", "several Grasps, such as a list", repr(grasps)[:80])
    every = tuple(grasps)
    for k, g in enumerate(every):
        if not isinstance(g, Grasp):
            raise InputError(f"grasps[{k}]", "a Grasp", repr(g)[:80])
    return Batch(every, as_section(faces), as_section(faces, planar=True), solver, yes_or_no("proof", proof))
