"""A hand's grasp with other motors, or with another command of its joints."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.assembly.asked import again
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.command import commanded
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.robot.joint_limits import TorqueLimits


def hand_of(spec: GraspSpec) -> HandMechanism:
    """The hand of a hand's grasp."""
    assert isinstance(spec.mechanism, HandMechanism)
    return spec.mechanism


def with_limits(spec: GraspSpec, limits: Array) -> GraspSpec:
    """The grasp by a hand whose motors have these limits (nv,) [N·m], inf for none; all of them count as known."""
    joints = hand_of(spec).names
    made = hand_of(spec).limited(TorqueLimits(read_only(limits), (True,) * len(joints), joints))
    asked = None if spec.asked is None else again(spec.asked, {"state": made.posture})
    return spec.replace(mechanism=made, asked=asked)


def gripped(spec: GraspSpec, force: Array) -> GraspSpec:
    """The grasp with normal forces (k,) [N] commanded at the fingertips, in place of its own command."""
    return commanded(spec, None, np.asarray(force), None)
