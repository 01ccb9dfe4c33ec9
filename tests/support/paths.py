"""What the tests need of the inside of paths."""

from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path import step_grasp
from handlcp.grasp.path.advance import Leg


def in_one_matrix(patch):
    """Paths of many contacts are computed as those of few are: contacts are not eliminated one by one."""
    patch.setattr(step_grasp, "_pads_alone", lambda P, n: False)


def give_up_beyond(share, patch):
    """An open stage is given up at this share of it."""
    through = Leg.through

    def stopped(leg, pause=False):
        if not leg.stage.is_open:
            return through(leg, pause)
        leg.stage = leg.stage._replace(last=min(leg.stage.last, share))
        goes_on = through(leg, pause)
        return leg.run.ends(PathStatus.STUCK) if leg.run.status == PathStatus.UNBOUNDED else goes_on

    patch.setattr(Leg, "through", stopped)
