"""What users pass as a commanded joint offset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, array, number, per_name, read_only

__all__ = ["read_joint_offset"]


def read_joint_offset(value: Any, joints: Sequence[str]) -> Array:
    """(nv,) δq [rad, m] from numbers or a mapping by joint name (others 0); None: 0. Raises InputError, UnknownName."""
    if value is None:
        return read_only(np.zeros(len(joints)))
    if isinstance(value, Mapping):
        named = per_name("joint_offset", value, joints, "a joint")
        given = {joint: number(f"joint_offset[{joint!r}]", v) for joint, v in named.items()}
        return read_only(np.array([given.get(joint, 0.0) for joint in joints]))
    return array("joint_offset", value, (len(joints),))
