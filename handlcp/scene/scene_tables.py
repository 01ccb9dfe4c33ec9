"""`SceneTables`: the tables of a file that make a scene: names, effects, friction, and what may stand together."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, PrivateAttr, create_model, model_validator

from handlcp.contact.friction import FrictionLaw, Frictionless, as_law, friction_laws
from handlcp.errors import InputError, UnknownName, translate_arguments
from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.model.effect import FileKey
from handlcp.scene import key_types as k, schema as s
from handlcp.scene.key_types import DeferredTable, ExpectedWords, FileTable
from handlcp.scene.schema import ObjectTable

# ----------------------------------------------------------------
# Names in a scene file: its keys in errors, its fingers in tables.


def check_names(key: str, names: Any, valid: Sequence[str]) -> None:
    """Check that names are among the valid ones. Raises UnknownName."""
    if unknown := [n for n in names if n not in valid]:
        raise UnknownName(key, "a joint" if key == "posture.q_rad" else "a finger", unknown, valid)


# ----------------------------------------------------------------
# The [effects] table of a scene file: a key for each effect that has one, as the effect itself describes it.


def effects_with_keys() -> tuple[tuple[type[Effect], FileKey], ...]:
    """The effects that a scene file may ask for, in order, each with its key."""
    return tuple([(kind, kind.file_key) for kind in effect_kinds() if kind.file_key is not None])


def make_effects_table() -> type[FileTable]:
    """The table of all effects that there are by now."""
    return _make_table("EffectsTable", tuple([key for _, key in effects_with_keys()]))


def given_values(table: FileTable) -> dict[str, Any]:
    """What a table of a file says, by key: values, and tables as mappings of what is written in them."""
    said: dict[str, Any] = table.model_dump(exclude_unset=True)
    return {key: value for key, value in said.items() if value is not False and value is not None and value != []}


@lru_cache(maxsize=64)
def _make_table(name: str, keys: tuple[FileKey, ...]) -> type[FileTable]:
    fields: dict[str, Any] = {key.name: _make_field(key) for key in keys}
    return create_model(name, __base__=FileTable, **fields)


def _make_field(key: FileKey) -> tuple[Any, Any]:
    """Type and default of a key."""
    if key.many:
        return list[_make_table(key.name, key.table)], Field(default_factory=list, description=key.meaning)  # type: ignore[misc]
    held: Any = _make_table(key.name, key.table) if key.table else Annotated[key.holds, ExpectedWords(key.expected)]
    if key.required:
        return held, Field(description=key.meaning)
    return (held | None if key.default is None else held), Field(default=key.default, description=key.meaning)


# ----------------------------------------------------------------
# What a scene file says of friction and of effects asked for by name.


def make_law(value: Any, key: str = "grasp.friction") -> FrictionLaw:
    """The friction law of a checked value, which is that of `key`."""
    if not isinstance(value, dict):
        return Frictionless() if value == "frictionless" else as_law(value, key)
    law = next(law for law in _laws_with_keys() if set(law.file_keys[0]) <= set(value))
    keys = law.file_keys[0] | law.file_keys[1]
    with translate_arguments({f"{law.__name__}.{argument}": f"{key}.{name}" for name, argument in keys.items()}):
        return law.from_file(value)


def is_by_finger(value: Any) -> bool:
    """Whether a friction is a table by finger; that of one law has the law's keys."""
    return isinstance(value, dict) and not any(set(law.file_keys[0]) <= set(value) for law in _laws_with_keys())


def make_effects(table: FileTable, fingers: Sequence[str]) -> tuple[list[Effect], dict[str, str]]:
    """The effects that [effects] asks for; and by argument, such as "effects[1]", the key that it is from.

    fingers : (n,) names.
    """
    effects: list[Effect] = []
    keys: dict[str, str] = {}
    said = given_values(table)
    for kind, key in effects_with_keys():
        if key.name not in said:
            continue
        path = f"effects.{key.name}"
        for effect in kind.from_file(said[key.name], path, tuple(fingers)):
            keys[f"effects[{len(effects)}]"] = path
            effects.append(effect)
    return effects, keys


def _laws_with_keys() -> list[type[FrictionLaw]]:
    return [law for law in friction_laws() if law.file_keys[0]]


# ----------------------------------------------------------------
# All tables of a scene file together, and what may stand beside what.

_COMMAND_KEYS = ("squeeze_m", "grip_force_N", "joint_offset_rad", "closing_torque_Nm")  # of [grasp]


