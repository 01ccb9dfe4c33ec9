"""Reading a scene file: TOML in, a checked `SceneFile` out, or one error that lists everything wrong with it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import Field, PrivateAttr, ValidationError, model_validator

from handlcp.errors import InputError, SceneFileError
from handlcp.scene import kinds as k
from handlcp.scene.refusals import refused
from handlcp.scene.schema import (
    ContactTable,
    EffectsTable,
    EnvironmentTable,
    GraspTable,
    HandTable,
    LoadTable,
    ObjectTable,
    PostureTable,
    SolveTable,
    Table,
)

if TYPE_CHECKING:
    from handlcp.grasp import Grasp, GraspSolution
    from handlcp.hand import Object

__all__ = ["SceneFile", "load", "read"]


class SceneFile(Table):
    """A scene: a hand in a posture around an object, or contacts one by one; the load; how to solve.

    Immutable. `folder` is where relative paths start.
    """

    title: k.Text = ""
    """one line for tables and pictures"""
    description: k.Text = ""
    """for readers of the file"""
    hand: HandTable | None = None
    posture: PostureTable = Field(default_factory=PostureTable)
    object: ObjectTable | None = None
    contact: list[ContactTable] = Field(default_factory=list)
    environment: list[EnvironmentTable] = Field(default_factory=list)
    grasp: GraspTable = Field(default_factory=GraspTable)
    load: LoadTable = Field(default_factory=LoadTable)
    effects: EffectsTable = Field(default_factory=EffectsTable)
    solve_with: SolveTable = Field(default_factory=SolveTable, alias="solve")

    _folder: Path = PrivateAttr(default=Path())

    @model_validator(mode="after")
    def _one_kind_of_scene(self) -> SceneFile:
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
        else:
            for key in ("fingers", "max_gap_m", "finger_weight", "joint_offset_rad"):
                if key in given:
                    raise InputError(f"grasp.{key}", "a [hand] that it is about", "a scene without one")
            if self.effects.torque_saturation:
                raise InputError(
                    "effects.torque_saturation", "a [hand] whose joints have limits", "a scene without one"
                )
            if self.effects.geometric_stiffness:
                raise InputError("effects.geometric_stiffness", "a [hand] whose joints give way", "a scene without one")
            if "posture" in self.model_fields_set:
                raise InputError("posture", "a [hand] that it is about", "a scene without one")
        return self

    @property
    def folder(self) -> Path:
        """Where relative paths start: the scene file's folder."""
        return self._folder

    def build(self) -> Grasp:
        """The grasp: a `HandGrasp` when there is a [hand], else a `Grasp`. Raises InputError, naming the key."""
        from handlcp.scene.build import build

        return build(self)

    def shape(self) -> Object | None:
        """The object, or None where the file has none."""
        from handlcp.scene.build import shape

        return shape(self)

    def solve(self, throw: bool = True) -> GraspSolution:
        """Build and solve as the file says; see `Grasp.solve`."""
        from handlcp.lcp import Auto

        return self.build().solve(self.solve_with.faces, Auto(seed=self.solve_with.seed), throw)


def load(path: Any) -> SceneFile:
    """Read a scene file. Raises SceneFileError for one that is missing, is no TOML, or does not describe a scene."""
    try:
        file = Path(path)
    except TypeError:
        raise InputError("path", "the path of a scene file", repr(path)) from None
    if not file.is_file():
        what = "is no file" if file.exists() else "does not exist"
        raise SceneFileError("path", "the path of a scene file", f"{str(file)!r}, which {what}")
    try:
        text = file.read_bytes().decode()
    except (OSError, UnicodeDecodeError) as error:
        raise SceneFileError("path", "a scene file in UTF-8", f"{str(file)!r}: {error}") from None
    return read(text, file.parent, file.name)


def read(text: str, folder: Any = ".", label: str = "scene") -> SceneFile:
    """The same from a string; relative paths start at `folder`, errors start with `label`."""
    if not isinstance(text, str):
        raise InputError("text", "a string of TOML", type(text).__name__)
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneFileError(label, "TOML", str(error)) from None
    try:
        scene = SceneFile.model_validate(raw)
    except ValidationError as error:
        raise refused(label, error) from None
    scene._folder = Path(folder)
    return scene
