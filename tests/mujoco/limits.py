"""Load limits beside MuJoCo: loads that grow slowly until the object is lost, on the grasps of `limit_cases`.

`python -m tests.mujoco limits [word ...]` runs every case, or those whose titles hold one of the words, here and in
MuJoCo; exit 1 where the measure below is missed. `limits --stored` compares with the rows of `limits.json` instead, in
seconds. `limits --write` computes those rows.

However far contacts slide, both go on until the object is lost; here a path also ends at the first jump, beyond which
statics does not say whether the object is caught again.

The measure: the load at which the object is lost or first jumps within 3 % in 76 of 80 cases; MuJoCo's first jump of
more than 1 mm or 2°, or its longest hop by then, between 0.97 times the load at which a contact has slid a millimetre
and 1.03 times that at which the object is lost, in all; no load that is HELD is dropped; where NOT HELD says that the
object snaps, it has moved there by what it says within 10 %; no other load that is NOT HELD is held.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from handlcp.simulator import simulate_limit
from tests.mujoco.case import chosen
from tests.mujoco.limit_cases import CASES, LimitCase
from tests.mujoco.limit_truth import Truth, store, stored

NEAR = 0.03  # of the factor at which the object is lost
ENOUGH = 0.95  # of the cases have to be that near
MOVED = 0.1  # of the motion of an object that snaps
SQUEEZE = 0.03  # of the largest force of the squeeze
BELOW, ABOVE = 0.95, 1.05  # times MuJoCo's loss: where verdicts are asked for
BEYOND = (3.0, 10.0)  # times what is expected: how far MuJoCo's load grows, and how far where that is held
RATE = 5.0  # [s] in which it grows by what is expected
HEAD = (
    f"{'case':48s} {'handlcp':>8s} {'MuJoCo':>8s} {'apart':>8s} {'slides':>8s} {'jump':>8s} {'lost':>8s}"
    f" {'squeeze':>8s} {'0.95 / 1.05 ×':>19s} {'took':>16s}"
)


@dataclass(frozen=True, eq=False)
class Ours:
    """What handlcp says. slides, lost : where a contact has slid a millimetre, and where the object is lost; inf where
    it never does. squeezed (n, 3) : forces of the squeeze [N], world axes. seconds : of the limit.
    end : where the path ends, at a loss or at a joint's limit.
    """

    slides: float
    lost: float
    end: float
    squeezed: Any
    seconds: float


def ours(case):
    """The load limit, with the hand followed."""
    grasp = case.make()
    began = perf_counter()
    limit = grasp.load_limit(case.wrench)
    took = perf_counter() - began
    slides, lost = (np.inf if value is None else value for value in (limit.slides, limit.lost))
    ends = [mark.factor for name, mark in limit.marks.items() if name in ("lost", "limit")]
    squeezed = grasp.follow(order=("squeeze",)).solution.forces_world
    return Ours(min(slides, lost), lost, min(ends, default=np.inf), squeezed, took)


def theirs(case, rate=RATE):
    """The same in MuJoCo. Its load grows at a rate that hangs on what is expected."""
    grasp = case.make()
    marks = grasp.load_limit(case.wrench, max_slip=np.inf).marks  # the factor is 0 where the weight alone snaps
    expected = max(mark.factor for mark in marks.values())
    for beyond in BEYOND:
        limit = simulate_limit(grasp, case.wrench, beyond * expected, seconds=beyond * rate)
        if np.isfinite(limit.factor):
            break
    return Truth.of(limit, beyond * expected)


@dataclass(frozen=True, eq=False)
class Compared:
    """One case. wrong : what is not as it has to be, in words; each begins with its part of the measure."""

    case: LimitCase
    ours: Ours
    truth: Truth
    verdicts: tuple[str, ...]
    wrong: tuple[str, ...]

    @property
    def apart(self):
        """Of the factors at which the object is lost or a joint ends the path, as a share of MuJoCo's; where it jumps
        in MuJoCo and is caught again, of its first jump, if that is nearer, or of a hop, however short, that is longer
        than all before it.
        """
        one, other = self.ours.end, self.truth.factor
        for jump in (self.truth.jump, self.truth.hop_at(one, NEAR) if self.ours.lost == one else np.inf):
            if abs(one - jump) < abs(one - min(other, self.truth.most)):
                other = jump
        if not np.isfinite(other):  # it held all of the load that it was given
            return min(one / self.truth.most, 1.0) - 1.0
        return one / other - 1.0 if other > 0.0 else float("inf")

    @property
    def squeeze_error(self):
        """Largest difference of the squeeze's forces, as a share of the largest force."""
        difference = np.linalg.norm(self.ours.squeezed - self.truth.squeezed, axis=1)
        return float(difference.max() / np.linalg.norm(self.truth.squeezed, axis=1).max())

    def __str__(self):
        o, t = self.ours, self.truth
        numbers = f"{o.end:8.4f} {t.factor:8.4f} {100 * self.apart:+7.2f}%"
        numbers += f" {o.slides:8.4f} {t.jump:8.4f} {o.lost:8.4f} {100 * self.squeeze_error:7.2f}%"
        times = f"{1e3 * o.seconds:6.0f} ms {t.seconds:5.1f} s"
        line = f"{self.case.title:48s} {numbers} {' / '.join(self.verdicts):>19s} {times}"
        return line + (f"  MISS: {'; '.join(self.wrong)}" if self.wrong else "")


