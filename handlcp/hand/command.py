"""Squeeze given in joint space: the joints are commanded beyond where they stand, and the contacts are preloaded.

    d -= J δq

The motors pull towards q + δq while the hand stands at q. Left alone the tips would move by J δq; the object's motion
relative to them falls short by as much. It is data, like any preload.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.grasp.entry import Entry
from handlcp.grasp.explain import EffectLine
from handlcp.hand.stiffness import per_name

__all__ = ["COMMAND", "command_line", "read_command"]

COMMAND = Entry(
    title="commanded joint offset",
    equation="d -= J δq",
    when="The hand squeezes because its joints are told to close further than they can.",
    in_python='joint_offset={"finger_1_distal": 0.05}',
    in_file="grasp.joint_offset_rad = { finger_1_distal = 0.05 }",
    brings="none: data",
    source="Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989): joints under position control are springs",
    module=__name__,
)


def read_command(value: Any, joints: Sequence[str]) -> Array:
    """(nv,) δq [rad, m] from as many numbers or a mapping by joint name, 0 for those left out; None: all 0.

    Raises InputError, UnknownName.
    """
    if value is None:
        return read_only(np.zeros(len(joints)))
    if isinstance(value, Mapping):
        named = per_name("joint_offset", value, joints, "a joint")
        given = {joint: number(f"joint_offset[{joint!r}]", v) for joint, v in named.items()}
        return read_only(np.array([given.get(joint, 0.0) for joint in joints]))
    return array("joint_offset", value, (len(joints),))


def command_line(joints: Sequence[str], command: Array) -> EffectLine:
    """What `explain` says of it."""
    moved = [f"{joint} {x:+.3g}" for joint, x in zip(joints, command.tolist(), strict=True) if x]
    some = f"{', '.join(moved[:4])}{f' and {len(moved) - 4} more' if len(moved) > 4 else ''} rad: data, in the offsets"
    return EffectLine(COMMAND.title, COMMAND.equation, bool(moved), some if moved else "none given", ())
