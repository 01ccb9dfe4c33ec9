"""What a hand's joints, motors and tendons bring to its grasps, for `explain()`: springs, friction, slack."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.model.effect import FOLLOWED
from handlcp.hand.elasticity.elasticity import TRANSMISSION
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.robot.model import HandModel

Line = tuple[str, str, bool, str, str]  # as `Mechanism.lines` has it
_BY_MOTION = "against the motion: |τ_f| ≤ {}, and τ_f = -{} sign(q̇) where a joint moves"


def lines_of(hand: HandModel, against: Array | None) -> tuple[Line, ...]:
    """Against (nv,) : with which actuators pull against springs beside them, in the grasp's posture [N·m]; None: there
    are none.
    """
    equation, said = hand.stiffness.law
    found = [(TRANSMISSION, equation, bool(said), said or "none: the springs are those of the joints", "")]
    return (*found, *_springs(hand, against), *_friction_of_joints(hand), *_tendons(hand))


def _springs(hand: HandModel, against: Array | None) -> Iterator[Line]:
    """Those that joints have beside actuators and tendons."""
    own, beside = hand.stiffness.own_springs, hand.stiffness.beside
    if (alone := own * (beside == 0.0)).any():
        largest = words.first_largest(alone)
        most = f"{float(alone[largest]):.3g} {words.stiffness_unit(hand.joint_names[largest] in hand.sliding)}"
        yield "springs at joints", "K_p", True, f"{_some(hand, alone)}, up to {most}: part of K", ""
    if against is not None:
        text = f"of the file, against which actuators give up to {_largest_effort(hand, abs(against))}"
        yield "springs beside actuators", "τ += k (q - θ)", True, text, ""


def _friction_of_joints(hand: HandModel) -> Iterator[Line]:
    """Dry friction of the joints, and of the motors behind them."""
    law = _BY_MOTION.format("f", "f")
    of_motors = hand.dry_friction - hand.joint_friction
    for title, rubs in (("joint friction", hand.joint_friction), ("motor friction", of_motors)):
        if rubs.any():
            yield title, law, True, f"up to {_largest_effort(hand, rubs)}, {_some(hand, rubs)}", FOLLOWED


def _tendons(hand: HandModel) -> Iterator[Line]:
    """What tendons do that springs do not: they rub, hang slack, and hide the friction of their motors."""
    stiffness = hand.stiffness
    if not isinstance(stiffness, TendonStiffness):
        return
    cables, drives = stiffness.cables, stiffness.drives
    if (cables.grips > 0.0).any():
        who = words.listed([cables.names[k] for k in sorted(set(cables.of[cables.grips > 0.0].tolist()))])
        most = f"μθ up to {float(cables.grips.max()):.3g} at one place"
        yield "tendon friction", "t e^(-μθ) ≤ t' ≤ t e^(μθ)", True, f"{who}, {most}", FOLLOWED
    if (known := np.isfinite(cables.pretension)).any():
        least = words.force(float(cables.pretension[known].min()))
        yield "tendons that pull alone", "t ≥ 0", True, f"slack below 0 N; pretension of {least} at least", FOLLOWED
    if drives is not None and drives.friction.any():
        most = words.force(float(drives.friction.max()))
        where = words.listed(drives.names(cables.names))
        text = f"up to {most} at {where}: before the cable, so that it changes no force"
        yield "motor friction", "t_m = t ± f", True, f"{text}, but what motors close with and hold", ""


def _largest_effort(hand: HandModel, efforts: Array) -> str:
    """Of efforts (nv,), in the unit of its joint."""
    largest = words.first_largest(efforts)
    return words.effort(float(efforts[largest]), words.effort_unit(hand.joint_names[largest] in hand.sliding))


def _some(hand: HandModel, values: Array) -> str:
    """At which joints values (nv,) are not zero."""
    at = [joint for joint, value in zip(hand.joint_names, values.tolist(), strict=True) if value]
    return "at every joint" if len(at) == hand.nv else f"at {words.listed(at)}"
