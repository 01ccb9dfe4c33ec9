"""`TotalForceBound` and `FingerForceBound`: bounds on the sum of normal forces, and on the force of a finger.

The paper's bound on the sum of normal forces: at the bound, the hand opens instead of squeezing harder.

    0 ≤ z̄ ⟂ r̄ - Σ r_N ≥ 0,    ε_N += z̄ for every finger

It is the hand's squeeze that is bounded: contacts of the environment are not in the sum, and z̄ does not open them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, check_init_call, check_number, count_dimensions
from handlcp.errors import InputError
from handlcp.grasp.model.contact import Placement
from handlcp.grasp.model.effect import Above0, Effect, FileKey, Limit, values_by_finger
from handlcp.grasp.model.scene import Scene
from handlcp.words import NEGLIGIBLE_LENGTH, format_length, list_names


@check_init_call()
@dataclass(frozen=True, slots=True)
class TotalForceBound(Effect):
    """Upper bound `limit` [N] > 0 (inf: none) on the sum of all unknown normal forces of fingers."""

    limit: float

    title = "total normal-force bound"
    equation = "0 ≤ z̄ ⟂ r̄ - Σ r_N ≥ 0,  ε_N += z̄"
    when = "An actuator or a fragile object that bears only so much squeeze in all."
    in_python = "effects=[TotalForceBound(6.0)]"
    in_file = "effects.total_force_bound_N = 6.0"
    brings = "1"
    source = "Ai & Li (2025), equations (14) to (16)"
    order = 210
    file_key = FileKey(
        "total_force_bound_N", Above0, "a number > 0 (inf: no bound)", "the most that all normal forces may add up to"
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "limit", check_number("TotalForceBound.limit", self.limit, above=0.0, finite=False))

    def why(self, scene: Scene) -> str:
        return f"asked for: Σ r_N ≤ {self.limit:g} N"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """One, of all normal forces; z̄ is the opening common to all fingers. An infinite bound is none."""
        if not np.isfinite(self.limit):
            return ()
        rows = np.zeros((1, scene.components))
        rows[0, scene.kind.normal_index] = 1.0
        rows[0, 3 * (scene.n - scene.environment) :] = 0.0
        return (Limit("z̄", rows, np.array([self.limit])),)

    def words(self, scene: Scene, names: tuple[str, ...], extra: dict[str, Array]) -> Iterable[str]:
        if (opened := float(extra.get("z̄", np.zeros(1))[0])) > NEGLIGIBLE_LENGTH:
            yield f"the {self.title} is reached and gives way by {format_length(opened)}"

    def shortfall(self, least_total: float | None) -> str | None:
        if least_total is None or not least_total > 1.001 * self.limit:  # so that the two numbers differ in print
            return None
        return f"the total normal force is bounded to {self.limit:.4g} N, and balance needs {least_total:.4g} N"


# ----------------------------------------------------------------
# A bound on the normal force of each finger: at its bound a finger gives way instead of pushing harder.
#
#     0 ≤ z̄_i ⟂ r̄_i - r_N,i ≥ 0,    ε_N,i += z̄_i
#
# The other fingers take over what it leaves.


@check_init_call()
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
    order = 220
    file_key = FileKey(
        "finger_force_bound_N",
        Above0 | list[Above0] | dict[str, Above0],
        "a number > 0 (inf: no bound), one for each contact, or a table by finger",
        "the most that a finger's normal force may be; fingers left out of a table have no bound",
    )

    def __init__(self, limits: Any) -> None:
        name = "FingerForceBound.limits"
        if count_dimensions(limits) == 0:
            bounds: Any = check_number(name, limits, above=0.0, finite=False)
        elif count_dimensions(limits) == 1:
            bounds = tuple(check_number(f"{name}[{i}]", r, above=0.0, finite=False) for i, r in enumerate(limits))
        else:
            raise InputError(name, "a number > 0, or one for each contact", repr(limits))
        object.__setattr__(self, "bounds", bounds)

    @classmethod
    def from_file(cls, value: Any, key: str, fingers: tuple[str, ...]) -> Iterable[Effect]:
        bounds = values_by_finger(key, value, fingers, np.inf)
        if isinstance(bounds, list) and len(bounds) != len(fingers):
            raise InputError(key, f"a number, or {len(fingers)}, one for each contact", f"{len(bounds)}")
        yield cls(bounds)

    def check(self, argument: str, at: Placement, others: tuple[Effect, ...]) -> None:
        """One bound for every finger, or as many as there are fingers or contacts."""
        if isinstance(self.bounds, tuple) and len(self.bounds) not in (at.of_hand, at.n):
            expected = f"a number, or {at.n}, one for each contact"
            if at.of_hand < at.n:
                expected = f"a number, {at.of_hand}, one for each finger, or {at.n}, one for each contact"
            raise InputError(f"{argument}.limits", expected, f"{len(self.bounds)}")

    def why(self, scene: Scene) -> str:
        (limit,) = self.limits(scene)
        if not len(limit.room):
            return "asked for, but no bound is finite"
        low, high = limit.room.min(), limit.room.max()
        return f"asked for: {len(limit.room)} contacts, {low:g}{'' if low == high else f' to {high:g}'} N"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """How far each bounded finger gives way, z̄_i."""
        bounds = self.bounds if isinstance(self.bounds, tuple) else (self.bounds,) * (scene.n - scene.environment)
        every = np.append(bounds, np.full(scene.n - len(bounds), np.inf))
        bounded = np.flatnonzero(scene.force_unknown_mask & np.isfinite(every))
        rows = np.zeros((len(bounded), scene.components))
        rows[np.arange(len(bounded)), 3 * bounded + 2] = 1.0
        return (Limit("z̄_i", rows, every[bounded]),)

    def words(self, scene: Scene, names: tuple[str, ...], extra: dict[str, Array]) -> Iterable[str]:
        for limit in self.present(scene):
            way = extra[limit.name]
            reached = [
                names[int(np.flatnonzero(limit.rows[k])[0]) // 3] for k in np.flatnonzero(way > NEGLIGIBLE_LENGTH)
            ]
            if reached:
                where = list_names(reached)
                yield f"the {self.title} is reached at {where} and gives way by {format_length(float(way.max()))}"
