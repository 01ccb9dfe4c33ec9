"""What makers and papers state of hands: `stated.toml`, read."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from handlcp.record import Record

FINGERTIP, PINCH, POWER, PAYLOAD = "fingertip", "pinch", "power", "payload"


@dataclass(frozen=True)
class Stated(Record):
    """One number. hand : as it is called. test : what was measured: "fingertip" force, "pinch" or "power" grip force,
    "payload", or another that is not computed here. least, most : the number, or its range. unit : "N" or "kg". by :
    "maker" or "measured". posture, source, date : as far as known. example : the hand's name for `example_hand`; "":
    pip does not bring its file. file : where that is. fingers : tips that take part; () for all. diameter : of what is
    gripped [m].
    """

    hand: str
    test: str
    least: float
    most: float
    unit: str
    by: str
    posture: str
    source: str
    date: str
    example: str = ""
    file: str = ""
    fingers: tuple[str, ...] = ()
    diameter: float | None = None

    @property
    def number(self) -> str:
        """In words, such as "10 N" or "10 to 12 N"."""
        span = f" to {self.most:g}" if self.most > self.least else ""
        return f"{self.least:g}{span} {self.unit}"

    @property
    def what(self) -> str:
        """The test in words, such as "fingertip: index_tip"."""
        return f"{self.test}: {', '.join(self.fingers)}" if self.fingers and self.test == FINGERTIP else self.test


@cache
def stated() -> tuple[Stated, ...]:
    """All of them."""
    text = resources.files("handlcp.design.hardware").joinpath("stated.toml").read_text(encoding="utf-8")
    return tuple([_one(row) for row in tomllib.loads(text)["stated"]])


def _one(row: dict[str, Any]) -> Stated:
    values = {"most": row["least"], **row}
    values["diameter"] = values.pop("diameter_m", None)
    values["fingers"] = tuple(values.get("fingers", ()))
    return Stated(**values)
