"""What an effect is: its unknowns, its blocks, and how its own law is checked."""

from __future__ import annotations

from typing import ClassVar

from handlcp.check import Array
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["Effect"]


class Effect:
    """One physical effect. Subclasses declare unknowns and stamp blocks; most need nothing else.

    title : what `explain()` calls it. equation : its law in one line.
    """

    title: ClassVar[str]
    equation: ClassVar[str]

    def why(self, scene: Scene) -> str:
        """Why the scene has this effect, for `explain()`."""
        raise NotImplementedError

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """The groups this effect brings."""
        return ()

    def stamp(self, scene: Scene, system: System) -> None:
        """Add this effect's blocks."""
        raise NotImplementedError

    def opening(self, scene: Scene, extra: dict[str, Array]) -> Array | None:
        """(n, 3) motion between object and fingertips that this effect adds to Gᵀu + E r + d [m, contact axes].

        `extra` holds the unknowns that effects brought beyond forces and object motion, by group name, SI.
        None: nothing.
        """
        return None

    def coupling(self, scene: Scene, extra: dict[str, Array]) -> Array | None:
        """(3n,) a: an active bound aᵀr = const on the contact forces, whose multiplier moves the contacts along a.

        None where the effect has no such bound, or it is not active. For the count of what a solution leaves free.
        """
        return None

    def residual(
        self, scene: Scene, forces: Array, extra: dict[str, Array], force_size: float, motion_size: float
    ) -> float:
        """How far a candidate misses this effect's own law, relative; forces (n, 3) N in contact axes.

        The laws of balance, contact and friction are recomputed by the certifier itself.
        """
        return 0.0
