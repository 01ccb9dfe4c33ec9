"""One hand of the gallery: a grasp of each object, as numbers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from handlcp.errors import HandLCPError
from handlcp.grasp.friction import SoftFinger
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.find.find import find_grasp
from handlcp.hand.library import example_hand
from handlcp.hand.objects.object import Object
from handlcp.study.gallery.models import Model

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
class Shelf:
    """One hand and its rows. drawn : whether its picture may stand in the page."""

    hand: str
    source: str
    licence: str
    drawn: bool
    rows: tuple[Row, ...]

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)

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
