"""A hand's grasp with stiffer joints, commanded to close as before."""

from __future__ import annotations

from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.verdict.trials import stiffened
from handlcp.hand.design.changed import gripped


def hand_stiffened(spec: GraspSpec, factor: float) -> GraspSpec | None:
    """With joints so many times as stiff; None: its flexibility is not that of the joints. A grip force stays the
    force that it is; a squeeze stays as deep, and a joint offset as large, and press harder.
    """
    made = stiffened(spec, factor)
    reach = next((e.reach for e in spec.effects if isinstance(e, JointOffset)), None)
    return gripped(made, reach.asked) if made is not None and reach is not None and reach.unit == "N" else made
