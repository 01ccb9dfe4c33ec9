"""A grasp found by one call: postures of a hand and placements of an object in which all fingers touch and hold it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from handlcp.check import integer, yes_or_no
from handlcp.errors import InputError, NoGraspFound
from handlcp.hand.find.found import Found, told
from handlcp.hand.find.search import Search
from handlcp.hand.objects.meshes import what_to_pass
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import ask_for_metres
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.posture import Posture


def find_grasp(
    hand: HandModel,
    obj: Object,
    *,
    friction: Any = None,
    wrench: Any = None,
    gravity: Any = (0.0, 0.0, -9.81),
    squeeze: Any = None,
    grip_force: Any = None,
    fingers: Sequence[str] | None = None,
    tries: int = 256,
    seed: int = 0,
    throw: bool = True,
) -> Found:
    """Place an object between the fingertips so that the hand holds it: grasps, the best first.

    Postures all over the joint ranges are compared, with the object between their fingertips in several orientations.
    From the best, up to `tries`, joints and object move together until all fingers touch and no link is inside the
    object. Where forces within friction balance the load, the grasp is solved; the best ones are varied. The first
    grasp of the result is HELD by `grasp.check()`, which follows it while the hand closes and is loaded; its object
    does not snap elsewhere on the way. The margin of a grasp is the smaller of its friction reserve and its torque
    reserve. Grasps are sorted by their margin, times the share of the fingers that press under the load. See
    `Candidate`.

    obj : its shape and mass count, its placement does not.
    friction, wrench, gravity, squeeze, grip_force : as in `state.grasp`. With neither squeeze nor grip_force each
        finger presses with the normal force that balance needs, planned with 60 % of the friction.
    fingers : names of those that are to touch; None: all.
    tries : placements to begin with, ≥ 1. seed : the same seed finds the same grasps.
    throw : raise NoGraspFound, which says how far the search came, where nothing is found; False: an empty result.

    Raises InputError, also for an object too wide to be meant in metres; UnknownName; URDFError for a fingertip
    without any shape.
    """
    if not isinstance(hand, HandModel):
        raise InputError("hand", "a Hand", repr(hand))
    if not isinstance(obj, Object):
        raise InputError("obj", what_to_pass(obj), repr(obj)[:80])
    ask_for_metres("obj", obj, Posture(hand, hand.neutral).tip_positions)
    tips, tries = hand.tip_numbers("fingers", fingers), integer("tries", tries, 1)
    yes_or_no("throw", throw)
    if squeeze is not None and grip_force is not None:
        raise InputError("grip_force", "None beside a squeeze", repr(grip_force))
    asked = {
        "friction": friction, "wrench": wrench, "gravity": gravity, "squeeze": squeeze, "grip_force": grip_force,
        "fingers": [hand.fingertips[i] for i in tips],
    }  # fmt: skip
    search = Search(hand, tips, obj, asked, integer("seed", seed, 0))
    candidates = search.run(tries)
    if candidates:
        number = "1 grasp" if len(candidates) == 1 else f"{len(candidates)} grasps"
        why = f"{number} of {obj!r} found: {told(search.tried)}"
        return Found(candidates, search.tried, why)
    why = f"no grasp of {obj!r} by all of {', '.join(asked['fingers'])} found: {told(search.tried)}"
    if search.refused:
        why = f"{why}; the best of these: {search.refused[0].doubt}"
    if throw:
        raise NoGraspFound(why, dict(search.tried), tuple(search.refused))
    return Found((), search.tried, why)
