"""Power grasps beside MuJoCo: what links press, and the load at which the object is lost, in six directions.

`python -m tests.mujoco power [word ...]` compares with the rows of `power.json`, every case, or those whose titles hold
one of the words; exit 1 where the measure below is missed. `power --write [word ...]` computes rows with MuJoCo, half a
minute each, and keeps those that are there; `power --again [word ...]` those, too; `power --slow [word ...]` asks
MuJoCo again where a row misses the loss, see below.

The measure: held or dropped the same in 24 of 25; forces summed by link within 3 % of the largest, after the squeeze
and under half of the load that is held; the first jump and the loss within 5 %; with pads that are known within a
factor of two, MuJoCo's forces within `force_bounds` (`tests.mujoco.power_pads`), all of them.

An object that jumps by a centimetre is caught again or not: statics does not know which, as that hangs on how fast it
flies and how fast fingers follow. So where handlcp's path ends at a jump, it claims nothing beyond, and MuJoCo's loss
may come later. Contacts may slide any distance here: MuJoCo stops at none. Where the loss is missed MuJoCo is asked a
second time, with an object that is damped ten times as much. Where it then says something else its loss is the whole
span between its two answers. Where handlcp's path is given up, which is said ("undecided"), or a joint is at its limit,
it claims nothing beyond.
"""

from __future__ import annotations

import pathlib
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import mujoco
import numpy as np

from handlcp.simulator import SimulatorSettings, simulate_limit
from tests.mujoco import power_pads
from tests.mujoco.case import chosen, read_rows, write_rows
from tests.mujoco.find_power_grasps import FILE, made
from tests.mujoco.limit_truth import Truth

ROWS = pathlib.Path(__file__).with_name("power.json")
FORCES, NEAR, SAME = 0.03, 0.05, 0.96
HALF = 0.5  # of the load that is held: where forces are compared
BEYOND, RATE = 2.0, 3.0  # times where ours ends: how far MuJoCo's load grows; [s] for each of them
CAUGHT = 1.02  # times the load at which the path ends: what rests under it was caught
SLOW = 10.0  # times the damping of the object, where MuJoCo is asked again
BAND = (0.9, 1.1)  # of MuJoCo's loss: between them neither is wrong to hold the object or to drop it
WAYS = {"+x": 0, "-x": 0, "+y": 1, "-y": 1, "+z": 2, "-z": 2}
HEAD = (
    f"{'case':32s} {'contacts':>8s} {'squeeze':>8s} {'half':>8s} {'handlcp':>8s} {'MuJoCo':>8s} {'apart':>8s}"
    f" {'slides':>8s} {'jump':>8s} {'slow':>8s} {'took':>17s}"
)


@dataclass(frozen=True)
class PowerCase:
    """grasp : its title in `power_grasps.json`. way : of a load of 1 N that grows."""

    grasp: str
    way: str

    @property
    def title(self):
        """Its name in the stored table."""
        return f"{self.grasp}, {self.way}"

    @property
    def wrench(self):
        """(6,)."""
        load = np.zeros(6)
        load[WAYS[self.way]] = 1.0 if self.way[0] == "+" else -1.0
        return load

    def make(self):
        """The grasp."""
        return made(read_rows(FILE)[self.grasp])


def _cases():
    """Each grasp pulled one way, all ways in turn; then the next way, and so on."""
    ways, names = list(WAYS), list(read_rows(FILE))
    return tuple(PowerCase(name, ways[(i + k) % len(ways)]) for k in range(len(ways)) for i, name in enumerate(names))


CASES = _cases()


def by_link(grasp, forces):
    """(links, 3) forces (n, 3) of contacts, summed by link."""
    links = grasp.state.hand.links_of_sites
    return np.array(
        [sum(f for f, of in zip(forces, links, strict=True) if of == link) for link in dict.fromkeys(links)]
    )


def apart(ours, theirs):
    """Largest difference, as a share of the largest force."""
    return float(np.linalg.norm(ours - theirs, axis=1).max() / max(np.linalg.norm(theirs, axis=1).max(), 1e-9))


# ----------------------------------------------------------------
# What MuJoCo says, as rows of a file.


