"""All effects, in the order of the page: those that follow from a scene's data, a hand's, those asked for by name."""

from __future__ import annotations

from handlcp.grasp import effect_kinds
from handlcp.grasp.analysis.explanation import ENVIRONMENT, Description, describe_effect
from handlcp.hand.elasticity.synergies import SYNERGIES
from handlcp.hand.elasticity.tendons import TENDONS
from handlcp.hand.objects.object import WEIGHS

__all__ = ["entries"]


def entries() -> tuple[Description, ...]:
    """A description of each."""
    kinds = effect_kinds()
    # What brings no file key follows from the data, or is asked for by arguments of a hand's grasp
    asked = [kind for kind in kinds if kind.file_key is not None]
    of_hands = [kind for kind in kinds if kind.file_key is None and kind.needs_joints]
    from_data = [kind for kind in kinds if kind.file_key is None and not kind.needs_joints]
    parts = (from_data, (TENDONS, SYNERGIES), of_hands, (WEIGHS,), asked, (ENVIRONMENT,))
    return tuple([e if isinstance(e, Description) else describe_effect(e) for part in parts for e in part])
