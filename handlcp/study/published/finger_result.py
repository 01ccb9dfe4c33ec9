"""Finger strength: the force with which a fingertip presses on a fixed load cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.record import Record
from handlcp.text_table import TextTable, wrapped

_SOURCE = "NIST SP 1227 (draft, October 2018), finger strength"


@dataclass(frozen=True, eq=False)
class FingerForce(Record):
    """How hard one fingertip presses on a load cell in one posture.

    finger, posture : names. force : the reading of the cell [N]; inf where no torque limit is known. direction (3,) :
    in which the tip presses, the cell's axis, world axes, which are those of the hand's base. at (3,) : the point of
    contact [m]. binds : the joint or the tendon at its limit; "" for none. torques (nv,) : of the joints then [N·m].
    q (nv,) : the posture [rad, m].
    """

    entries = (
        "finger",
        "posture",
        "force_N",
        "direction (3,)",
        "at_m (3,)",
        "binds",
        "torques_Nm (nv,)",
        "q_rad (nv,)",
    )

    finger: str
    posture: str
    force: float
    direction: Array
    at: Array
    binds: str
    torques: Array
    q: Array

    def __str__(self) -> str:
        limit = f"{self.binds} is at its limit" if self.binds else "no limit of its joints is known"
        return f"{self.finger}, {self.posture}: {_newtons(self.force)} N; {limit}"


@dataclass(frozen=True, eq=False)
class FingerStrength(Record):
    """How hard fingertips press on a fixed load cell; made by `finger_strength`.

    rows : one for each finger in each posture. source : the document that has the test.
    """

    entries = ("source", "weakest", "strongest", "rows")

    rows: tuple[FingerForce, ...]
    source: str = _SOURCE

    @property
    def weakest(self) -> FingerForce:
        """The row with the least force."""
        return min(self.rows, key=lambda row: row.force)

    @property
    def strongest(self) -> FingerForce:
        """The row with the largest force."""
        return max(self.rows, key=lambda row: row.force)

    def __str__(self) -> str:
        """What was asked, and a line for each finger in each posture."""
        head = "finger strength: each fingertip against a fixed load cell, until a joint is at its limit"
        rows = [(f"{row.finger}, {row.posture}", row.binds or "–", _newtons(row.force)) for row in self.rows]
        table = TextTable(("finger, posture", "at its limit", "force\nN"), tuple(rows), "<<>")
        return "\n".join([wrapped(head, "  "), "", str(table)])

    def __repr__(self) -> str:
        weak, strong = self.weakest, self.strongest
        forces = f"{words.force(weak.force)} to {words.force(strong.force)}"
        return f"FingerStrength({forces}, {len(self.rows)} rows)"


def _newtons(force: float) -> str:
    return "any" if np.isinf(force) else f"{force:.3g}"