class SceneTables(FileTable):
    """A scene is a hand in a posture around an object, or contacts one by one; the load; and how to solve."""

    title: k.Text = ""
    """one line for tables and pictures"""
    description: k.Text = ""
    """for readers of the file"""
    hand: s.HandTable | None = None
    posture: s.PostureTable = Field(default_factory=s.PostureTable)
    object: ObjectTable | None = None
    contact: list[s.ContactTable] = Field(default_factory=list)
    environment: list[s.EnvironmentTable] = Field(default_factory=list)
    grasp: s.GraspTable = Field(default_factory=s.GraspTable)
    load: s.LoadTable = Field(default_factory=s.LoadTable)
    effects: Annotated[FileTable, DeferredTable(make_effects_table)] = Field(
        default_factory=lambda: make_effects_table()()
    )
    solve_with: s.SolveTable = Field(default_factory=s.SolveTable, alias="solve")

    _folder: Path = PrivateAttr(default=Path())

    @model_validator(mode="after")
    def _check_scene_kind(self) -> SceneTables:
        """A hand with an object, or contacts; and nothing that only the other kind has."""
        hand, given = self.hand, set(self.grasp.model_fields_set)
        if hand is None and not self.contact:
            raise InputError("hand", "a [hand] with an [object], or one [[contact]] or more", "neither")
        for i, part in enumerate(self.environment):
            if part.point_m is not None and self.object is None:
                expected = "position_m, or an [object] that touches the plane"
                raise InputError(f"environment[{i}].point_m", expected, "a scene without one")
        if hand is not None:
            if self.contact:
                came = f"a [hand] and {len(self.contact)} contacts"
                raise InputError("contact", "a [hand] with an [object], or contacts, not both", came)
            if (hand.name is None) == (hand.urdf is None):
                raise InputError("hand", "either name or urdf", "neither" if hand.name is None else "both")
            springs = [hand.joint_stiffness_Nm_per_rad, hand.tendons, hand.synergies]
            if len(springs) - springs.count(None) > 1:
                key = "hand.tendons" if hand.tendons is not None else "hand.synergies"
                words = "one of joint_stiffness_Nm_per_rad, [hand.tendons] and [hand.synergies]"
                raise InputError(key, words, "more than one")
            for path, table in (("hand", hand), ("hand.tendons", hand.tendons)):
                if table is not None and table.motor is not None and table.motors is not None:
                    raise InputError(f"{path}.motors", f"either {path}.motor or {path}.motors", "both")
            motors = [*([] if hand.motor is None else [hand.motor]), *(hand.motors or {}).values()]
            stiff = any(m.stiffness_Nm_per_rad is not None for m in motors)
            if hand.urdf is not None and springs.count(None) == len(springs) and not stiff:
                words = "the stiffness of the joints (a URDF has no place for it)"
                raise InputError("hand.joint_stiffness_Nm_per_rad", words, "nothing: the key is missing")
            if self.object is None:
                raise InputError("object", "an [object] for the hand to hold", "nothing: the table is missing")
            if "flexibility_m_per_N" in given:
                words = "none with a [hand]: its joints and pads are the flexibility"
                raise InputError("grasp.flexibility_m_per_N", words, "a value")
            self._check_one_command()
        else:
            for key in ("fingers", "max_gap_m", "finger_weight", "links", "hold_object", *_COMMAND_KEYS):
                if key in given:
                    raise InputError(f"grasp.{key}", "a [hand] that it is about", "a scene without one")
            said = given_values(self.effects)
            for kind, its in effects_with_keys():
                if kind.needs_joints and its.name in said:
                    raise InputError(f"effects.{its.name}", "a [hand], whose joints it is about", "a scene without one")
            if "posture" in self.model_fields_set:
                raise InputError("posture", "a [hand] that it is about", "a scene without one")
        return self

    def _check_one_command(self) -> None:
        """How hard the hand closes is said once."""
        said = [key for key in _COMMAND_KEYS if getattr(self.grasp, key) is not None]
        if len(said) > 1:
            raise InputError(f"grasp.{said[1]}", f"at most one of {', '.join(_COMMAND_KEYS)}", " and ".join(said))
        if said and said[0] != "joint_offset_rad" and "squeeze_m" in self.posture.model_fields_set:
            expected = f"none beside grasp.{said[0]}, which says how hard the hand closes"
            raise InputError("posture.squeeze_m", expected, self.posture.squeeze_m)
        if self.grasp.links != "tips" and "squeeze_m" in self.posture.model_fields_set:
            expected = "none beside grasp.links: grasp.squeeze_m squeezes contacts on links"
            raise InputError("posture.squeeze_m", expected, self.posture.squeeze_m)

    @property
    def folder(self) -> Path:
        """Where relative paths start: the scene file's folder."""
        return self._folder
