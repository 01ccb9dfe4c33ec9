"""What ends a path before its largest load: joints at torque limits or ends of range, and how far the object moves."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.limits.result import MOTION, OBJECT, RANGE, TORQUE, Bind
from handlcp.grasp.loading.state import State
from handlcp.grasp.loading.step import Stepper

__all__ = ["Watched"]

_SAME = 1e-4  # of its level: what is as near to it as that binds, too
_NONE = 1e-12  # [N·m]: a joint without torque has this


class Watched:
    """Of one path. begun : where the load begins; most : motion [m] and turn [rad] of the object that are allowed."""

    def __init__(self, stepper: Stepper, begun: State, most: tuple[float, float]) -> None:
        self._displacement, watch = stepper.geometry.displacement, stepper.watch
        self._begun, self._most = self._displacement(begun.where.pose), most
        yields = any(isinstance(e, TorqueSaturation) for e in stepper.grasp.spec.effects)
        self._limits = np.full(len(watch.limits), np.inf) if yields else watch.limits
        self._lower, self._upper = watch.lower, watch.upper
        span = watch.upper - watch.lower
        self._span = np.where(np.isfinite(span) & (span > 0.0), span, 1.0)
        joints = watch.joints
        self._who = (*[Bind(TORQUE, j) for j in joints], *[Bind(RANGE, j) for j in joints], *[Bind(MOTION, OBJECT)] * 2)

    def over(self, state: State) -> float:
        """How far the worst of it is beyond its level, as a share; -1 where nothing has any."""
        return float(self._used(state).max()) - 1.0

    def binds(self, state: State) -> tuple[Bind, ...]:
        """What is at its level."""
        used = self._used(state)
        near = np.flatnonzero(used >= min(float(used.max()), 1.0) * (1.0 - _SAME))
        return tuple(dict.fromkeys(self._who[k] for k in near.tolist()))

    def _used(self, state: State) -> Array:
        """(2 nv + 2,) shares of the levels."""
        moved = self._displacement(state.where.pose) - self._begun
        sizes = np.array([np.sqrt(moved[:3] @ moved[:3]), np.sqrt(moved[3:] @ moved[3:])])
        torque = abs(state.read.torque) / np.maximum(self._limits, _NONE)
        outside = np.maximum(state.where.q - self._upper, self._lower - state.where.q) / self._span
        return np.concatenate([torque, 1.0 + outside, sizes / self._most])
