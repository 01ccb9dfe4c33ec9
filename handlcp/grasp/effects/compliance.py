"""Compliance asked for by name: a flexibility that joins that of the fingers when the grasp is placed.

    E = J K⁻¹ Jᵀ + pads + Σ E_compliance ⪰ 0

It brings no unknowns and stamps nothing of its own: solver, certifier and search all see one E, the scene's. A grasp
keeps the fingers' own E beside it (`Grasp.flexibility`), so that either can be replaced without the other.
Source: model, "Flexibility from the hand" (compliances in series add).
"""

from __future__ import annotations

from collections.abc import Iterable

from handlcp.check import Array, read_only
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System

__all__ = ["Compliance", "softened", "stamped"]


class Compliance(Effect):
    """An effect that is flexibility alone. Subclasses say what they add to E."""

    title = "compliance"
    equation = "E += E_c,  E_c ⪰ 0"

    def matrix(self, positions: Array, frames: Array, soft: tuple[int, ...]) -> Array:
        """(c, c) E_c [m/N], symmetric positive semidefinite, contact axes; positions (n, 3) [m], frames (n, 3, 3), soft
        as in `Scene`.
        """
        raise NotImplementedError

    def stamp(self, scene: Scene, system: System) -> None:
        """Nothing: the scene's E has it."""


def stamped(effects: Iterable[Effect]) -> tuple[Effect, ...]:
    """The effects with blocks of their own: all but compliances."""
    return tuple(e for e in effects if not isinstance(e, Compliance))


def softened(
    flexibility: Array,
    effects: Iterable[Effect],
    positions: Array,
    frames: Array,
    planar: bool,
    soft: tuple[int, ...] = (),
) -> Array:
    """(c, c) the fingers' E with the compliances among `effects`, read-only; without any, the very same array.

    planar : only what acts in the plane is added. Forces in a plane are what a planar scene has, and motion across it
        opens no gap and is no slip, so that rows and columns of the tangent across it (y) say nothing.
    """
    for e in effects:
        if isinstance(e, Compliance):
            more = e.matrix(positions, frames, soft)
            if planar:
                more = more.copy()
                more[1::3] = 0.0
                more[:, 1::3] = 0.0
            if more.any():
                flexibility = read_only(flexibility + more)
    return flexibility