@dataclass(frozen=True, eq=False)
class Row:
    """truth : of the limit. load : [N] under which the forces by link (links, 3) are kept; NaN where it was not held.
    squeezed (links, 3) : of the squeeze. slow : the loss of an object that is damped more [N]; NaN where not asked.
    """

    truth: Truth
    load: float
    forces: Any
    squeezed: Any
    slow: float = float("nan")

    @property
    def losses(self):
        """Between which loads the object is lost [N]; inf : not up to the largest load."""
        both = [self.truth.factor, *([] if np.isnan(self.slow) else [self.slow])]
        return min(both), max(both)

    def as_json(self):
        """As JSON."""
        held = bool(np.isfinite(self.forces).all())
        return {
            "load_N": round(self.load, 6), "forces_by_link_N": np.round(self.forces, 5).tolist() if held else None,
            "squeezed_by_link_N": np.round(self.squeezed, 5).tolist(), "limit": self.truth.row(),
        } | ({} if np.isnan(self.slow) else {"slow_N": self.slow if np.isfinite(self.slow) else None})  # fmt: skip

    @classmethod
    def read(cls, row):
        """The opposite."""
        squeezed = np.array(row["squeezed_by_link_N"])
        forces = row["forces_by_link_N"]
        found = np.full(squeezed.shape, np.nan) if forces is None else np.array(forces)
        slow = row.get("slow_N", float("nan"))
        return cls(Truth.read(row["limit"]), row["load_N"], found, squeezed, np.inf if slow is None else slow)


def theirs(case):
    """Of MuJoCo, whose load grows at a rate that hangs on what is expected."""
    grasp = case.make()
    expected = grasp.load_limit(case.wrench, max_slip=np.inf).factor
    expected = expected if 0.0 < expected < np.inf else 1.0
    most = BEYOND * expected
    limit = simulate_limit(grasp, case.wrench, most, seconds=BEYOND * RATE)
    load = HALF * min(limit.factor, limit.jump, expected)
    forces = limit.track.forces_at(load) if len(limit.track.factors) else np.full(limit.squeezed.shape, np.nan)
    return Row(Truth.of(limit, most), load, by_link(grasp, forces), by_link(grasp, limit.squeezed))


def asked_again(case, row):
    """With the loss of an object that is damped more."""
    damped = SimulatorSettings(object_damping=SLOW * SimulatorSettings().object_damping)
    most = row.truth.most
    return replace(row, slow=simulate_limit(case.make(), case.wrench, most, seconds=RATE, settings=damped).factor)


def _ends(case, grasp, limit):
    """Between which loads the object is lost, as handlcp says [N]: after a jump it may be caught again, which a loading
    beyond it tells; beyond a joint's limit, or where the path was given up, nothing is claimed.
    """
    at = {name: mark.factor for name, mark in limit.marks.items() if name in ("lost", "limit", "undecided")}
    sure = set(at) == {"lost"} and not grasp.follow(CAUGHT * at["lost"] * case.wrench).reached
    return min(at.values(), default=np.inf), at["lost"] if sure else np.inf


def stored():
    """By the titles of the cases; nothing without the file."""
    return {title: Row.read(row) for title, row in read_rows(ROWS).items()}


def store(title, row):
    """Put one row into the file."""
    rows = dict(sorted((read_rows(ROWS) | {title: row.as_json()}).items()))
    write_rows(ROWS, rows, {"mujoco": mujoco.__version__})


# ----------------------------------------------------------------
# Beside ours.


@dataclass(frozen=True, eq=False)
class Compared:
    """One case. contacts : how many. squeeze, half : by how much forces by link are apart; NaN where one holds nothing.
    ends : between which loads it is lost, as handlcp says; slides, lost : at which a contact has slid a millimetre, and
    at which the object is lost [N]. seconds : of the limit.
    """

    case: PowerCase
    row: Row
    contacts: int
    squeeze: float
    half: float
    ends: tuple[float, float]
    slides: float
    lost: float
    seconds: float

    @property
    def apart(self):
        """Of the loads at which the object is lost, as a share of MuJoCo's; 0 where the two spans meet."""
        low, high = (min(loss, self.row.truth.most) for loss in self.row.losses)
        first, last = (min(end, self.row.truth.most) for end in self.ends)
        if first <= high and low <= last:
            return 0.0
        end, near = (last, low) if last < low else (first, high)
        return end / near - 1.0 if near > 0.0 else 1.0

    @property
    def wrong(self):
        """What is not as it has to be, in words; each begins with its part of the measure."""
        found, truth = [], self.row.truth
        if not BAND[0] - 1.0 <= self.apart <= BAND[1] - 1.0:
            found.append("held or dropped")
        if not abs(self.apart) <= NEAR:
            found.append(f"loss {100 * self.apart:+.1f} %")
        if np.isfinite(truth.jump) and not (1 - NEAR) * self.slides <= truth.jump <= (1 + NEAR) * self.lost:
            found.append(f"jump at {truth.jump:.4g}")
        found += [f"forces {100 * e:.1f} %" for e in (self.squeeze, self.half) if e > FORCES]
        return found

    def __str__(self):
        t = self.row.truth
        numbers = f"{self.contacts:8d} {100 * self.squeeze:7.2f}% {100 * self.half:7.2f}% {self.ends[0]:8.3f}"
        slow = "" if np.isnan(self.row.slow) else f"{self.row.slow:.3f}"
        numbers += f" {t.factor:8.3f} {100 * self.apart:+7.2f}% {self.slides:8.3f} {t.jump:8.3f} {slow:>8s}"
        times = f"{self.seconds:6.1f} s {t.seconds:6.1f} s"
        return f"{self.case.title:32s} {numbers} {times}" + (f"  MISS: {'; '.join(self.wrong)}" if self.wrong else "")


