"""All effects, in the order of the page: those that follow from a scene's data, a hand's, those asked for by name."""

from __future__ import annotations

from handlcp.grasp import effect_kinds
from handlcp.grasp.analysis.explanation import ENVIRONMENT, Description, describe_effect
from handlcp.hand.elasticity.synergies import SYNERGIES
from handlcp.hand.elasticity.tendons import TENDONS
from handlcp.hand.objects.object import WEIGHS


def entries() -> tuple[Description, ...]:
    """A description of each."""
    kinds = effect_kinds()
    of_hands = [kind for kind in kinds if not kind.by_name]
    asked = [kind for kind in kinds if kind.by_name and kind.file_key is not None]
    from_data = [kind for kind in kinds if kind.by_name and kind.file_key is None]
    parts = (from_data, (TENDONS, SYNERGIES), of_hands, (WEIGHS,), asked, (ENVIRONMENT,))
    return tuple([e if isinstance(e, Description) else describe_effect(e) for part in parts for e in part])
