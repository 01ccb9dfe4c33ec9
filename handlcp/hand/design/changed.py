"""A hand's grasp with one thing changed: its motors, its command, its stiffness; and what can be changed by a share."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.grasp.assembly.asked import again
from handlcp.grasp.design.best_change import Means, rougher
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.verdict.trials import stiffened
from handlcp.hand.asked.change import hand_remade
from handlcp.hand.asked.load import weight_of
from handlcp.hand.command import commanded
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.robot.joints import TorqueLimits

# ----------------------------------------------------------------
# A hand's grasp with other motors, or with another command of its joints.


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


# ----------------------------------------------------------------
# What of a hand's grasp can be changed by a share: its grip, friction, the stiffness and the limits of its joints.


def _changes(spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
    much, hand = words.percent(share), hand_of(spec)
    closes = any(isinstance(e, JointOffset) for e in spec.effects) or bool(
        (spec.offset[: spec.of_fingers, 2] < 0).any()
    )
    for way, factor in (("more", 1.0 + share), ("less", 1.0 - share)):
        yield f"{much} {way} grip", hand.eased(spec, factor) if closes else None
    yield f"{much} more friction", rougher(spec, 1.0 + share)
    for way, factor in (("stiffer", 1.0 + share), ("softer", 1.0 - share)):
        yield f"joints {much} {way}", hand_stiffened(spec, factor)
    limited = bool(np.isfinite(hand.limits).any())
    yield f"{much} more torque", with_limits(spec, (1.0 + share) * hand.limits) if limited else None


def _under(spec: GraspSpec, load: Array) -> GraspSpec:
    return hand_remade(spec, {"load": load})


def _own(spec: GraspSpec) -> Array:
    hand = hand_of(spec)
    own: Array = spec.wrench - weight_of(hand.target, hand.gravity, spec.reference)
    own[abs(own) <= 1e-12 * abs(spec.wrench).max()] = 0.0
    return own


means_of_hand = Means(_changes, _under, _own)


# ----------------------------------------------------------------
# A hand's grasp with stiffer joints, commanded to close as before.


def hand_stiffened(spec: GraspSpec, factor: float) -> GraspSpec | None:
    """With joints so many times as stiff; None: its flexibility is not that of the joints. A grip force stays the
    force that it is; a squeeze stays as deep, and a joint offset as large, and press harder.
    """
    made = stiffened(spec, factor)
    reach = next((e.reach for e in spec.effects if isinstance(e, JointOffset)), None)
    return gripped(made, reach.asked) if made is not None and reach is not None and reach.unit == "N" else made
