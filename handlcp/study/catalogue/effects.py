"""All effects, in the order of the page: those that follow from a scene's data, a hand's, those asked for by name."""

from __future__ import annotations

from handlcp.grasp.catalogue import BY_NAME, FROM_DATA
from handlcp.grasp.entry import Entry, entry_of
from handlcp.grasp.environment import ENVIRONMENT
from handlcp.hand.command import COMMAND
from handlcp.hand.objects import WEIGHS
from handlcp.hand.synergies import SYNERGIES
from handlcp.hand.tendons import TENDONS
from handlcp.hand.weight import WEIGHT

__all__ = ["entries"]


def entries() -> tuple[Entry, ...]:
    data = (entry_of(kind) for kind in FROM_DATA)
    asked = (entry_of(kind) for kind in BY_NAME)
    return (*data, TENDONS, SYNERGIES, WEIGHT, COMMAND, WEIGHS, *asked, ENVIRONMENT)
