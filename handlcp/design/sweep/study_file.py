"""A sweep as a TOML file, for those who write no Python: which hand, which numbers of it vary, which brief."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from handlcp.design.brief import Brief
from handlcp.design.finger_hand import finger_hand
from handlcp.errors import InputError, UnknownName, translate_arguments, why_unreadable
from handlcp.hand.hand import Hand
from handlcp.hand.vary.hand_shape import read_changes
from handlcp.scene import key_types as k
from handlcp.scene.key_types import FileTable
from handlcp.scene.keys import read_tables, read_text_file

_BRIEF = "brief."  # begins the names of parameters of the brief
_URDF = "urdf"  # key of [hand] for a file, beside which may stand:
_BESIDE = ("joint_stiffness", "pad_flexibility", "tip_radius", "torque_limits", "base")
# What a study may say of a hand from numbers and of its brief: numbers of a design, and nothing that names a file
DESIGN_NUMBERS = (
    "fingers", "link_lengths", "palm_radius", "link_radius", "tip_radius", "angles", "tilt", "ranges", "coupling",
    "joint_stiffness", "pad_flexibility", "torque_limits", "joint_friction",
)  # fmt: skip
BRIEF_NUMBERS = (
    "friction", "orientations", "acceleration", "motion", "most_force", "safety", "kind", "squeeze", "grip_force",
    "closing_torque", "tries", "seed",
)  # fmt: skip

_Hand = Annotated[str | dict[str, Any], k.ExpectedWords("a hand's name or file, or a table of numbers for finger_hand")]
_Space = Annotated[dict[str, Any], k.ExpectedWords("a table of parameters")]
_Samples = Annotated[int | dict[str, int], k.ExpectedWords("a whole number, or a table of these by parameter")]


class StudyTables(FileTable):
    """What is swept."""

    hand: _Hand
    """a hand's name, an MJCF or a scene file with a [hand]; or, as [hand], urdf = "my.urdf" beside joint_stiffness,
    pad_flexibility, tip_radius, torque_limits and base, as of `Hand.from_urdf`; or numbers for `finger_hand`"""
    space: _Space
    """parameter = { low = 1.0, high = 2.0 }, with log = true for equal ratios, a list of choices, or one value"""
    brief: k.Text
    """a file, as `handlcp evaluate` reads it"""
    sampling: k.Text = "sobol"
    """"sobol", "lhs" or "grid\""""
    samples: _Samples | None = None
    """how many designs; of a grid levels of each range, for all or by name"""
    seed: k.Seed = 0
    """of the samples"""
    out: k.Text | None = None
    """the table, .parquet or .csv, in the folder of the study or below it; left out: none"""


class StudyFile(NamedTuple):
    """Arguments of `sweep`, and the file that is written."""

    make: Hand | HandFrom
    brief: Brief | BriefFrom
    tables: StudyTables
    out: Path | None


@dataclass(frozen=True, eq=False)
class HandFrom:
    """Makes hands. base : a hand that is varied. numbers : without one, those arguments of `finger_hand` that are
    numbers of a design, which parameters of these names replace; other parameters vary what comes of it.
    """

    base: Hand | None
    numbers: Mapping[str, Any]

    def __call__(self, **values: Any) -> Hand:
        """With these values. Raises what `finger_hand` and `Hand.vary` raise; UnknownName."""
        own = {name: value for name, value in values.items() if not name.startswith(_BRIEF)}
        if (hand := self.base) is None:
            said = {**self.numbers, **{name: own.pop(name) for name in list(own) if "." not in name}}
            if unknown := [name for name in said if name not in DESIGN_NUMBERS]:
                where = "hand" if unknown[0] in self.numbers else "space"
                raise UnknownName(where, "a number of finger_hand", unknown, DESIGN_NUMBERS)
            hand = finger_hand(**said)
        return hand.vary({name: value for key, value in own.items() for name in _meant(hand, key)}) if own else hand


