"""What is asked of fingertips and no command of the joints makes, and a squeeze that goes on from an earlier one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer.verdict import Reason
from handlcp.grasp.effects.joint_offset import JointOffset, Reach
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.squeeze import TOUCHING, TipMotions, overlaps


def motions_of(mechanism: Any, planar: bool, commands: Array | None = None) -> TipMotions:
    """What the actuators of a `HandMechanism` do to the fingers' contacts; or others, with these commands."""
    commands = mechanism.posture.hand.stiffness.commands if commands is None else commands
    return TipMotions.of(mechanism.fingertips, mechanism.jacobian, commands, planar)


def joint_by_joint(mechanism: Any, planar: bool) -> TipMotions:
    """As if every joint had an actuator of its own."""
    return motions_of(mechanism, planar, np.eye(len(mechanism.names)))


def out_of_reach(spec: GraspSpec) -> tuple[Reach, ...]:
    """What no command of the joints makes, of the overlap in the posture, of a preload, and of what is commanded."""
    mechanism: Any = spec.mechanism  # a hand's
    k = spec.of_fingers
    tips, found = motions_of(mechanism, spec.planar), []
    if (inside := overlaps(mechanism.stand_off[:, 2])).any():
        found.append(joint_by_joint(mechanism, spec.planar).overlapping(inside))
    given = mechanism.stand_off - spec.offset[:k]
    given[given[:, 2] < 0.0] = 0.0  # a gap, which nothing has to make
    if abs(given).max(initial=0.0) > TOUCHING:
        found.append(tips.preloaded(given))
    found += [e.reach for e in spec.effects if isinstance(e, JointOffset) and e.reach is not None]
    return tuple([reach for reach in found if not reach.complete])


def reach_reasons(spec: GraspSpec) -> Iterator[Reason]:
    """A warning for each kind of squeeze of which a part is out of reach."""
    for reach in out_of_reach(spec):
        values = {
            "what": reach.what, "unit": reach.unit, "fingers": reach.names, "asked": reach.asked.tolist(),
            "missing": reach.missing.tolist(), "share": reach.share.tolist(),
        }  # fmt: skip
        yield Reason("out_of_reach", "warning", str(reach), values)


def squeezed_further(spec: GraspSpec, depth: float) -> GraspSpec:
    """The grasp with joints commanded on, so that every tip whose force is not prescribed goes deeper by depth [m]."""
    free = set(spec.free_fingers)
    more = np.array([depth if i in free else 0.0 for i in range(spec.of_fingers)])
    return _told(spec, _command(spec) + motions_of(spec.mechanism, spec.planar).deeper(more))


def eased(spec: GraspSpec, share: float) -> GraspSpec:
    """The grasp with this share of its squeeze, commands of the joints included."""
    offset, k = spec.offset.copy(), spec.of_fingers
    offset[:k] *= np.where(offset[:k, 2:] < 0.0, share, 1.0)
    return _told(spec.replace(offset=read_only(offset)), share * _command(spec))


def _command(spec: GraspSpec) -> Array:
    """(nv,) how far the joints are commanded beyond the posture."""
    told = next((e.command for e in spec.effects if isinstance(e, JointOffset)), None)
    mechanism: Any = spec.mechanism
    return np.zeros(len(mechanism.names)) if told is None else told


def _told(spec: GraspSpec, command: Array) -> GraspSpec:
    others = tuple([e for e in spec.effects if not isinstance(e, JointOffset)])
    return spec.replace(effects=(*others, JointOffset(read_only(command))) if command.any() else others)
