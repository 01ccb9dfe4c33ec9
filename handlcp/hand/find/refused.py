"""What a candidate of a search may be refused for. Any other bad input is the caller's, and no result of a search."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from handlcp.errors import InputError, NotReached, Unsupported
from handlcp.hand.squeeze import RigidFinger

# A link deep in the object, too many that touch, or joints that all stop before anything presses: no argument of a user
_OF_CANDIDATES = "target", "links", "hold_object"


@contextmanager
def skipping_refused(why: list[str] | None = None) -> Iterator[None]:
    """Around what makes a candidate: ends the block where no grasp can be made there, and raises all else. why : takes
    the reason, where it is of the hand and not of the place.
    """
    try:
        yield
    except RigidFinger as rigid:
        if why is not None:
            why.append(f"expected {rigid.expected}, got {rigid.got}")
    except (NotReached, Unsupported):
        return
    except InputError as error:
        if error.argument not in _OF_CANDIDATES:
            raise
