"""How a grasp of the table is made again: posture, place of the object, and how hard the hand closes, as numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from handlcp.check import Array
from handlcp.hand.asked.asked import HandAsked
from handlcp.hand.find.clear import Place
from handlcp.hand.find.find import PINCH
from handlcp.hand.find.power import REACH
from handlcp.hand.hand import Hand
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.objects.object import Object
from handlcp.hand.sites.touchers import ALL
from handlcp.hand.state import HandState
from handlcp.record import plain


@dataclass(frozen=True, slots=True)
class Recipe:
    """kind : "pinch" or "power". q (nv,) [rad, m] : the posture in which tips touch, or of the open hand that closes.
    position (3,) [m], rotation (3, 3) of the object, axes of the hand's base. effort : the force (k,) with which each
    fingertip presses on an object that stays where it is [N], or the torque (nv,) with which each joint closes [N·m].
    """

    kind: str
    q: Array
    position: Array
    rotation: Array
    effort: Array

    @classmethod
    def of(cls, kind: str, grasp: HandGrasp) -> Self:
        """Of a grasp that a search found."""
        asked = grasp.spec.asked
        assert isinstance(asked, HandAsked)  # a search made it
        assert isinstance(asked.target, Object)
        R, p = asked.target.frame
        begins = asked.state if asked.bare is None else asked.bare
        effort = asked.grip_force if kind == PINCH else asked.closing_torque
        return cls(kind, np.array(begins.q), np.array(p), np.array(R), np.asarray(effort, dtype=float))

    @classmethod
    def from_row(cls, row: Mapping[str, Any]) -> Self | None:
        """As `to_row` wrote it; None of a row without a grasp."""
        if row.get("q") is None:
            return None
        values = row["q"], row["object_position_m"], row["object_rotation"], row["closing"]
        q, position, rotation, effort = [np.array(value, dtype=float) for value in values]
        return cls(row["kind"], q, position, rotation.reshape(3, 3), effort)

    def to_row(self) -> dict[str, Any]:
        """Plain numbers, to the last bit."""
        return {
            "q": plain(self.q), "object_position_m": plain(self.position),
            "object_rotation": plain(self.rotation.reshape(-1)), "closing": plain(self.effort),
        }  # fmt: skip

    def harder(self, times: float) -> Self:
        """The hand closes so many times as hard."""
        return replace(self, effort=times * self.effort)

    def grasp(self, hand: Hand, obj: Object, friction: Any) -> HandGrasp:
        """By this hand, or one with other numbers. Raises what `state.grasp` raises."""
        state, placed = HandState(hand, self.q), Place(self.q, self.rotation, self.position).of(obj)
        if self.kind == PINCH:
            return state.grasp(placed, friction=friction, grip_force=self.effort)
        return state.grasp(
            placed, friction=friction, closing_torque=self.effort, links=ALL, hold_object=True, max_gap=REACH
        )
