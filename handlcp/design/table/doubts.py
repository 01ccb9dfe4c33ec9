"""What is doubted of a hand, and how its payload is bounded: the same grasp made again with other numbers.

    friction          0.4 and 1.0       of all contacts; 0.6 is taken
    torque limits     half and twice    where the audit doubts them; the hand then closes half or twice as hard
    springs and pads  half and twice    where one number was passed for all joints: no file says how stiff they are

One at a time. What the hand is asked to do stays otherwise: the force of each fingertip, or the torque with which each
joint closes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from handlcp.design.table.recipe import Recipe
from handlcp.hand.hand import Hand
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.audit import Audit

FRICTION, LEAST_FRICTION, MOST_FRICTION = 0.6, 0.4, 1.0
_HALF, _TWICE = 0.5, 2.0


class Variation(NamedTuple):
    """says : what differs, in words. make : the grasp with it. lower : whether less is held then, as far as one can
    tell beforehand: it is followed no further than the least payload that is known.
    """

    says: str
    make: Callable[[Hand, Object, Recipe], HandGrasp]
    lower: bool


def variations(hand: Hand, audit: Audit) -> list[Variation]:
    """Of a hand; those that decide most often come first."""
    found = [_with_friction(LEAST_FRICTION), _with_friction(MOST_FRICTION)]
    if any(doubt.about == "torque limit" for doubt in audit.serious) and np.isfinite(hand.torque_limits).any():
        found += [_with_limits("half", _HALF), _with_limits("twice", _TWICE)]
    if any(doubt.about == "stiffness" for doubt in audit):
        found += [_with_springs("half", _HALF), _with_springs("twice", _TWICE)]
    return found


def doubts_said(hand: Hand, audit: Audit) -> str:
    """The doubts that can change a verdict, in words, and what is not judged because of them; "" for none."""
    told = [doubt.what.partition(":")[0].partition(";")[0] for doubt in audit.serious]
    unlimited = not np.isfinite(hand.torque_limits).any()
    return "; ".join(dict.fromkeys([*told, *(["motors are not judged"] if unlimited else [])]))


def with_friction(friction: float) -> str:
    """In words."""
    return f"friction {friction:g}"


def _with_friction(friction: float) -> Variation:
    return Variation(
        with_friction(friction), lambda hand, obj, recipe: recipe.grasp(hand, obj, friction), friction < FRICTION
    )


def _with_limits(word: str, times: float) -> Variation:
    def make(hand: Hand, obj: Object, recipe: Recipe) -> HandGrasp:
        known = zip(hand.joint_names, hand.torque_limits.tolist(), strict=True)
        limits = {f"{name}.torque_limit": times * limit for name, limit in known if np.isfinite(limit)}
        return recipe.harder(times).grasp(hand.vary(limits), obj, FRICTION)

    return Variation(f"{word} the torque limits", make, times < 1.0)


def _with_springs(word: str, times: float) -> Variation:
    def make(hand: Hand, obj: Object, recipe: Recipe) -> HandGrasp:
        pads = {tip: float(block[0, 0]) / times for tip, block in zip(hand.fingertips, hand.pads.blocks, strict=True)}
        stiffness = times * float(hand.stiffness.matrix[0, 0])
        return recipe.grasp(hand.vary({"joint_stiffness": stiffness, "pad_flexibility": pads}), obj, FRICTION)

    return Variation(f"springs and pads {word} as stiff", make, False)
