"""`Effect`: one physical effect of a grasp, and what it adds to the problem; `Limit`: a bound on the forces, as one.

    0 ≤ s ⟂ b - A r ≥ 0,    ε += Aᵀ s

A row of A says what is limited (a normal force, a sum of them, a joint's torque Jᵀr), b how much of it there may be.
While a limit gives way, the contacts move by Aᵀ s. It dissipates only there: A r = b, and the work is bᵀ s.
Source: Ai & Li (2025), equations (14) to (16), has the first of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from annotated_types import Ge, Gt, Len, Predicate

from handlcp.check import Array
from handlcp.contact.friction import Section
from handlcp.errors import InputError, UnknownName
from handlcp.grasp.model.contact import Contact, Placement
from handlcp.grasp.model.equation_system import EquationSystem, Unknown
from handlcp.grasp.model.mechanism import JointReading
from handlcp.grasp.model.scene import Scene
from handlcp.lazy_property import lazy_property

# ----------------------------------------------------------------
# What asks for an effect in a scene file: a key of [effects], what it holds, and what it means.

Finite = Annotated[float, Predicate(math.isfinite)]
Above0 = Annotated[float, Gt(0)]  # inf is welcome: no bound
From0 = Annotated[float, Ge(0), Predicate(math.isfinite)]
Three = Annotated[list[Finite], Len(3, 3)]


@dataclass(frozen=True, slots=True, eq=False)
class FileKey:
    """A key of [effects] in a scene file, or of a table there.

    name : of the key.
    holds : its type, in Python's annotations; or the keys of a table.
    expected : the same in words, for refusals.
    meaning : for `handlcp keys`.
    many : several tables, one [[effects.name]] each.
    required : whether a table needs it.
    default : what it is when left out.
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


