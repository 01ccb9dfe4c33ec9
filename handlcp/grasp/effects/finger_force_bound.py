"""A bound on the normal force of each finger: at its bound a finger gives way instead of pushing harder.

    0 ≤ z̄_i ⟂ r̄_i - r_N,i ≥ 0,    ε_N,i += z̄_i

The other fingers take up what it leaves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from handlcp.check import dimensions, number
from handlcp.errors import InputError
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.limit import Limit
from handlcp.grasp.joints import Joints
from handlcp.grasp.scene import Scene

__all__ = ["FingerForceBound"]


@dataclass(frozen=True, init=False)
class FingerForceBound(Effect):
    """Upper bounds [N] > 0 on the normal forces: a number for every finger, or one for each; inf: none.

    Contacts whose force is prescribed have no bound, and contacts without a bound no unknown. Those of the environment
    have none, unless there is a number for each contact.
    """

    bounds: float | tuple[float, ...]

    title = "per-finger force bound"
    equation = "0 ≤ z̄_i ⟂ r̄_i - r_N,i ≥ 0,  ε_N,i += z̄_i"
    when = "Fingers that slip a clutch, or spots of the object that bear only so much each."
    in_python = "effects=[FingerForceBound(1.2)]"
    in_file = "effects.finger_force_bound_N = 1.2"
    brings = "1 a bounded contact"
    source = "finger by finger what Ai & Li (2025), equations (14) to (16), say of the sum"

    def __init__(self, limits: Any) -> None:
        name = "FingerForceBound.limits"
        if dimensions(limits) == 0:
            bounds: Any = number(name, limits, above=0.0, finite=False)
        elif dimensions(limits) == 1:
            bounds = tuple(number(f"{name}[{i}]", r, above=0.0, finite=False) for i, r in enumerate(limits))
        else:
            raise InputError(name, "a number > 0, or one for each contact", repr(limits))
        object.__setattr__(self, "bounds", bounds)

    @property
    def opens(self) -> bool:
        """Not without a bound."""
        return bool(np.isfinite(self.bounds).any())

    def for_fingers(self, argument: str, fingers: int, n: int) -> Self:
        """The fingers' bounds, and none for the environment's contacts; bounds for all n stay."""
        bounds = self.bounds if isinstance(self.bounds, tuple) else (self.bounds,) * fingers
        if len(bounds) not in (fingers, n):
            expected = f"a number, {fingers}, one for each finger, or {n}, one for each contact"
            raise InputError(f"{argument}.limits", expected, f"{len(bounds)}")
        return type(self)(bounds + (np.inf,) * (n - len(bounds)))

    def for_grasp(self, argument: str, n: int, joints: Joints | None, others: tuple[Effect, ...]) -> Self:
        """One bound for every contact, or as many as there are contacts."""
        if isinstance(self.bounds, tuple) and len(self.bounds) != n:
            raise InputError(f"{argument}.limits", f"a number, or {n}, one for each contact", f"{len(self.bounds)}")
        return self

    def why(self, scene: Scene) -> str:
        """Asked for, of how many."""
        (limit,) = self.limits(scene)
        if not len(limit.room):
            return "asked for, but no bound is finite"
        low, high = limit.room.min(), limit.room.max()
        return f"asked for: {len(limit.room)} contacts, {low:g}{'' if low == high else f' to {high:g}'} N"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """z̄_i: how far each bounded finger gives way."""
        bounds = np.broadcast_to(np.asarray(self.bounds, dtype=float), (scene.n,))
        bounded = np.flatnonzero(scene.governed_mask & np.isfinite(bounds))
        rows = np.zeros((len(bounded), scene.components))
        rows[np.arange(len(bounded)), 3 * bounded + 2] = 1.0
        return (Limit("z̄_i", rows, bounds[bounded]),)
