"""Limits on the contact forces, and what gives way at them: the common form of bounds and of joints that yield.

    0 ≤ s ⟂ b - A r ≥ 0,    ε += Aᵀ s

A row of A says what is limited (a normal force, a sum of them, a joint's torque Jᵀr), b how much of it there may be.
While a limit gives way, the contacts move by Aᵀ s. It dissipates only there: A r = b, and the work is bᵀ s.
Source: Ai & Li (2025),
equations (14) to (16), has the first of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Gt, Len, Predicate

from handlcp.check import Array
from handlcp.errors import InputError, UnknownName
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown
from handlcp.lazy import lazy

# ----------------------------------------------------------------
# What asks for an effect in a scene file: a key of [effects], what it holds, and what it means.

Finite = Annotated[float, Predicate(math.isfinite)]
Above0 = Annotated[float, Gt(0)]  # inf is welcome: no bound
From0 = Annotated[float, Ge(0), Predicate(math.isfinite)]
Three = Annotated[list[Finite], Len(3, 3)]


@dataclass(frozen=True, slots=True, eq=False)
class FileKey:
    """name : of the key. holds : its type, in Python's annotations; or the keys of a table. expected : the same in
    words, for refusals. meaning : for `handlcp keys`. many : several tables, one [[effects.name]] each.
    required : whether a table needs it. default : what it is when left out.
    """

    name: str
    holds: Any
    expected: str
    meaning: str
    many: bool = False
    required: bool = False
    default: Any = None

    @property
    def table(self) -> tuple[FileKey, ...]:
        """The keys of a table; none: it holds a value."""
        return self.holds if isinstance(self.holds, tuple) else ()


CONTACT_KEY = FileKey(
    "contact",
    Annotated[int, Ge(0)] | str,
    "a finger's name or a contact's number, counted from 0",
    "which one",
    required=True,
)


def by_finger(key: str, value: Any, fingers: Sequence[str], otherwise: Any) -> Any:
    """A table by finger as a list in the fingers' order, `otherwise` for those left out. Raises UnknownName."""
    if not isinstance(value, dict):
        return value
    if unknown := [name for name in value if name not in fingers]:
        raise UnknownName(key, "a finger", unknown, fingers)
    return [value.get(name, otherwise) for name in fingers]


def contact_number(key: str, value: Any, fingers: Sequence[str]) -> int:
    """Of a contact given by name or by number, counted from 0. Raises UnknownName, InputError."""
    if isinstance(value, str):
        if value not in fingers:
            raise UnknownName(key, "a finger", [value], fingers)
        return list(fingers).index(value)
    if not 0 <= value < len(fingers):
        raise InputError(key, f"a contact's number from 0 to {len(fingers) - 1}", value)
    return int(value)


# ----------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Limit:
    """k limits of one kind, SI.

    name : of the group of unknowns s. rows : (k, c) A over the scene's force components; zero for contacts whose force
    is prescribed. room : (k,) b, finite. levers : (k,) [m] where A r is no force but a torque and s an angle: the
    lengths that turn them into a force and a motion, for natural units; None for forces.
    """

    name: str
    rows: Array
    room: Array
    levers: Array | None = None

    def __post_init__(self) -> None:
        """Read-only: a scene keeps its limits."""
        for array in (self.rows, self.room, self.levers):
            if array is not None:
                array.flags.writeable = False

    @lazy
    def unknown(self) -> Unknown:
        """The group of the s."""
        levers = () if self.levers is None else tuple(self.levers.tolist())
        return Unknown(self.name, len(self.room), False, "motion", levers)

    @lazy
    def natural_rows(self) -> Array:
        """(k, c) A in natural units."""
        return self.rows if self.levers is None else self.rows / self.levers[:, None]

    def natural_room(self, scene: Scene) -> Array:
        """(k,) b in natural units."""
        return self.room / (scene.units.force if self.levers is None else scene.units.force * self.levers)

    def natural_motion(self, scene: Scene, extra: dict[str, Array]) -> Array:
        """(k,) s in natural units; `extra` as in `Effect.opening`."""
        s = extra[self.name] / scene.units.motion
        return s if self.levers is None else s * self.levers

    def stamp(self, scene: Scene, system: System) -> None:
        """Slack, and the motion of the contacts that goes with it."""
        system.couple(self.name, self.natural_rows[:, scene.kind.index], -1.0)
        system.load(self.name, self.natural_room(scene))

    def opening(self, extra: dict[str, Array]) -> Array:
        """(c,) Aᵀ s [m]."""
        s = extra[self.name]
        if not np.isfinite(s).all():
            return np.full(self.rows.shape[1], np.nan)  # which never passes
        return np.asarray(s @ self.rows)

    def residual(
        self, scene: Scene, forces: Array, extra: dict[str, Array], force_size: float, motion_size: float
    ) -> float:
        """Worst |min(s, b - A r)|, relative."""
        units = scene.units
        slack = self.natural_room(scene) - self.natural_rows @ (forces / units.force)
        s = self.natural_motion(scene, extra) * (units.motion / motion_size)
        return float(abs(np.minimum(s, slack * (units.force / force_size))).max(initial=0.0))