def values_by_finger(key: str, value: Any, fingers: Sequence[str], otherwise: Any) -> Any:
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

    name : of the group of unknowns s. rows : (k, c) A over the scene's force components in law axes
    (`scene.rows_to_law_axes` makes them of rows in contact axes); zero for contacts whose force is prescribed.
    room : (k,) b, finite. levers : (k,) [m] where A r is no force but a torque and s an angle: the lengths that turn
    them into a force and a motion, for natural units; None for forces.
    """

    name: str
    rows: Array
    room: Array
    levers: Array | None = None

    def __post_init__(self) -> None:
        """Make the arrays read-only, since a scene keeps its limits."""
        for array in (self.rows, self.room, self.levers):
            if array is not None:
                array.flags.writeable = False

    @lazy_property
    def unknown(self) -> Unknown:
        """The group of the s."""
        levers = () if self.levers is None else tuple(self.levers.tolist())
        return Unknown(self.name, len(self.room), False, "motion", levers)

    @lazy_property
    def natural_rows(self) -> Array:
        """(k, c) A in natural units."""
        return self.rows if self.levers is None else self.rows / self.levers[:, None]

    def natural_room(self, scene: Scene) -> Array:
        """(k,) b in natural units."""
        return self.room / (scene.units.force_unit if self.levers is None else scene.units.force_unit * self.levers)

    def natural_motion(self, scene: Scene, extra: dict[str, Array]) -> Array:
        """(k,) s in natural units; `extra` as in `Effect.opening`."""
        s = extra[self.name] / scene.units.motion_unit
        return s if self.levers is None else s * self.levers

    def stamp(self, scene: Scene, system: EquationSystem) -> None:
        """Slack, and the motion of the contacts that goes with it."""
        system.couple(self.name, self.natural_rows[:, scene.kind.index], -1.0)
        system.load(self.name, self.natural_room(scene))

    def opening(self, extra: dict[str, Array]) -> Array:
        """The motion (c,) by which the limits give way at each force component, Aᵀ s [m]."""
        s = extra[self.name]
        if not np.isfinite(s).all():
            return np.full(self.rows.shape[1], np.nan)  # which never passes
        return np.asarray(s @ self.rows)

    def residual(
        self, scene: Scene, forces: Array, extra: dict[str, Array], force_size: float, motion_size: float
    ) -> float:
        """The largest violation |min(s, b - A r)| of the limits, relative to the sizes of forces and motions."""
        units = scene.units
        slack = self.natural_room(scene) - self.natural_rows @ (forces / units.force_unit)
        s = self.natural_motion(scene, extra) * (units.motion_unit / motion_size)
        return float(abs(np.minimum(s, slack * (units.force_unit / force_size))).max(initial=0.0))


# ----------------------------------------------------------------
# What an effect is: what it adds to a grasp, its words, and how its own law is checked.
#
# An effect is one class in a file of `handlcp.grasp.effects`, found by its class: it stands in no list. It may
#
#     add flexibility or an offset to the grasp   `added_flexibility`, `added_offset`, `prescribed`
#     bring unknowns and stamp their rows         `limits`, or `unknowns` with `stamp`, `opening` and `residual`
#     depend on the forces of the answer          `depends_on_forces`, `under`
#     read something off an answer                `read`


@dataclass(frozen=True, slots=True)
class EffectTrial:
    """An effect to try, if there is need to: None where `words` say all. change : what it makes of the answer at least,
    as a share. instead : whether `words` stand instead of those on the forces, or before them.
    """

    effect: Effect | None
    change: float = 0.0
    words: str = ""
    instead: bool = False


_LAW_METHODS = ("unknowns", "stamp", "opening", "residual")  # what an effect with a law of its own overrides

FOLLOWED_LOADINGS = "followed loadings alone"  # which answers count an effect that not all of them do
ONE_SOLVE = "one solve alone"

# Effects whose limits a scene keeps: a grasp has few, and who tries many others on it piles up nothing
_MAX_KEPT_EFFECTS = 16
_KINDS: dict[tuple[str, str], type[Effect]] = {}


class Effect:
    """One physical effect; subclasses override what they need.

    title : what `explain()` calls it. equation : its law in one line. when : who wants it. in_python, in_file : how to
    ask for it; "": every grasp has it. brings : its unknowns. source : where the law is from.
    order : place in lists, and among the effects that a scene's data call for the place in which they are stamped.
    file_key : the key of a scene file's [effects] that asks for it; None: no key does.
    by_name : whether it is asked for in `effects=`, not by an argument of its own.
    needs_joints : whether only the grasp of a hand can have it.
    depends_on_forces : whether what it adds to the grasp depends on the forces of the answer.
    answers : words for `explain()` of which answers count it, `FOLLOWED_LOADINGS` or `ONE_SOLVE`; "": every answer. It
        refuses nothing.
    """

    title: ClassVar[str] = ""
    equation: ClassVar[str]
    when: ClassVar[str]
    in_python: ClassVar[str] = ""
    in_file: ClassVar[str] = ""
    brings: ClassVar[str]
    source: ClassVar[str]
    order: ClassVar[int] = 1000
    file_key: ClassVar[FileKey | None] = None
    by_name: ClassVar[bool] = True
    needs_joints: ClassVar[bool] = False
    depends_on_forces: ClassVar[bool] = False
    answers: ClassVar[str] = ""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if vars(cls).get("title"):  # what has no title of its own is a base, or a variant, of others
            # By name: dataclass(slots=True) makes a class a second time
            _KINDS[cls.__module__, cls.__qualname__] = cls

    # ---- whether a scene has it
    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        """The effect where the scene's own data call for it; None where it has to be asked for by name."""
        return None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """Why a scene is without it, for `explain()`; None: not worth a line."""
        return "not asked for"

    @property
    def key(self) -> object:
        """A grasp has one effect of each key: of its kind, unless a kind says otherwise."""
        return type(self)

    def check(self, argument: str, at: Placement, others: tuple[Effect, ...]) -> None:
        """Raises InputError where the effect, called `argument`, does not fit the grasp or its effects;
        others : all of them, this one too.
        """

    @classmethod
    def from_file(cls, value: Any, key: str, fingers: tuple[str, ...]) -> Iterable[Effect]:
        """The effects that a scene file asks for with `value` at `file_key`; `key` is its full name, for refusals.

        value : as `FileKey.holds` says; tables are mappings. fingers : names of the contacts, in order.
        """
        if value is not False:
            yield cls() if value is True else cls(value)  # type: ignore[call-arg]

    def why(self, scene: Scene) -> str:
        """Why the scene has this effect, for `explain()`."""
        raise NotImplementedError

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any] | None:
        """Changes of the grasp's specification, by field, that leave the effect out; {}: dropping it from the effects
        asked for does; None: no grasp is without it. contacts : those of the specification.
        """
        return {}

    @classmethod
    def trial(cls, at: Placement, others: tuple[Effect, ...], forces: Array, torque: Array) -> EffectTrial | None:
        """The effect as it would be beside others at an answer without it, to see what it would change; None: that
        takes numbers that nobody gave. forces (n, 3) [N] in contact axes; torque (nv,) [N·m], of a hand.
        """
        return None

    # ---- what it adds to the grasp
    def prescribed(self) -> dict[int, Array]:
        """Forces (3,) [N] in contact axes that are known, by contact: such a contact has no unknowns and no laws."""
        return {}

    def added_flexibility(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """(c, c) flexibility in contact axes [m/N], symmetric, that it adds; soft : contacts that bear a moment."""
        return None

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """(c,) motion of the object relative to the tips before any load, contact axes [m, rad], that it adds."""
        return None

    def added_torque(self) -> Array | None:
        """(nv,) [N·m] that the joints hold besides that of the contact forces."""
        return None

    def under(self, at: Placement, forces: Array, others: tuple[Effect, ...]) -> Effect | str:
        """The effect again, with what it adds (E, d or both) under forces (n, 3) [N] of the fingers, contact axes; or,
        in words, why there is none. others : the effects of the grasp; in a solve this one is among them.

        E(f) f + d(f) is the whole motion at the forces f, not its rate there. The solve is repeated until forces and E
        stay. It asks effects in `spec.effects` alone, and a followed loading asks none.
        """
        return self

    # ---- its unknowns and rows
    @property
    def stamps(self) -> bool:
        """Whether it has rows or a law of its own, so that a solve takes the general path."""
        kind = type(self)
        return any(getattr(kind, name) is not getattr(Effect, name) for name in ("limits", *_LAW_METHODS))

    @property
    def only_limits(self) -> bool:
        """Whether its unknowns and laws are limits that give way, or none. Searches, and the question what a solution
        leaves free, know no others beside forces and motion of the object: beside `unknowns`, a `stamp`, an `opening`
        or a `residual` of its own, neither is asked.
        """
        kind = type(self)
        return all(getattr(kind, name) is getattr(Effect, name) for name in _LAW_METHODS)

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """Limits on the forces that give way: where an effect is made of them alone, nothing below needs saying.

        Asked once a scene; everyone else reads `present`.
        """
        return ()

    def present(self, scene: Scene) -> tuple[Limit, ...]:
        """The limits, without groups of none."""
        if type(self).limits is Effect.limits:
            return ()
        known: tuple[Limit, ...]
        for effect, known in scene.effect_cache:
            if effect is self:
                return known
        known = tuple([limit for limit in self.limits(scene) if len(limit.room)])
        if len(scene.effect_cache) >= _MAX_KEPT_EFFECTS:
            scene.effect_cache.clear()
        scene.effect_cache.append((self, known))
        return known

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """The groups this effect brings."""
        return tuple([limit.unknown for limit in self.present(scene)])

    def stamp(self, scene: Scene, system: EquationSystem) -> None:
        """Add this effect's blocks."""
        for limit in self.present(scene):
            limit.stamp(scene, system)

    def opening(self, scene: Scene, extra: dict[str, Array]) -> Array | None:
        """(c,) motion between object and fingertips that this effect adds to Gᵀu + E r + d [m], over the scene's
        components.

        `extra` holds the unknowns that effects brought beyond forces and object motion, by group name, SI; a group of
        none is left out. They may be anything a solver proposed: where they are not finite, return NaN, which never
        passes. None: nothing.
        """
        parts = [limit.opening(extra) for limit in self.present(scene)]
        return sum(parts[1:], parts[0]) if parts else None

    def residual(
        self, scene: Scene, forces: Array, extra: dict[str, Array], force_size: float, motion_size: float
    ) -> float:
        """How far a candidate misses this effect's own law, relative to force_size [N] and motion_size [m]: the largest
        of the candidate, at least the load and what it moves. forces (c,) N, all of them, prescribed ones too, in the
        coordinates of the friction laws (`Scene`). NaN where they or `extra` are not finite.

        The laws of balance, contact and friction are recomputed by the certifier itself.
        """
        parts = [limit.residual(scene, forces, extra, force_size, motion_size) for limit in self.present(scene)]
        return max(parts, default=0.0) if sum(parts) == sum(parts) else np.nan  # max passes over NaN, a sum does not

    # ---- what it says of an answer
    def read(self, scene: Scene, forces: Array, extra: dict[str, Array], joints: JointReading) -> JointReading:
        """What it changes in what the joints do at an answer; forces (n, 3) [N] in contact axes, extra as above."""
        return joints

    def words(self, scene: Scene, names: tuple[str, ...], extra: dict[str, Array]) -> Iterable[str]:
        """What a verdict says of it at an answer, in parts of a sentence; names (n,) of the contacts."""
        return ()

    @property
    def called(self) -> str:
        """What it is called where it leaves no forces that balance the load."""
        return self.title

    def shortfall(self, least_total: float | None) -> str | None:
        """Why no forces within it balance the load, where the least sum of normal forces that do [N] tells."""
        return None


def effect_kinds() -> tuple[type[Effect], ...]:
    """All effects there are, in order."""
    return tuple(sorted(_KINDS.values(), key=lambda kind: kind.order))
