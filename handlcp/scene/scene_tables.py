"""All tables of a scene file together, and what may stand beside what."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, PrivateAttr, model_validator

from handlcp.errors import InputError
from handlcp.scene import kinds as k
from handlcp.scene import schema as s
from handlcp.scene.effects_table import asked, effects_table, kinds_with_keys
from handlcp.scene.table import MadeWhenRead, Table

_COMMANDS = ("squeeze_m", "grip_force_N", "joint_offset_rad")  # of [grasp]


class SceneTables(Table):
    """A scene: a hand in a posture around an object, or contacts one by one; the load; how to solve."""

    title: k.Text = ""
    """one line for tables and pictures"""
    description: k.Text = ""
    """for readers of the file"""
    hand: s.HandTable | None = None
    posture: s.PostureTable = Field(default_factory=s.PostureTable)
    object: s.ObjectTable | None = None
    contact: list[s.ContactTable] = Field(default_factory=list)
    environment: list[s.EnvironmentTable] = Field(default_factory=list)
    grasp: s.GraspTable = Field(default_factory=s.GraspTable)
    load: s.LoadTable = Field(default_factory=s.LoadTable)
    effects: Annotated[Table, MadeWhenRead(effects_table)] = Field(default_factory=lambda: effects_table()())
    solve_with: s.SolveTable = Field(default_factory=s.SolveTable, alias="solve")

    _folder: Path = PrivateAttr(default=Path())

    @model_validator(mode="after")
    def _one_kind_of_scene(self) -> SceneTables:
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
            if hand.urdf is not None and springs.count(None) == len(springs):
                words = "the stiffness of the joints (a URDF has no place for it)"
                raise InputError("hand.joint_stiffness_Nm_per_rad", words, "nothing: the key is missing")
            if self.object is None:
                raise InputError("object", "an [object] for the hand to hold", "nothing: the table is missing")
            if "flexibility_m_per_N" in given:
                words = "none with a [hand]: its joints and pads are the flexibility"
                raise InputError("grasp.flexibility_m_per_N", words, "a value")
            self._one_squeeze()
        else:
            for key in ("fingers", "max_gap_m", "finger_weight", *_COMMANDS):
                if key in given:
                    raise InputError(f"grasp.{key}", "a [hand] that it is about", "a scene without one")
            said = asked(self.effects)
            for kind, its in kinds_with_keys():
                if kind.needs_joints and its.name in said:
                    raise InputError(f"effects.{its.name}", "a [hand], whose joints it is about", "a scene without one")
            if "posture" in self.model_fields_set:
                raise InputError("posture", "a [hand] that it is about", "a scene without one")
        return self

    def _one_squeeze(self) -> None:
        """How hard the hand closes is said once."""
        said = [key for key in _COMMANDS if getattr(self.grasp, key) is not None]
        if len(said) > 1:
            raise InputError(f"grasp.{said[1]}", f"at most one of {', '.join(_COMMANDS)}", " and ".join(said))
        if said and said[0] != "joint_offset_rad" and "squeeze_m" in self.posture.model_fields_set:
            expected = f"none beside grasp.{said[0]}, which says how hard the hand closes"
            raise InputError("posture.squeeze_m", expected, self.posture.squeeze_m)

    @property
    def folder(self) -> Path:
        """Where relative paths start: the scene file's folder."""
        return self._folder
