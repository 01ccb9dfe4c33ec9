"""Which effects a scene has: those that its data call for, in stamping order, then those asked for by name."""

from __future__ import annotations

from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene

__all__ = ["called_for", "stamped"]


def called_for(scene: Scene, section: Section, multipliers: bool) -> tuple[Effect, ...]:
    """The effects that the scene's data call for; multipliers as in `Effect.called_for`."""
    found = [kind.called_for(scene, section, multipliers) for kind in effect_kinds()]
    return tuple([e for e in found if e is not None])


def stamped(asked: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Those of the effects asked for that have rows or a law of their own: the others are part of the scene's data."""
    return tuple([e for e in asked if e.stamps])