def compared(case, truth):
    """A case, and what of it misses the measure."""
    found = ours(case)
    wrong = list[str]()
    plain = Compared(case, found, truth, (), ())
    if not abs(plain.apart) <= NEAR:
        wrong.append(f"loss {100 * plain.apart:+.1f} %")
    first = min(truth.jump, truth.hop_at(found.lost, NEAR))
    if np.isfinite(first) and not (1 - NEAR) * found.slides <= first <= (1 + NEAR) * found.lost:
        wrong.append(f"jump at {truth.jump:.4g}")
    if plain.squeeze_error > SQUEEZE:
        wrong.append(f"squeeze {100 * plain.squeeze_error:.1f} %")
    words = list[str]()
    for share in (BELOW, ABOVE) if np.isfinite(truth.factor) and not truth.joint else ():
        word, why = judged(case, truth, share)
        words.append(word)
        wrong += [why] if why else []
    return Compared(case, found, truth, tuple(words), tuple(wrong))


def judged(case, truth, share):
    """The verdict at a share of MuJoCo's loss, and what is wrong with it."""
    load = share * truth.factor
    grasp = case.make()
    verdict = grasp.replace(load=np.array(case.wrench) * load).check(max_slip=np.inf)
    held = verdict.word != "NOT HELD"
    if held:
        return verdict.word, f"HELD at {share:g} is dropped" if share > 1.0 else ""
    said = snapped(verdict)
    if said is None:
        return verdict.word, f"NOT HELD at {share:g} is held" if share < 1.0 else ""
    moved = float(np.linalg.norm(truth.at(load)[:3]))
    off = abs(said - moved) / moved
    return "snaps", f"snaps {1e3 * said:.2f} mm at {share:g}, {1e3 * moved:.2f} there" if not off <= MOVED else ""


def snapped(verdict):
    """How far the object goes that snaps, as a verdict says it [m]; None where it does not."""
    reasons = verdict.about("slides")
    return float(reasons[0].values["moved_m"]) if reasons else None


def main(words):
    """Print the table and what it comes to; 1 where the measure is missed."""
    if words[:1] == ["--write"]:
        return write(words[1:])
    from_file = words[:1] == ["--stored"]
    rows = stored() if from_file else {}
    cases = chosen(CASES, words[1:] if from_file else words)
    print(HEAD, flush=True)
    found = list[Compared]()
    for case in cases:
        if from_file and case.title not in rows:
            print(f"{case.title:48s} not stored")
            continue
        found.append(compared(case, rows.get(case.title) or theirs(case)))
        print(found[-1], flush=True)
    return summary(found)


def summary(found):
    """Print the measure; 1 where it is missed."""
    if not found:
        return 1
    errors = [abs(c.apart) for c in found]
    count = {
        part: sum(any(w.startswith(part) for w in c.wrong) for c in found)
        for part in ("loss", "jump", "HELD", "NOT HELD", "snaps", "squeeze")
    }
    near = len(found) - count["loss"]
    print(f"{len(found)} loads of {len({c.case.hand for c in found})} hands: loss within 3 % in {near},", end=" ")
    print(f"{100 * np.median(errors):.2f} % in the median, {100 * max(errors):.3g} % at most")
    print(f"first jumps outside [0.97 slides, 1.03 lost]: {count['jump']}")
    print(f"HELD but dropped: {count['HELD']}; NOT HELD but held: {count['NOT HELD']};", end=" ")
    print(f"snaps elsewhere: {count['snaps']}")
    print(f"squeeze forces more than {100 * SQUEEZE:.0f} % apart: {count['squeeze']}")
    exact = ("jump", "HELD", "NOT HELD", "snaps")
    return int(near < ENOUGH * len(found) or any(count[part] for part in exact))


def write(words):
    """Compute rows with MuJoCo and put them into the file, one by one; 0."""
    for case in chosen(CASES, words):
        truth = theirs(case)
        store(case.title, truth)
        numbers = f"lost {truth.factor:8.4f} jump {truth.jump:8.4f} {truth.seconds:6.1f} s"
        print(f"{case.title:48s} {numbers} {truth.joint}", flush=True)
    return 0
