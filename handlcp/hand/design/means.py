"""What of a hand's grasp can be changed by a share: its grip, friction, the stiffness and the limits of its joints."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.design.best_change import Means, rougher
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.asked.change import hand_remade
from handlcp.hand.asked.load import weight_of
from handlcp.hand.design.changed import hand_of, with_limits
from handlcp.hand.design.stiffer import hand_stiffened


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
