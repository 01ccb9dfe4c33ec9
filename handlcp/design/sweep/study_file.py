"""A sweep as a TOML file, for those who write no Python: which hand, which numbers of it vary, which brief."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from handlcp.design.brief import Brief
from handlcp.design.finger_hand import finger_hand
from handlcp.hand.hand import Hand
from handlcp.scene import kinds as k
from handlcp.scene.kinds import Table
from handlcp.scene.reading import checked, text_of

_BRIEF = "brief."  # begins the names of parameters of the brief


_Hand = Annotated[str | dict[str, Any], k.Expected("a hand's name or file, or a table of numbers for finger_hand")]
_Space = Annotated[dict[str, Any], k.Expected("a table of parameters")]
_Samples = Annotated[int | dict[str, int], k.Expected("a whole number, or a table of these by parameter")]


class StudyTables(Table):
    """What is swept."""

    hand: _Hand
    """a hand's name, a URDF, an MJCF or a scene file with a [hand]; or, as [hand], numbers for `finger_hand`"""
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
    """the table, .parquet or .csv; left out: none"""


class StudyFile(NamedTuple):
    """Arguments of `sweep`, and the file that is written."""

    make: HandFrom
    brief: BriefFrom
    tables: StudyTables
    out: Path | None


@dataclass(frozen=True, eq=False)
class HandFrom:
    """Makes hands. base : a hand that is varied. numbers : without one, arguments of `finger_hand`, which parameters
    of these names replace; other parameters vary what comes of it.
    """

    base: Hand | None
    numbers: Mapping[str, Any]

    def __call__(self, **values: Any) -> Hand:
        """With these values. Raises what `finger_hand` and `Hand.vary` raise."""
        own = {name: value for name, value in values.items() if not name.startswith(_BRIEF)}
        if (hand := self.base) is None:
            first = {name: own.pop(name) for name in list(own) if name in inspect.signature(finger_hand).parameters}
            hand = finger_hand(**{**self.numbers, **first})
        return hand.vary({name: value for key, value in own.items() for name in _meant(hand, key)}) if own else hand


@dataclass(frozen=True, eq=False)
class BriefFrom:
    """Makes briefs: parameters such as "brief.friction" replace what it has."""

    base: Brief

    def __call__(self, **values: Any) -> Brief:
        """With these values. Raises InputError."""
        own = {name.removeprefix(_BRIEF): value for name, value in values.items() if name.startswith(_BRIEF)}
        return replace(self.base, **own)


def load(path: Any, hand: Callable[[Path], Hand]) -> StudyFile:
    """Of a file; others are found from its folder. hand : that of a name or a file. Raises InputError, and what `hand`
    raises.
    """
    text, file = text_of(path, "a study (TOML)")
    table = checked(StudyTables, text, file.name)
    if isinstance(table.hand, str):
        beside = file.parent / table.hand
        make = HandFrom(hand(beside if beside.is_file() else Path(table.hand)), {})
    else:
        make = HandFrom(None, table.hand)
    out = None if table.out is None else file.parent / table.out
    return StudyFile(make, BriefFrom(Brief.from_toml(file.parent / table.brief)), table, out)


def _meant(hand: Hand, name: str) -> list[str]:
    """The name; with a * in it, all that it stands for, such as "*_distal.length" for those of all fingers."""
    of, dot, what = name.rpartition(".")
    if "*" not in of:
        return [name]
    every = dict.fromkeys((*hand.kinematics.movable, *hand.joint_names, *hand.fingertips))
    return [f"{one}{dot}{what}" for one in every if fnmatchcase(one, of)] or [name]
