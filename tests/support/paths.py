"""What the tests need of the inside of paths."""

from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path import advance, step_grasp
from handlcp.grasp.path.advance import Leg
from handlcp.grasp.path.stability import STUCK
from handlcp.grasp.path.state import Failure


def in_one_matrix(patch):
    """Paths of many contacts are computed as those of few are: contacts are not eliminated one by one."""
    patch.setattr(step_grasp, "_pads_alone", lambda P, n: False)


def give_up_beyond(share, patch):
    """From this share of an open stage on no step finds a state, and the object neither moves on nor rests."""
    found = Leg._found

    def stopped(leg, state, at, size):
        is_beyond = leg.beyond is not None and at + size > share
        return Failure(PathStatus.NO_FORCES) if is_beyond else found(leg, state, at, size)

    patch.setattr(Leg, "_found", stopped)
    patch.setattr(advance, "flow", lambda stepper, state, *rest: (state, STUCK))
