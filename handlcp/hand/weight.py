"""The fingers' own weight: torques that hold it, and joints that sag under it before anything is loaded.

    τ = Jᵀ f + g(q),    d += J K⁻¹ g(q)

g(q) is the torque that holds the links in the posture q. A joint of stiffness K that is told to be at q holds it by
giving way: it ends at q - K⁻¹ g, its fingertip J K⁻¹ g lower, so that the object lies that far off, seen from the tip.
The same K⁻¹ (Jᵀ f + g) is the deflection of the joints.
"""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.grasp.entry import Entry
from handlcp.grasp.explain import EffectLine

__all__ = ["WEIGHT", "FingerWeight", "line", "read_weight", "tip_motion"]

FingerWeight: TypeAlias = bool | Literal["torques"]

WEIGHT = Entry(
    title="finger weight",
    equation="τ += g(q),  d += J K⁻¹ g(q)",
    when="Fingers heavy beside what they hold, or joints soft enough to sag.",
    in_python="finger_weight=True",
    in_file="grasp.finger_weight = true",
    brings="none: data",
    source="Siciliano et al., Robotics (2009), chapter 7",
    module=__name__,
)


def read_weight(value: Any) -> FingerWeight:
    """False, True or "torques". Raises InputError."""
    if isinstance(value, bool) or (isinstance(value, str) and value == "torques"):
        return True if value is True else "torques" if value else False
    raise InputError("finger_weight", 'True, False or "torques"', repr(value))


def tip_motion(jacobian: Array, joints: Array, planar: bool) -> Array:
    """(n, 3) J δ [m, contact axes]: how far joints that move by δ (nv,) [rad, m] take the tips; with the sag K⁻¹ g,
    how far the object lies off the tips that sag away from it.

    planar : what lies across the plane is left out.
    """
    offset = np.asarray(jacobian @ joints).reshape(-1, 3)
    if planar:
        offset[:, 1] = 0.0
    return offset


def line(weight: FingerWeight, torque: Array, offset: Array) -> EffectLine:
    """For `explain()`: torque (nv,) g(q) [N·m], offset (n, 3) of the tips [m]."""
    why = "not asked for"
    if weight:
        why = f"asked for: up to {abs(torque).max(initial=0.0):.3g} N·m in a joint"
        moved = float(np.sqrt((offset * offset).sum(axis=1)).max(initial=0.0))
        why += f", a fingertip sags by up to {moved:.3g} m" if weight is True else "; the posture has sagged already"
    return EffectLine(WEIGHT.title, WEIGHT.equation, bool(weight), why, ())