@dataclass(frozen=True, eq=False)
class BriefFrom:
    """Makes briefs: parameters such as "brief.friction" replace what it has."""

    base: Brief

    def __call__(self, **values: Any) -> Brief:
        """With these values. Raises InputError, UnknownName."""
        own = {name.removeprefix(_BRIEF): value for name, value in values.items() if name.startswith(_BRIEF)}
        if unknown := [f"{_BRIEF}{name}" for name in own if name not in BRIEF_NUMBERS]:
            raise UnknownName("space", "a number of the brief", unknown, [f"{_BRIEF}{name}" for name in BRIEF_NUMBERS])
        return replace(self.base, **own)


def load(path: Any, hand: Callable[..., Hand]) -> StudyFile:
    """Read the study of a file; the files that it names are found from its folder.

    What a hand and a brief alone say is the same sweep as in Python.

    hand : makes the hand of a name or a file, as the commands do.

    Raises InputError, and what `hand` raises.
    """
    text, file = read_text_file(path, "a study (TOML)")
    table = read_tables(StudyTables, text, file.name)
    brief = Brief.from_toml(file.parent / table.brief)
    plain = not any(name.startswith(_BRIEF) for name in table.space)
    said = {_URDF: table.hand} if isinstance(table.hand, str) else table.hand
    made = _read(file, said, hand) if _URDF in said else None
    make = HandFrom(made, said)
    whole = made if plain and not any("*" in name for name in table.space) else None
    out = None if table.out is None else _beside(file, table.out)
    return StudyFile(whole or make, brief if plain else BriefFrom(brief), table, out)


def _beside(study: Path, name: str) -> Path:
    """The file that a study writes. Raises InputError for one outside of the study's folder, links followed."""
    try:
        file = study.parent / name
        inside = file.resolve().is_relative_to(study.parent.resolve())
    except (OSError, ValueError, RuntimeError):  # what no file can be called
        inside = False
    if not inside:
        raise InputError("out", "a file in the folder of the study or below it", repr(name)[:200])
    return file


def _read(study: Path, said: Mapping[str, Any], hand: Callable[..., Hand]) -> Hand:
    """The hand of a name or a file, with numbers that the file does not have. Raises InputError, UnknownName."""
    name, more = said[_URDF], {key: value for key, value in said.items() if key != _URDF}
    if not isinstance(name, str):
        raise InputError(f"hand.{_URDF}", "the name of a file", repr(name)[:80])
    if unknown := [key for key in more if key not in _BESIDE]:
        raise UnknownName("hand", f"a key beside {_URDF}", unknown, _BESIDE)
    beside = study.parent / name
    try:
        with translate_arguments({f"--{key.replace('_', '-')}": f"hand.{key}" for key in _BESIDE}):
            base, numbers = more.get("base"), {key: more[key] for key in _BESIDE[:-1] if key in more}
            return hand(Path(name) if why_unreadable(beside) else beside, base, None, **numbers)
    except InputError as error:
        if error.argument != "joint_stiffness":
            raise
        expected = f"a table [hand] with {_URDF} = {name!r} and joint_stiffness in N·m/rad, which a URDF does not have"
        raise InputError("hand", expected, f"{name!r} alone") from None


def _meant(hand: Hand, name: str) -> list[str]:
    """The name; with a * in it, all joints or fingertips that it fits and that have such a number, such as those of all
    fingers for "*_distal.length".
    """
    of, dot, what = name.rpartition(".")
    if "*" not in of:
        return [name]
    every = dict.fromkeys((*hand.kinematics.movable, *hand.joint_names, *hand.fingertips))
    return [f"{one}{dot}{what}" for one in every if fnmatchcase(one, of) and _has(hand, f"{one}.{what}")] or [name]


def _has(hand: Hand, name: str) -> bool:
    try:
        read_changes(hand, {name: None})
    except UnknownName:
        return False
    return True
