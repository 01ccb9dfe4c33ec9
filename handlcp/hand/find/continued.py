"""A grasp brought along from one hand to another that is much the same: a neighbour in a space of designs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from handlcp.geometry.object import Object
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.find.find import PINCH
from handlcp.hand.find.pinch import Search, place_of
from handlcp.hand.find.power import PowerSearch
from handlcp.hand.hand import HandState
from handlcp.hand.request import GraspRequest
from handlcp.robot.hand_model import HandModel


def continued(
    hand: HandModel, obj: Object, near: Candidate, asked: Mapping[str, Any], seed: int
) -> Candidate | None:  # fmt: skip
    """The grasp of another hand, made by this one; None: it is lost on the way, or the joints are others.

    Fingertips: joints and object move together from where they are there until all tips touch. The whole hand: it
    closes anew, from the same open posture on the object where it is there. Either is then checked as a grasp that
    `find_grasp` finds. asked : friction, gravity, and how hard the hand closes, as of `find_grasp`.
    """
    before = near.state.hand
    if hand.joint_names != before.joint_names:
        return None
    place = place_of(near.grasp)
    place = replace(place, q=np.clip(place.q, hand.lower, hand.upper))
    if near.kind == PINCH:
        fingers = list(near.grasp.fingertips)
        if any(name not in hand.fingertips for name in fingers):
            return None
        words = {"wrench": None, "squeeze": None, "grip_force": None, **asked, "fingers": fingers}
        words.pop("closing_torque", None)
        found = Search(hand, hand.tip_numbers("fingers", fingers), obj, words, seed).from_place(place)
    else:
        own = near.grasp.spec.asked
        assert isinstance(own, GraspRequest)  # a search made it
        words = {"wrench": None, **{k: v for k, v in asked.items() if k not in ("squeeze", "grip_force")}}
        search = PowerSearch(hand, obj, {"closing_torque": None, **words}, seed)
        state = HandState(hand, np.clip(own.state.q, hand.lower, hand.upper))
        found = search.from_open(state, place.of(obj), own.closing_torque)
    return found[0] if found else None
