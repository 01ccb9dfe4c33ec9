"""What a hand's joints, motors and tendons bring to its grasps, for `explain()`: springs, friction, slack."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp import words
from handlcp.actuation.joint_stiffness import TRANSMISSION
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array
from handlcp.grasp.model.effect import FOLLOWED_LOADINGS
from handlcp.robot.hand_model import HandModel

ExplanationLine = tuple[str, str, bool, str, str]  # as `HandReport.explanation_lines` has it
_FRICTION_LAW = "against the motion: |τ_f| ≤ {}, and τ_f = -{} sign(q̇) where a joint moves"


def explanation_lines(hand: HandModel, against: Array | None) -> tuple[ExplanationLine, ...]:
    """The lines of `explain()` about springs, friction and tendons of a hand.

    against (nv,) : with which actuators pull against springs beside them, in the grasp's posture [N·m]; None: there are
        none.
    """
    equation, said = hand.stiffness.law
    found = [(TRANSMISSION, equation, bool(said), said or "none: the springs are those of the joints", "")]
    return (*found, *_spring_lines(hand, against), *_joint_friction_lines(hand), *_tendon_lines(hand))


def _spring_lines(hand: HandModel, against: Array | None) -> Iterator[ExplanationLine]:
    """Those that joints have beside actuators and tendons."""
    own, beside = hand.stiffness.joint_springs, hand.stiffness.springs_with_rest
    if (alone := own * (beside == 0.0)).any():
        largest = words.first_largest_index(alone)
        most = f"{float(alone[largest]):.3g} {words.stiffness_unit(hand.joint_names[largest] in hand.sliding)}"
        yield "springs at joints", "K_p", True, f"{_list_joints(hand, alone)}, up to {most}: part of K", ""
    if against is not None:
        text = f"of the file, against which actuators give up to {_format_largest_effort(hand, abs(against))}"
        yield "springs beside actuators", "τ += k (q - θ)", True, text, ""


def _joint_friction_lines(hand: HandModel) -> Iterator[ExplanationLine]:
    """Dry friction of the joints, and of the motors behind them."""
    law = _FRICTION_LAW.format("f", "f")
    of_motors = hand.dry_friction - hand.joint_friction
    for title, rubs in (("joint friction", hand.joint_friction), ("motor friction", of_motors)):
        if rubs.any():
            yield (
                title,
                law,
                True,
                f"up to {_format_largest_effort(hand, rubs)}, {_list_joints(hand, rubs)}",
                FOLLOWED_LOADINGS,
            )


def _tendon_lines(hand: HandModel) -> Iterator[ExplanationLine]:
    """What tendons do that springs do not: they rub, hang slack, and hide the friction of their motors."""
    stiffness = hand.stiffness
    if not isinstance(stiffness, TendonStiffness):
        return
    cables, drives = stiffness.cables, stiffness.drives
    if (cables.wrap_friction > 0.0).any():
        who = words.list_names(
            [cables.names[k] for k in sorted(set(cables.post_tendon[cables.wrap_friction > 0.0].tolist()))]
        )
        most = f"μθ up to {float(cables.wrap_friction.max()):.3g} at one place"
        yield "tendon friction", "t e^(-μθ) ≤ t' ≤ t e^(μθ)", True, f"{who}, {most}", FOLLOWED_LOADINGS
    if (known := np.isfinite(cables.pretension)).any():
        least = words.format_force(float(cables.pretension[known].min()))
        yield (
            "tendons that pull alone",
            "t ≥ 0",
            True,
            f"slack below 0 N; pretension of {least} at least",
            FOLLOWED_LOADINGS,
        )
    if drives is not None and drives.friction.any():
        most = words.format_force(float(drives.friction.max()))
        where = words.list_names(drives.motor_joints(cables.names))
        text = f"up to {most} at {where}: before the cable, so that it changes no force"
        yield "motor friction", "t_m = t ± f", True, f"{text}, but what motors close with and hold", ""


def _format_largest_effort(hand: HandModel, efforts: Array) -> str:
    """Of efforts (nv,), in the unit of its joint."""
    largest = words.first_largest_index(efforts)
    return words.format_effort(float(efforts[largest]), words.effort_unit(hand.joint_names[largest] in hand.sliding))


def _list_joints(hand: HandModel, values: Array) -> str:
    """At which joints values (nv,) are not zero."""
    at = [joint for joint, value in zip(hand.joint_names, values.tolist(), strict=True) if value]
    return "at every joint" if len(at) == hand.nv else f"at {words.list_names(at)}"
