"""Doors into the catalogue of effects: all classes by their title, compliances, limits as an effect keeps them."""

from __future__ import annotations

import handlcp as hl
from handlcp.grasp import effect_kinds
from handlcp.grasp.analysis.explanation import (
    ENVIRONMENT_DESCRIPTION as _ENVIRONMENT,
    describe_effect,
)
from handlcp.grasp.assembly.problem import asked_effects_with_rows
from handlcp.grasp.assembly.scene_builder import add_flexibility
from tests.support.grasp import arrays

ENVIRONMENT: str = _ENVIRONMENT.title
# Every effect that any grasp may have, by its title
KINDS: dict[str, type] = {
    kind.title: kind for kind in effect_kinds() if not (kind.needs_joints and kind.file_key is None)
}


def kinds_in_the_catalogue():
    """Those that follow from the data, then those asked for by name."""
    return effect_kinds()


def entry_for(kind):
    """What the catalogue prints of an effect."""
    return describe_effect(kind)


# ---------------------------------------------------------------- compliances
def compliances():
    """The effects that become part of the flexibility."""
    return [hl.ContactCompliance, hl.SoftWrist]


def stamps(*asked):
    """Those of these effects that have rows of their own."""
    return asked_effects_with_rows(asked)


def softened(grasp, flexibility, positions=None):
    """A flexibility with that of the grasp's effects added, at other positions where given."""
    at = grasp.spec if positions is None else grasp.spec.replace(positions=positions)
    return add_flexibility(grasp.effects, at, (), flexibility)


# ---------------------------------------------------------------- limits
def limits_of(effect, grasp):
    """The limits that an effect makes of a grasp; made once."""
    return effect.present(grasp.scene)


def limits_kept(grasp):
    """(effect, its limits) as far as the grasp keeps them."""
    return arrays(grasp).effect_cache