def compared(case, row):
    """What handlcp says, beside a row."""
    grasp = case.make()
    began = perf_counter()
    limit = grasp.load_limit(case.wrench)  # goes on beyond where a contact has slid a millimetre
    took = perf_counter() - began
    ends = _ends(case, grasp, limit)
    slides, lost = (np.inf if value is None else value for value in (limit.slides, limit.lost))
    squeeze = apart(by_link(grasp, grasp.follow(order=("squeeze",)).solution.forces_world), row.squeezed)
    half = float("nan")
    if np.isfinite(row.forces).all() and (there := grasp.follow(row.load * case.wrench)).reached:
        half = apart(by_link(grasp, there.solution.forces_world), row.forces)
    return Compared(
        case, row, len(grasp.names), squeeze, half, ends, min(slides, lost, ends[0]), lost, took
    )  # fmt: skip


def main(words):
    """Print the table and what it comes to; 1 where the measure is missed."""
    if words[:1] == ["pads"]:
        return power_pads.main(words[1:])
    if words[:1] in (["--write"], ["--again"], ["--slow"]):
        return write(words[1:], words[0])
    rows, found = stored(), list[Compared]()
    print(HEAD, flush=True)
    for case in chosen(CASES, words):
        if case.title in rows:
            found.append(compared(case, rows[case.title]))
            print(found[-1], flush=True)
    return summary(found)


def summary(found):
    """Print the measure; 1 where it is missed."""
    if not found:
        return 1
    grasps = list(dict.fromkeys(c.case.grasp for c in found))
    ways, hands = {c.case.way for c in found}, dict.fromkeys(name.split(",")[0] for name in grasps)
    count = {
        part: sum(any(w.startswith(part) for w in c.wrong) for c in found)
        for part in ("held or dropped", "forces", "loss", "jump")
    }
    least, most = min(c.contacts for c in found), max(c.contacts for c in found)
    print(f"{len(found)} loads in {len(ways)} directions on {len(grasps)} grasps, {least} to {most} contacts,", end=" ")
    print(f"of {len(hands)} hands: {', '.join(hands)}")
    for part, missed in count.items():
        print(f"{part}: {len(found) - missed} of {len(found)} as they have to be")
    forces = [max(c.squeeze, 0.0 if np.isnan(c.half) else c.half) for c in found]
    print(f"forces by link: {100 * np.median(forces):.2f} % apart in the median, {100 * max(forces):.2f} % at most")
    open_ = sum(not np.isnan(c.row.slow) and np.ptp(np.minimum(c.row.losses, c.row.truth.most)) > 0.0 for c in found)
    print(f"loads whose loss hangs on damping in MuJoCo: {open_}")
    inside = power_pads.summary(grasps)
    same = len(found) - count["held or dropped"]
    right = same >= SAME * len(found) and not any(count[part] for part in ("forces", "loss", "jump"))
    return int(not (right and inside))


def write(words, how):
    """Compute rows with MuJoCo and put them into the file, one by one; 0."""
    for case in chosen(CASES, words):
        row = stored().get(case.title)
        if how == "--slow":
            if row is None or not any(w.startswith("loss") for w in compared(case, row).wrong):
                continue
            row = asked_again(case, row)
        elif row is None or how == "--again":
            row = theirs(case)
        else:
            continue
        store(case.title, row)
        truth = row.truth
        numbers = f"lost {truth.factor:8.4f} jump {truth.jump:8.4f} slow {row.slow:8.4f} {truth.seconds:6.1f} s"
        print(f"{case.title:32s} {numbers}", flush=True)
    return 0
