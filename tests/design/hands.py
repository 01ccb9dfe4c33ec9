"""A pinch whose motors can be written down, and a cube in three fingers."""

from __future__ import annotations

from functools import cache
from typing import Any

import handlcp as hl
from tests.hand.levers import lever_hand, lever_pinch

G = 9.81


STIFF, PAD = 2e4, 1e-7  # N·m/rad, m/N: motions are so small that levers stay what they are


def pinch(folder: Any, force: Any = (0.0, 0.0, -1.0), limits: Any = None, hand: Any = (), **more: Any) -> hl.HandGrasp:
    """The pinch of `tests.hand.levers`, its URDF in this folder. limits : of the joints' torques. hand : more of it."""

    def write(text: str) -> Any:
        path = folder / "levers.urdf"
        path.write_text(text, encoding="utf-8")
        return path

    settings = {"torque_limits": limits, "joint_stiffness": STIFF, "pad_flexibility": PAD} | dict(hand)
    return lever_pinch(lever_hand(write, **settings), force, **more)


@cache
def cube_grasp(mass: float = 0.5, limits: float = 2.0) -> hl.HandGrasp:
    """A cube in three fingers, two on one side and a thumb."""
    hand = hl.example_hand("three_finger", joint_stiffness=60.0, torque_limits=limits)
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=mass)
    return hand.at(hand.close_on(cube)).grasp(cube, friction=0.8)
